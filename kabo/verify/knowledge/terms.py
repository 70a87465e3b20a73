"""Terms and claims as functions of a state, whose constant arguments are evaluated once."""

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from kabo.language.formulas import (
    Application,
    Arithmetic,
    Atom,
    Claim,
    Comparison,
    Constant,
    External,
    GroundCall,
    Literal,
    Number,
    Term,
    Variable,
)
from kabo.language.problem import Problem
from kabo.plan import ValueOf
from kabo.verify.knowledge.external_procedures import asking_function
from kabo.verify.knowledge.facts import Facts
from kabo.verify.knowledge.ground import Binding, Symbol, Value, read_symbol

Question = Callable[[Facts], bool]
Reader = Callable[[Facts], "Value | None"]
Namer = Callable[[Facts], "Symbol | None"]


@dataclass(frozen=True)
class _NothingKnown:
    """A state in which nothing is known, for evaluating constants."""

    known: Mapping[Symbol, Value] = field(default_factory=dict)
    excluded: Mapping[Symbol, frozenset[Value]] = field(default_factory=dict)
    whether: frozenset[Symbol] = frozenset()

    @property
    def agent_knowledge(self) -> "Facts":
        """This state, by which conditions on knowledge are evaluated."""
        return self


_NOTHING_KNOWN = _NothingKnown()
_COMPARE = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
_COMPUTE = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


# --------------------------------------------------------------------------------------------------------- terms
def value_of(term: Term, problem: Problem, binding: Binding) -> Reader:
    """The function that reads the value of a term from a state; it returns None if the value is unknown."""
    if isinstance(term, Arithmetic):
        return _computed(term, problem, binding)
    if isinstance(term, External):
        return answered(term, problem, binding)
    namer = symbol_of(term, problem, binding)
    if namer is None:
        value = _fixed(term, binding)
        return lambda state: value
    if isinstance(namer, tuple):
        return lambda state: state.known.get(namer)

    def read(state: Facts) -> Value | None:
        symbol = namer(state)
        return None if symbol is None else state.known.get(symbol)

    return read


def _fixed(term: Term, binding: Binding) -> Value | None:
    """The value of a constant, number or bound variable; None for other terms."""
    if isinstance(term, Constant):
        return term.name
    if isinstance(term, Number):
        return term.value
    value = binding[term.name] if isinstance(term, Variable) else None
    return None if isinstance(value, ValueOf) else value


def _computed(term: Arithmetic, problem: Problem, binding: Binding) -> Reader:
    left, right = value_of(term.left, problem, binding), value_of(term.right, problem, binding)

    def compute(state: Facts) -> Value | None:
        one, two = left(state), right(state)
        if not isinstance(one, float | int) or not isinstance(two, float | int):
            return None
        if term.operator == "/" and two == 0:
            return None
        return float(_COMPUTE[term.operator](one, two))

    return compute


def answered(term: External, problem: Problem, binding: Binding) -> Reader:
    """The function that reads the answer of an external procedure; it returns None if an argument is unknown."""
    ask, readers = (
        asking_function(term, problem),
        [value_of(argument, problem, binding) for argument in term.arguments],
    )

    def answer(state: Facts) -> Value | None:
        values = tuple(read(state) for read in readers)
        return None if None in values else ask(GroundCall(term.procedure, values))  # type: ignore[arg-type]

    return answer


def symbol_of(term: Term | Atom, problem: Problem, binding: Binding) -> Symbol | Namer | None:
    """The symbol of an atom or term, or a function that finds it if inner terms depend on knowledge.

    Constants and numbers have no symbol (None); the symbol of a run-time variable is the term whose value it has.
    """
    if isinstance(term, Variable):
        value = binding.get(term.name)
        return read_symbol(value.term, problem) if isinstance(value, ValueOf) else None
    if not isinstance(term, Application | Atom):
        return None
    name = term.function if isinstance(term, Application) else term.predicate
    readers = [value_of(argument, problem, binding) for argument in term.arguments]
    if all(_is_fixed(argument, binding) for argument in term.arguments):
        return name, tuple(read(_NOTHING_KNOWN) for read in readers)  # type: ignore[misc]

    def find(state: Facts) -> Symbol | None:
        values = tuple(read(state) for read in readers)
        return None if None in values else (name, values)  # type: ignore[return-value]

    return find


def _is_fixed(term: Term, binding: Binding) -> bool:
    if isinstance(term, Variable):
        return not isinstance(binding.get(term.name), ValueOf)
    return isinstance(term, Constant | Number)


def named(namer: Symbol | Namer | None, state: Facts) -> Symbol | None:
    """The symbol that a result of `symbol_of` denotes in a state; None if the value of an argument is unknown."""
    return namer(state) if callable(namer) else namer


# -------------------------------------------------------------------------------------------------------- claims
def knows(claim: Claim, problem: Problem, binding: Binding) -> Question:
    """The function that says whether a claim is known to hold in a state, that is, K(claim)."""
    if isinstance(claim, Literal):
        return _knows_literal(symbol_of(claim.atom, problem, binding), claim.positive)
    left, right = value_of(claim.left, problem, binding), value_of(claim.right, problem, binding)
    if claim.operator in ("=", "!="):
        return _knows_equality(claim, left, right, problem, binding)
    compare = _COMPARE[claim.operator]

    def ask(state: Facts) -> bool:
        one, two = left(state), right(state)
        if not isinstance(one, float | int) or not isinstance(two, float | int):
            return False
        return bool(compare(one, two))

    return ask


def _knows_literal(namer: Symbol | Namer | None, positive: bool) -> Question:
    if isinstance(namer, tuple):
        return lambda state: state.known.get(namer) is positive

    def ask(state: Facts) -> bool:
        symbol = named(namer, state)
        return symbol is not None and state.known.get(symbol) is positive

    return ask


def _knows_equality(
    claim: Comparison, left: Reader, right: Reader, problem: Problem, binding: Binding
) -> Question:
    namers = symbol_of(claim.left, problem, binding), symbol_of(claim.right, problem, binding)
    equal = claim.operator == "="

    def ask(state: Facts) -> bool:
        one, two = left(state), right(state)
        if one is not None and two is not None:
            return (one == two) is equal
        first, second = named(namers[0], state), named(namers[1], state)
        if first is not None and first == second:
            return equal  # a term has its own value, known or not
        return not equal and (_excludes(first, two, state) or _excludes(second, one, state))

    return ask


def _excludes(symbol: Symbol | None, value: Value | None, state: Facts) -> bool:
    return symbol is not None and value is not None and value in state.excluded.get(symbol, ())
