"""Cost terms in task files: `cost: path_length`, `cost: {clearance: {along: true}}`, weighted sums [T 3.5].

A term is a function of a solution, or is made by a function with arguments. Terms of the core and of robots have names;
users may register others.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from inspect import signature
from types import NoneType
from typing import Any

from kabo.errors import did_you_mean
from kabo.given import require_function, require_given
from kabo.language.task_description import RISK
from kabo.tasks.core import CostTerm, Solution, TaskError, constant, offset, uniform_random, weighted
from kabo.tasks.core.model.stages import Told
from kabo.tasks.learned import MisfitError, risk

_ROBOTS = "kabo.tasks.robots"
_OF_CORE: dict[str, tuple[Callable[..., Any], bool]] = {
    "constant": (constant, True),
    "offset": (offset, True),
    "uniform_random": (uniform_random, True),
    RISK: (risk, True),
}
_OF_ROBOTS = {"path_length": False, "duration": False, "tool_distance": False, "clearance": True,
              "distance_to_reference": True}  # fmt: skip
_registered: dict[str, tuple[Callable[..., Any], bool]] = {}
SUM = "sum"


class NamedCost:
    """A cost term, together with its form in a task file."""

    def __init__(self, term: CostTerm, written: Any) -> None:
        self.term, self.written = term, written

    def __call__(self, solution: Solution) -> Told:
        """The cost of a solution, possibly with a comment and a record for programs."""
        return self.term(solution)


class NoCost(Exception):  # noqa: N818 - it is told as a finding
    """An error: a value does not describe a cost term; the message says why, `hint` what to write instead."""

    def __init__(self, problem: str, hint: str | None = None) -> None:
        super().__init__(problem)
        self.hint = hint


def register_cost(term: Callable[..., Any], name: str | None = None, *, makes: bool = False) -> Callable[..., Any]:
    """Registers a cost term for use in task files; returns it.

    Args:
        term: a cost term, that is, a function of a solution; with `makes`, a function that returns a cost term.
        name: its name in files; by default the name of the function.
        makes: whether `term` is a function that returns cost terms, instead of being one.

    Raises:
        ArgumentError: `term` is no function, or `name` no text.
        TaskError: another term has that name.
    """
    require_function("term", term)
    require_given("name", name, str, NoneType)
    name = term.__name__ if name is None else name
    earlier = _registered.get(name)
    if name in {SUM, *_OF_CORE, *_OF_ROBOTS} or (
        earlier is not None and earlier[0].__qualname__ != term.__qualname__
    ):
        raise TaskError(f"the name {name!r} of a cost term is taken")
    _registered[name] = (term, makes)
    return term


def names() -> list[str]:
    """The names of all cost terms, sorted."""
    return sorted({*_OF_CORE, *_OF_ROBOTS, *_registered, SUM})


def of_robots(name: str) -> bool:
    """Whether the cost term of that name is about robots, and so means nothing without a scene."""
    return name in _OF_ROBOTS


def cost_of(written: Any) -> NamedCost:
    """The cost term that a value describes: a name, `{name: {arguments}}`, or `{sum: {name: weight, …}}`.

    Raises:
        NoCost: the value describes no cost term.
        MisfitError: the arguments of `risk` do not fit its model.
    """
    if isinstance(written, str):
        return NamedCost(_made(written, {}), written)
    if not isinstance(written, Mapping) or len(written) != 1:
        raise NoCost("a cost term is a name, or a name with its arguments: {clearance: {along: true}}")
    ((name, arguments),) = written.items()
    if name == SUM:
        return NamedCost(_sum(arguments), written)
    if not isinstance(arguments, Mapping):
        raise NoCost(f"the arguments of the cost term {name} stand in braces: {{{name}: {{argument: value}}}}")
    return NamedCost(_made(name, arguments), written)


def written_as(cost: CostTerm) -> Any:
    """The form in which task files write a cost term; None if they cannot express it."""
    if isinstance(cost, NamedCost):
        return cost.written
    for name, (term, makes) in _terms().items():
        if term is cost and not makes:
            return name
    return None


def _terms() -> dict[str, tuple[Callable[..., Any], bool]]:
    robots = import_module(_ROBOTS) if find_spec(_ROBOTS) is not None else None
    found = {} if robots is None else {name: (getattr(robots, name), makes) for name, makes in _OF_ROBOTS.items()}
    return _OF_CORE | found | _registered


def _made(name: str, arguments: Mapping[str, Any]) -> CostTerm:
    if name not in names() or name == SUM:
        hint = did_you_mean(name, names()) or f"the cost terms are {', '.join(names())}"
        raise NoCost(f'unknown cost term "{name}"', hint)
    own = _OF_CORE | _registered
    term, makes = own[name] if name in own else _terms()[name]
    if not makes:
        if arguments:
            raise NoCost(f"the cost term {name} takes no arguments")
        return term
    _check_arguments(name, term, arguments)
    try:
        signature(term).bind(**arguments)
    except TypeError as error:
        raise NoCost(f"the cost term {name}: {error}", f"it is {name}{signature(term)}") from None
    try:
        made: CostTerm = term(**arguments)
    except MisfitError:
        raise
    except TaskError as error:
        raise NoCost(f"the cost term {name}: {error}") from None
    return made


def _check_arguments(name: str, term: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Refuses arguments that a term does not have.

    Raises:
        NoCost: names the first one, and the nearest that there is.
    """
    accepted = signature(term).parameters
    unknown = next((each for each in arguments if each not in accepted), None)
    if unknown is not None and not any(each.kind is each.VAR_KEYWORD for each in accepted.values()):
        hint = did_you_mean(unknown, accepted) or f"it has {', '.join(accepted)}"
        raise NoCost(f'the cost term {name} has no "{unknown}"', hint)


def _sum(weights: Any) -> CostTerm:
    if not isinstance(weights, Mapping) or not weights:
        raise NoCost("a sum of cost terms has weights: {sum: {path_length: 1, duration: 0.5}}")
    terms = []
    for name, weight in weights.items():
        if isinstance(weight, bool) or not isinstance(weight, int | float):
            raise NoCost(f"the weight of {name} in a sum must be a number")
        terms.append((_made(name, {}), float(weight)))
    return weighted(*terms)
