"""Arguments that are not of the kind that a function takes, as the path of a file that is to be loaded first."""

from typing import Any, Final

# What makes each kind, by the name of its class, so that no room above this one is imported:
_MADE_BY: Final = {
    "Problem": "kabo.load_problem(path)",
    "Scene": "kabo.load_scene(path)",
    "Plan": "kabo.solve(problem).plan or kabo.load_plan(path)",
    "State": "kabo.after(problem, plan, history) or kabo.load_state(path)",
}


def require_given(name: str, given: object, *kinds: type[Any]) -> None:
    """Checks that an argument is of one of some kinds.

    Args:
        name: of the argument.
        given: what a caller gave.
        kinds: the classes that it may be of, the one to suggest first.

    Raises:
        TypeError: it is of none; says what it is, and which function makes what is wanted.
    """
    if isinstance(given, kinds):
        return
    first = kinds[0].__name__
    is_there = f"{given!r}" if given is None or isinstance(given, str) else f"of type {type(given).__name__}"
    hint = "; a result without a plan says why: result.reason" if first == "Plan" and given is None else ""
    made = f", as {_MADE_BY[first]} makes it" if first in _MADE_BY else ""
    raise TypeError(f"{name} must be a {first}{made}, and is {is_there}{hint}")
