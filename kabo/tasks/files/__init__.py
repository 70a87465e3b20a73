"""Task files: from YAML to tasks and back, the names of stages, and reports of what planning found [T 3.7].

Files are read by the language room; here their names and types are checked against the stages there are.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kabo.tasks.files.building import TaskFile, find_task_file, load_task, load_task_file
    from kabo.tasks.files.costs import register_cost
    from kabo.tasks.files.registry import register
    from kabo.tasks.files.writing import dump_task, task_to_yaml

_HOMES = {
    "TaskFile": "building",
    "dump_task": "writing",
    "find_task_file": "building",
    "load_task": "building",
    "load_task_file": "building",
    "register": "registry",
    "register_cost": "costs",
    "task_to_yaml": "writing",
}

__all__ = [
    "TaskFile",
    "dump_task",
    "find_task_file",
    "load_task",
    "load_task_file",
    "register",
    "register_cost",
    "task_to_yaml",
]


def __getattr__(name: str) -> Any:
    """Loads the file that offers `name` when it is first asked for [PEP 562]."""
    if name not in _HOMES:
        raise AttributeError(f"module 'kabo.tasks.files' has no attribute {name!r}")
    value = getattr(import_module(f"kabo.tasks.files.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
