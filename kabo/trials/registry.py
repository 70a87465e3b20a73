"""The registry of trial functions: exploration files name the functions that users have registered."""

from typing import TypeVar

from kabo.errors import did_you_mean
from kabo.exploration import ExplorationError
from kabo.trials.results import TrialFunction

_Function = TypeVar("_Function", bound=TrialFunction)
_registered: dict[str, TrialFunction] = {}


def register(function: _Function, name: str | None = None) -> _Function:
    """Registers a trial function for use in exploration files, by its own name or another (`mine/Lift`); returns it.

    It can decorate a function, or any object that can be called as one.

    Raises:
        ExplorationError: it cannot be called, or has no name, or another function has that name.
    """
    name = getattr(function, "__name__", None) if name is None else name
    if not callable(function) or not isinstance(name, str) or not name.strip():
        raise ExplorationError("a trial is registered as a function of case, parameters and seed, with a name")
    earlier = _registered.get(name)
    if earlier is not None and _home(earlier) != _home(function):
        raise ExplorationError(f"the name {name!r} of a trial is taken by {'.'.join(_home(earlier))}")
    _registered[name] = function
    return function


def _home(function: TrialFunction) -> tuple[str, str]:
    named = function if hasattr(function, "__qualname__") else type(function)
    return named.__module__, named.__qualname__


def find(name: str) -> TrialFunction | None:
    """The trial function of that name, or None."""
    return _registered.get(name)


def names() -> list[str]:
    """The names of all trial functions, sorted."""
    return sorted(_registered)


def near(name: str) -> str:
    """A hint for an unknown name: a similar name, or all names, or how to register a function."""
    known = names()
    if not known:
        return "--stages FILE.py executes a file that registers it: kabo.trials.register(function, name)"
    return did_you_mean(name, known) or f"there are {', '.join(known)}"
