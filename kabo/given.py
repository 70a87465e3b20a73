"""Checks of arguments: their class, numbers, names, functions, and paths; each fault is one `ArgumentError`.

A check says what was given and what was expected. Rooms call these at their doors, and trust arguments behind them.
"""

import math
import os
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Final, NoReturn

from kabo.errors import ArgumentError, Diagnostic, InputError, did_you_mean

# What makes each kind, by the name of its class, so that no room above this one is imported:
_MADE_BY: Final = {
    "Problem": "kabo.load_problem(path)",
    "Scene": "kabo.load_scene(path)",
    "Plan": "kabo.solve(problem).plan or kabo.load_plan(path)",
    "State": "kabo.after(problem, plan, history) or kabo.load_state(path)",
    "TaskReport": "kabo.plan_task(file, scene)",
    "Report": "kabo.verify(problem, plan)",
    "Mesh": "kabo.load_mesh(path)",
}
_LONGEST = 60  # characters of a value in a message
LARGEST_WHOLE = 2**63 - 1  # what kernels and readers of JSON count up to


def require_given(name: str, given: object, *kinds: type[Any] | str) -> None:
    """Checks that an argument is of one of some kinds.

    Args:
        name: of the argument.
        given: what a caller gave.
        kinds: the classes that it may be of, the one to suggest first; one by its name is not imported for that.

    Raises:
        ArgumentError: it is of none; says what it is, and which function makes what is wanted.
    """
    named = {each.__name__ for each in type(given).__mro__}
    if any(each in named if isinstance(each, str) else isinstance(given, each) for each in kinds):
        return
    first = kinds[0] if isinstance(kinds[0], str) else kinds[0].__name__
    is_there = shown(given) if given is None or isinstance(given, str) else f"of type {type(given).__name__}"
    hint = "; a result without a plan says why: result.reason" if first == "Plan" and given is None else ""
    made = f", as {_MADE_BY[first]} makes it" if first in _MADE_BY else ""
    raise ArgumentError(name, f"{name} must be a {first}{made}, and is {is_there}{hint}")


def require_all(**given: tuple[Any, ...]) -> None:
    """Checks several arguments by `require_given`: each with the kinds that it may be of.

    Raises:
        ArgumentError: one is of none of its kinds.
    """
    for name, (each, *kinds) in given.items():
        require_given(name, each, *kinds)


def require_number(
    name: str,
    given: object,
    least: float = -math.inf,
    most: float = math.inf,
    *,
    above: float | None = None,
    whole: bool = False,
    endless: bool = False,
    unit: str = "",
) -> Any:
    """The number that a caller gives, as an `int` or a `float`; `bool` is none, and neither is a text.

    Args:
        name: of the argument.
        given: what a caller gave.
        least, most: the bounds of the number.
        above: a bound that the number must exceed.
        whole: whether it must be a whole number, which is then at most `LARGEST_WHOLE`.
        endless: whether it may be infinite, as a budget without a limit.
        unit: of the number, for the message: `m` is a length.

    Raises:
        ArgumentError: it is no such number; says which is expected.
    """
    kind: Any = Integral if whole else Real
    if isinstance(given, kind) and not isinstance(given, bool):
        value: float = int(given) if whole else as_float(given)
        most = LARGEST_WHOLE if whole and value > LARGEST_WHOLE else most
        finite = whole or endless or math.isfinite(value)
        if finite and least <= value <= most and (above is None or value > above):
            return value
    what = "a whole number" if whole else "a length" if unit == "m" else "a number"
    end = f" {unit}" if unit else ""
    if above is not None:
        span = f" above {above:g}" + ("" if most == math.inf else f" and up to {most:.10g}{end}")
    elif least > -math.inf:
        span = f" from {least:.10g} " + ("on" if most == math.inf else f"to {_spelled(most)}{end}")
    else:
        span = "" if whole else ", and finite"
    refuse(name, f"{name} must be {what}{span}, not {shown(given)}")


def require_choice(name: str, given: object, known: Iterable[str]) -> None:
    """Checks that an argument is one of some words.

    Raises:
        ArgumentError: it is none; says which is nearest, or which there are.
    """
    words = tuple(known)
    if not (isinstance(given, str) and given in words):
        hint = did_you_mean(given, words) if isinstance(given, str) else None
        refuse(name, f"{name} must be one of {', '.join(words) or 'none'}, not {shown(given)}", hint)


def require_flag(name: str, given: object) -> None:
    """Checks that an argument is True or False: a text such as `no` would count as True.

    Raises:
        ArgumentError: it is neither.
    """
    if not isinstance(given, bool):
        refuse(name, f"{name} must be True or False, not {shown(given)}")


def require_flags(**given: object) -> None:
    """Checks several arguments by `require_flag`.

    Raises:
        ArgumentError: one is neither True nor False.
    """
    for name, each in given.items():
        require_flag(name, each)


def require_function(name: str, given: object) -> None:
    """Checks that an argument can be called.

    Raises:
        ArgumentError: it cannot.
    """
    if not callable(given):
        refuse(name, f"{name} must be a function, not {shown(given)}")


def require_functions(**given: object) -> None:
    """Checks that arguments can be called; None is an argument that was not given.

    Raises:
        ArgumentError: one cannot.
    """
    for name, each in given.items():
        if each is not None:
            require_function(name, each)


def require_methods(name: str, given: object, *methods: str) -> None:
    """Checks that an argument has what a protocol asks for.

    Raises:
        ArgumentError: it lacks something; says what.
    """
    lacking = [each for each in methods if not hasattr(given, each)]
    if lacking:
        refuse(name, f"{name} must have {', '.join(lacking)}, and is {shown(given)}")


def require_procedures(given: object) -> Mapping[str, Callable[..., Any]]:
    """The functions by the names of procedures that a caller gives; none of None.

    Raises:
        ArgumentError: they are no mapping, a name is no text, or something is no function.
    """
    if given is None:
        return {}
    require_given("procedures", given, Mapping)
    assert isinstance(given, Mapping)
    for name, function in given.items():
        require_given("the name of a procedure", name, str)
        require_function(f"the procedure {name}", function)
    return given


def require_path(name: str, given: object) -> Path:
    """The path that a caller gives, as a text or a `Path`.

    Raises:
        ArgumentError: it is neither, or is empty.
    """
    if isinstance(given, str | os.PathLike) and isinstance(text := os.fspath(given), str):
        if text:
            return Path(text)
        refuse(name, f"{name} must name a file, not {shown(given)}")
    refuse(name, f"{name} must be a path, not {shown(given)}")


def require_folder(name: str, given: object) -> Path:
    """The path of a folder, which need not exist yet.

    Raises:
        ArgumentError: it is no path, or holds a null character, which no name does.
    """
    path = require_path(name, given)
    if "\0" in str(path):
        refuse(name, f"{name} must name a folder, not {shown(given)}")
    return path


def require_output(name: str, given: object) -> Path:
    """The path of a file to write; its folder must exist.

    Raises:
        ArgumentError: it is no path, its folder does not exist, or it is a folder itself.
    """
    path = require_path(name, given)
    try:
        fits = path.parent.is_dir() and not path.is_dir() and "\0" not in path.name
    except OSError:  # too long a name
        fits = False
    if not fits:
        refuse(name, f"{name} must be a file in a folder that exists, not {shown(given)}")
    return path


def read_file(name: str, given: object) -> bytes:
    """The bytes of a file that a caller names.

    Raises:
        ArgumentError: it is no path.
        InputError: there is no such file, or it cannot be read.
    """
    path = require_path(name, given)
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError([missing_file(path)]) from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError([Diagnostic(str(path), 1, 1, f"the file cannot be read: {reason}")]) from None


def missing_file(path: Path) -> Diagnostic:
    """The finding about a file that is not there; the remedy is one of its folder that is called nearly so."""
    try:
        beside = [each.name for each in path.parent.iterdir()]
    except OSError:
        beside = []
    return Diagnostic(str(path), 1, 1, "there is no such file", did_you_mean(path.name, beside))


def refuse(name: str, what: str, hint: str | None = None) -> NoReturn:
    """Raises an `ArgumentError` about the argument `name`."""
    raise ArgumentError(name, what, hint)


def shown(given: object) -> str:
    """A value as messages show it, in one line and not too long; objects without a text of their own by their type."""
    if type(given).__repr__ is object.__repr__ or isinstance(given, Callable):  # type: ignore[arg-type]
        return f"one of type {type(given).__name__}"
    try:
        text = " ".join(repr(given).split())
    except ValueError:  # Python spells no whole number of more than 4,300 digits
        text = "a number of more than 4300 digits"
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _spelled(bound: float) -> str:
    return str(bound) if isinstance(bound, int) else f"{bound:.10g}"


def as_float(given: Any) -> float:
    """A real number as a float; one beyond all floats is infinite."""
    try:
        return float(given)
    except OverflowError:
        return math.inf if given > 0 else -math.inf
