"""The names of stage classes in task files: containers, robot stages, and what users register [T 3.7]."""

from importlib import import_module
from importlib.util import find_spec
from types import NoneType
from typing import TypeVar

from kabo.errors import did_you_mean
from kabo.given import require_all
from kabo.language.task_description import LEARNED_PARAMETERS
from kabo.lazy import names_of
from kabo.tasks.core import Alternatives, Fallbacks, Limit, Serial, Stage, TaskError
from kabo.tasks.learned import LearnedParameters

_Kind = TypeVar("_Kind", bound=type[Stage])
_ROBOTS = "kabo.tasks.robots"
_CONTAINERS: dict[str, type[Stage]] = {
    "SerialContainer": Serial,
    "Alternatives": Alternatives,
    "Fallbacks": Fallbacks,
    "Limit": Limit,
}
_LEARNED: dict[str, type[Stage]] = {LEARNED_PARAMETERS: LearnedParameters}
_registered: dict[str, type[Stage]] = {}


def register(kind: _Kind, name: str | None = None) -> _Kind:
    """Registers a stage class for use in task files, by its own name or another (`mine/Grasp`); returns it.

    It can decorate a class, or a function that another decorator such as `@forward(…)` has turned into a class.

    Raises:
        ArgumentError: `kind` is no class, or `name` no text.
        TaskError: another class has that name.
    """
    require_all(kind=(kind, type), name=(name, str, NoneType))
    name = kind.__name__ if name is None else name
    earlier = find(name)
    if earlier is not None and _home(earlier) != _home(kind):
        raise TaskError(f"the name {name!r} of a stage is taken by {'.'.join(_home(earlier))}")
    _registered[name] = kind
    return kind


def _home(kind: type) -> tuple[str, str]:
    return kind.__module__, kind.__qualname__


def find(name: str) -> type[Stage] | None:
    """The stage class of that name, or None.

    Robot stages, which load compiled kernels, are imported only when needed.
    """
    found = _registered.get(name) or _CONTAINERS.get(name) or _LEARNED.get(name)
    return found if found is not None or name not in _robot_names() else _robot_stages()[name]


def names() -> list[str]:
    """The names of all stages, sorted."""
    return sorted({*_CONTAINERS, *_LEARNED, *_registered, *_robot_names()})


def _robot_names() -> list[str]:
    return names_of(import_module(f"{_ROBOTS}.stages")) if find_spec(_ROBOTS) is not None else []


def _robot_stages() -> dict[str, type[Stage]]:
    return dict(import_module(_ROBOTS).STAGES)


def name_of(kind: type[Stage]) -> str | None:
    """The name of a stage class in task files; None if it is not registered."""
    known = [*_registered.items(), *_CONTAINERS.items(), *_LEARNED.items()]
    if kind.__module__.startswith(f"{_ROBOTS}."):
        known += _robot_stages().items()
    return next((name for name, each in known if each is kind), None)


def near(name: str) -> str | None:
    """A hint for an unknown stage name: a similar name, else how to list stages and register new ones."""
    return did_you_mean(name, names()) or "kabo task stages lists them all; kabo.tasks.register adds one"
