"""Ground atoms, terms and claims, of which knowledge and worlds consist, and how plans write them.

A predicate is a function with the values true and false, so atoms and function terms are treated alike, and a claim
always says that a symbol has, or does not have, a value.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from kabo.language.formulas import Formula, Variable
from kabo.language.problem import Problem
from kabo.plan import ValueOf

Value = bool | str | float
Symbol = tuple[str, tuple[Value, ...]]  # a ground atom or function term
GroundClaim = tuple[Symbol, Value, bool]  # the symbol has the value (True), or does not (False; functions only)
Binding = Mapping[str, "Value | ValueOf"]  # parameters and quantified variables
Entry = frozenset[GroundClaim]  # the members of an entry of Kx or Kor
Observable = Symbol | tuple[GroundClaim, ...]  # an atom, a term or a conjunction on which a plan branches

_GROUND = re.compile(r"([a-z][a-z0-9_]*)(?:\(([^()]*)\))?")


class NotVerifiableError(Exception):
    """The plan uses something that the verifier does not judge; it is then not verified, and the report says why."""


def instances(problem: Problem, variables: Iterable[Variable], binding: Binding) -> Iterator[Binding]:
    """The binding, extended by each combination of objects for the variables, in the order of declaration."""
    variables = tuple(variables)
    for values in product(*(problem.of_type(variable.type) for variable in variables)):
        yield {**binding, **{variable.name: value for variable, value in zip(variables, values, strict=True)}}


def is_predicate(problem: Problem, symbol: Symbol) -> bool:
    """Whether the symbol is an atom, not a function term."""
    return symbol[0] in problem.domain.predicates


def range_of(problem: Problem, symbol: Symbol) -> tuple[Value, ...] | None:
    """All values that an atom or term can have, in the order in which plans branch; None for numbers."""
    if is_predicate(problem, symbol):
        return (False, True)
    return problem.values_of(symbol[0])


def denied(problem: Problem, claim: GroundClaim) -> GroundClaim:
    """The complement of a claim: `not p` for `p`, `f != v` for `f = v`, and the reverse."""
    symbol, value, positive = claim
    if is_predicate(problem, symbol):
        return symbol, not value, True
    return symbol, value, not positive


def text_of(symbol: Symbol) -> str:
    """A ground atom or term as plans write it: `f(a, b)`, or `f` without arguments."""
    name, arguments = symbol
    return f"{name}({', '.join(map(value_text, arguments))})" if arguments else name


def value_text(value: Value) -> str:
    """A value as plans write it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)


def claim_text(claim: GroundClaim) -> str:
    """A claim as formulas write it: `p(a)`, `not p(a)`, `f(a) = v`, `f(a) != v`."""
    symbol, value, positive = claim
    if isinstance(value, bool):
        return text_of(symbol) if value else f"not {text_of(symbol)}"
    return f"{text_of(symbol)} {'=' if positive else '!='} {value_text(value)}"


def conjunction_text(claims: Iterable[GroundClaim]) -> str:
    """A conjunction as plans write it in `on`: `a(x) and b(y)`."""
    return " and ".join(map(claim_text, claims))


def read_symbol(text: str, problem: Problem) -> Symbol | None:
    """The ground atom or term of a text `f(a, b)`; None if the domain has no such atom or term."""
    match = _GROUND.fullmatch(text)
    if match is None:
        return None
    name, inner = match.groups()
    values: list[Value] = [] if inner is None else [_read_value(part.strip()) for part in inner.split(",")]
    domain = problem.domain
    types = domain.predicates.get(name)
    if types is None and name in domain.functions:
        types = domain.functions[name].arguments
    if types is None or len(types) != len(values):
        return None
    return name, tuple(values)


def read_conjunction(text: str, problem: Problem) -> tuple[GroundClaim, ...] | None:
    """The claims of a text `a(x) and not b(y)`; None for a single atom or term, or for any other text."""
    claims: list[GroundClaim] = []
    for part in text.split(" and "):
        negative = part.startswith("not ")
        symbol = read_symbol(part.removeprefix("not "), problem)
        if symbol is None or not is_predicate(problem, symbol):
            return None
        claims.append((symbol, not negative, True))
    return tuple(claims) if len(claims) > 1 or not claims[0][1] else None


def read_observable(text: str, problem: Problem) -> Observable | None:
    """The atom, term or conjunction that a plan's `on` or `delivers` names; None if there is none."""
    return read_symbol(text, problem) or read_conjunction(text, problem)


def is_symbol(thing: Observable) -> bool:
    """Whether an observable is an atom or term, not a conjunction."""
    return isinstance(thing[0], str)


def observable_text(thing: Observable) -> str:
    """An atom, term or conjunction as plans write it."""
    return text_of(thing) if is_symbol(thing) else conjunction_text(thing)  # type: ignore[arg-type]


def outcome_text(value: Value) -> str:
    """The outcome of a branch as plans write it."""
    return value_text(value)


def because(formula: Formula) -> str:
    """The place of a formula in its file, as the end of a message."""
    place = getattr(formula, "place", None)
    return "" if place is None else f" ({place.file}:{place.line}:{place.column})"


def _read_value(text: str) -> Value:
    try:
        return float(text)
    except ValueError:
        return text
