"""The tasks room: Task Construction, the language in which geometric procedures are written [T ch. 3].

`core` knows no robot and nothing of kabo; `robots` has the stages that ask the geometry server; `files` reads and
writes task files; `library` holds the tasks that domains may call.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from kabo.tasks import core

if TYPE_CHECKING:
    from kabo.tasks.core import *  # noqa: F403
    from kabo.tasks.files import *  # noqa: F403

_FILES = ("TaskFile", "dump_task", "load_task", "load_task_file", "register", "register_cost", "task_to_yaml")
__all__ = sorted([*core.__all__, *_FILES])  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Names of the core are there at once, those of files when first asked for [PEP 562]."""
    if name not in __all__:
        raise AttributeError(f"module 'kabo.tasks' has no attribute {name!r}")
    value = getattr(import_module("kabo.tasks.files") if name in _FILES else core, name)
    globals()[name] = value
    return value
