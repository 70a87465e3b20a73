"""Lazy imports of packages: public names are listed once, in a stub, and import their file when first used.

The `__init__.py` of a lazy package has a stub `__init__.pyi` in the same folder, with one line for each name:

    from kabo.room.file import name as name

Type checkers read the stub like any other stub; `lazy_names` reads it when the package is imported. A line
`from kabo.room import *` re-exports every name of another package [PEP 484, stubs; PEP 562], and the stub of `kabo.room`
offers a package inside it by `from kabo.room import inner as inner`.
"""

import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

FORM = "from module import name as name"


def lazy_names(
    room: str, file: str, *, rooms: Sequence[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` of a room whose names stand in the stub beside `file`; it has an `__all__`, too.

    `dir` lists what the room offers, and nothing that happens to be imported.

    Args:
        room: its `__name__`.
        file: its `__file__`.
        rooms: names of the stub that are also called like a room inside this one. These rooms are imported now: Python
            binds a package to its name at the first import only, so that later imports leave the name what the stub
            says.

    Raises:
        SyntaxError: an import of the stub is not written in one of the two forms.
    """
    homes, whole = _homes(file + "i")
    for name in rooms:
        import_module(f"{room}.{name}")
        delattr(sys.modules[room], name)

    def load(name: str) -> object:
        if name == "__all__":
            value: object = sorted({*homes, *(name for each in whole for name in names_of(import_module(each)))})
        elif homes.get(name) == room:
            value = import_module(f"{room}.{name}")
        else:
            value = getattr(import_module(home_of(name)), name)
        setattr(sys.modules[room], name, value)
        return value

    def home_of(name: str) -> str:
        if name in homes:
            return homes[name]
        # Python asks any module for `__path__` and its like, and a package for a file before it imports that.
        if whole and not name.startswith("__") and find_spec(f"{room}.{name}") is None:
            for each in whole:
                if name in names_of(import_module(each)):
                    return each
        where = sys.modules[room]
        raise AttributeError(f"module {room!r} has no attribute {name!r}", name=name, obj=where)

    def offered() -> list[str]:
        special = (name for name in vars(sys.modules[room]) if name.startswith("__"))
        return sorted({*special, *names_of(sys.modules[room])})

    return load, offered


def names_of(room: ModuleType) -> list[str]:
    """The public names of a lazy package, read from its stub without importing any of them."""
    return list(room.__all__)


def _homes(stub: str) -> tuple[dict[str, str], list[str]]:
    """For every name that a stub offers, the module that has it; and the rooms of which it offers all names.

    Lines are compared, not parsed: importing `ast` takes as long as importing kabo.
    """
    homes: dict[str, str] = {}
    whole = []
    with open(stub, encoding="utf-8") as lines:
        for number, line in enumerate(lines, 1):
            words = line.split("#")[0].split()
            if not words or words[0] not in ("from", "import"):
                continue
            if words[::2] == ["from", "import"] and words[3] == "*":
                whole.append(words[1])
            elif words[::2] == ["from", "import", "as"] and words[3] == words[5]:
                homes[words[5]] = words[1]
            else:
                raise SyntaxError(f"{stub}:{number}: an import here is written `{FORM}`, in a line of its own")
    return homes, whole
