"""Compilation of array kernels: `kernel` and its variants are the only decorators through which kabo uses numba.

numba's cache notices changes only in a kernel's own file: a caller would keep the old code of the kernels it
calls. So compiled code is stored in a folder named after a hash of *all* kernel sources and of the compiler
settings. fastmath is off, because reordering could undo a proof [docs/decisions/001-kernels.md], and because what LLVM
makes of the permission depends on what it compiled before: two caches would give plans that differ in a last place.
Kernels that a kernel calls are linked into it [kabo.compilation.linking].
"""

import hashlib
import math
import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from kabo.compilation.cache import cache_folder

_Function = TypeVar("_Function", bound=Callable[..., Any])


@cache
def _sources_digest() -> str:
    """A hash of the sources of all kernels, of the code that compiles them, and of the tuples that kernels take."""
    digest, here = hashlib.sha256(), Path(__file__).parent
    tuples = here.parent / "scene" / "tree.py"
    for source in (*sorted(here.glob("*.py")), *sorted(here.parent.glob("**/kernels/*.py")), tuples):
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def _folder() -> Path:
    return cache_folder() / "compiled" / _sources_digest()


def usual_kernels_compiled() -> bool:
    """Whether `note_compiled` was called on this machine, with these kernels and this numba."""
    return _mark().is_file()


def note_compiled() -> None:
    """Records that the kernels that planning needs have been compiled."""
    with suppress(OSError):  # a read-only cache costs time, never an answer
        _mark().touch()


def _mark() -> Path:
    """The file that records it: one for each installation, as numba keeps what it compiles by the place of the sources."""
    place = hashlib.sha256(str(Path(__file__).parent).encode()).hexdigest()[:8]
    return _folder() / f"numba-{version('numba')}-usual-{place}"


@cache
def _numba() -> Any:
    folder = _folder()
    os.environ.setdefault("NUMBA_CACHE_DIR", str(folder))  # read once, when numba is imported
    os.environ.setdefault("NUMBA_CPU_NAME", os.environ.get("KABO_CPU", "host"))
    if os.environ["NUMBA_CPU_NAME"] == "host":
        del os.environ["NUMBA_CPU_NAME"]
    import numba  # here, as it takes most of a second, and reads these settings when it is imported

    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010  the module makes its names at run time
    from kabo.compilation.lane_lowering import teach_lanes  # after numba
    from kabo.compilation.lowering import teach_window

    teach_window(window)
    teach_lanes()
    return numba


def window(flat: Any, start: int, shape: tuple[int, ...]) -> Any:
    """A view of a flat array from index `start` on, as a contiguous array of the given shape; free in kernels.

    Kernels do not check that the flat array is long enough.
    """
    return flat[start : start + math.prod(shape)].reshape(shape)


def _compiled(function: _Function, **options: Any) -> _Function:
    numba = _numba()
    if numba.config.DISABLE_JIT:
        return function
    options = {**_OPTIONS, **options}
    if not _links():
        compiled: _Function = numba.njit(cache=True, **options)(function)
        return compiled
    from kabo.compilation.linking import linked  # after numba

    whole: _Function = linked(function, options, stored=True)
    return whole


_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


@cache
def _links() -> bool:
    """Whether kernels are linked from parts; a file in the cache records that this numba can do it."""
    numba = _numba()
    tried = Path(numba.config.CACHE_DIR) / f"numba-{numba.__version__}-links"
    if tried.exists():
        return True
    from kabo.compilation.linking import linking_works  # after numba

    works = linking_works(_OPTIONS)
    if works:
        tried.parent.mkdir(parents=True, exist_ok=True)
        tried.touch()
    return works


def kernel(function: _Function) -> _Function:
    """Compiles `function` for plain arrays and numbers; `.py_func` is the Python original."""
    return _compiled(function)


def lean_kernel(function: _Function) -> _Function:
    """As `kernel`, but without reference counting: for functions that, with all their callees, create no array.

    Counting costs some nanoseconds for each array at each call, which matters in nested kernels of many arrays.
    """
    return _compiled(function, _nrt=False)


def brief_kernel(function: _Function) -> _Function:
    """As `lean_kernel`, but keeps Python's lock: for kernels of a microsecond, of which releasing it is a twentieth."""
    return _compiled(function, _nrt=False, nogil=False)


def call_first(kernel: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a kernel that from its first call on takes no arguments of other types.

    They raise a TypeError; so callers need not look at arguments beforehand, which may take a tenth of the time.
    """
    result, made = kernel(*arguments), getattr(kernel, "overloads", None)
    if made and len(made) == 1:
        kernel.disable_compile()  # type: ignore[attr-defined]
    return result


def settled(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel whose arguments have the same types at each call: they are looked at the first time alone.

    To look at them, bundles of arrays above all, takes longer than a kernel of some microseconds. Nothing notices other
    ones: whoever calls gives the same arrays each time, or some of the same type of elements, number of axes and layout.
    """
    settled_for: Callable[..., Any] | None = None

    def call(*arguments: Any) -> Any:
        nonlocal settled_for
        if settled_for is None:
            made: Any = kernel
            is_python = not hasattr(made, "compile")  # where compiling is switched off
            settled_for = made if is_python else made.compile(tuple(map(made.typeof_pyval, arguments)))
        return settled_for(*arguments)

    return call


def leaf_kernel(function: _Function) -> _Function:
    """As `kernel`, for small functions that every caller inlines."""
    inlined: _Function = _numba().njit(cache=True, nogil=True, error_model="numpy", inline="always")(function)
    return inlined


def joined_kernel(function: _Function) -> _Function:
    """As `lean_kernel`, and LLVM copies it into its callers: for kernels that take less time than their arguments.

    An array is seven arguments or more, and a bundle of arrays dozens.
    """
    return _compiled(function, _nrt=False, forceinline=True)
