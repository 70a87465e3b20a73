"""Knowledge as dictionaries and sets, and what formulas and effects mean on them [DESIGN section 3; P].

Written to be obvious, not fast, and on its own: the planner's bit sets must agree with it, not it with them.
A predicate is a function with the values true and false, so atoms and function terms are treated alike.
"""

import operator
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from kabo.language.formulas import (
    And,
    Application,
    Arithmetic,
    Atom,
    Claim,
    Comparison,
    Constant,
    Exists,
    Forall,
    Formula,
    Know,
    KnowValue,
    KnowWhether,
    Literal,
    Not,
    Number,
    Or,
    Term,
    Truth,
    Variable,
    Xor,
)
from kabo.language.problem import Problem
from kabo.plan import ValueOf

Value = bool | str | float | ValueOf
Symbol = tuple[str, tuple[Value, ...]]  # a ground atom or function term
Binding = Mapping[str, Value]  # parameters and quantified variables
Frozen = tuple[frozenset[tuple[Symbol, Value]], frozenset[tuple[Symbol, Value]], frozenset[Symbol]]

_COMPARE = {"<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge}
_COMPUTE = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}


class NotVerifiableError(Exception):
    """Something that this interpreter does not judge: the plan is then not verified, and the report says why."""


@dataclass(frozen=True)
class Knowledge:
    """What is known: values of atoms and terms (Kf), values that they do not have, what will be known (Kw, Kv)."""

    known: Mapping[Symbol, Value]
    excluded: frozenset[tuple[Symbol, Value]] = frozenset()
    whether: frozenset[Symbol] = frozenset()

    def frozen(self) -> Frozen:
        """The state as a value that sets can hold."""
        return frozenset(self.known.items()), self.excluded, self.whether

    def will_be_known(self, symbol: Symbol) -> bool:
        """Kw of an atom, Kv of a term: known, or known at run time."""
        return symbol in self.known or symbol in self.whether


def instances(problem: Problem, variables: Iterable[Variable], binding: Binding) -> Iterator[Binding]:
    """The bindings that add every instance of the variables, in the order of declaration."""
    variables = tuple(variables)
    for values in product(*(problem.of_type(variable.type) for variable in variables)):
        yield {**binding, **{variable.name: value for variable, value in zip(variables, values, strict=True)}}


def value_of(term: Term, state: Knowledge, binding: Binding) -> Value | None:
    """The known value of a term; None if it is not known."""
    if isinstance(term, Constant):
        return term.name
    if isinstance(term, Variable):
        return binding[term.name]
    if isinstance(term, Number):
        return term.value
    if isinstance(term, Application):
        symbol = symbol_of(term.function, term.arguments, state, binding)
        return None if symbol is None else state.known.get(symbol)
    return _computed(term, state, binding)


def _computed(term: Arithmetic, state: Knowledge, binding: Binding) -> Value | None:
    left, right = value_of(term.left, state, binding), value_of(term.right, state, binding)
    if not isinstance(left, float | int) or not isinstance(right, float | int):
        return None
    if term.operator == "/" and right == 0:
        return None
    return float(_COMPUTE[term.operator](left, right))


def symbol_of(name: str, arguments: Iterable[Term], state: Knowledge, binding: Binding) -> Symbol | None:
    """The ground atom or term; None if the value of an argument is not known before run time."""
    values = tuple(value_of(argument, state, binding) for argument in arguments)
    if any(value is None or isinstance(value, ValueOf) for value in values):
        return None
    return name, values  # type: ignore[return-value]


def text_of(symbol: Symbol) -> str:
    """A ground atom or term as plans write it: `f(a, b)`, or `f` without arguments."""
    name, arguments = symbol
    return f"{name}({', '.join(map(_shown, arguments))})" if arguments else name


def _shown(value: Value) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def knows(claim: Claim, state: Knowledge, binding: Binding) -> bool:
    """K(claim): the claim is known to hold."""
    if isinstance(claim, Literal):
        symbol = symbol_of(claim.atom.predicate, claim.atom.arguments, state, binding)
        return symbol is not None and state.known.get(symbol) is claim.positive
    left, right = value_of(claim.left, state, binding), value_of(claim.right, state, binding)
    if claim.operator == "=":
        return (left is not None and left == right) or _is_its_own_value(claim, state, binding)
    if claim.operator == "!=":
        if left is not None and right is not None:
            return left != right and not isinstance(left, ValueOf) and not isinstance(right, ValueOf)
        return _excludes(claim.left, right, state, binding) or _excludes(claim.right, left, state, binding)
    if not isinstance(left, float | int) or not isinstance(right, float | int):
        return False
    return bool(_COMPARE[claim.operator](left, right))


def _is_its_own_value(claim: Comparison, state: Knowledge, binding: Binding) -> bool:
    """`f(x) = c` where c is the run-time value of f(x) itself."""
    for term, other in ((claim.left, claim.right), (claim.right, claim.left)):
        value = value_of(other, state, binding)
        if isinstance(term, Application) and isinstance(value, ValueOf):
            symbol = symbol_of(term.function, term.arguments, state, binding)
            if symbol is not None and text_of(symbol) == value.term:
                return True
    return False


def _excludes(term: Term, value: Value | None, state: Knowledge, binding: Binding) -> bool:
    if not isinstance(term, Application) or value is None:
        return False
    symbol = symbol_of(term.function, term.arguments, state, binding)
    return symbol is not None and (symbol, value) in state.excluded


def holds(formula: Formula, problem: Problem, state: Knowledge, binding: Binding) -> bool:
    """Whether a query holds in a knowledge state; conjunctions and disjunctions short-circuit in their order.

    Raises:
        NotVerifiableError: the formula calls a geometric test, or speaks of other states.
    """

    def holds_here(part: Formula, more: Binding = binding) -> bool:
        return holds(part, problem, state, more)

    match formula:
        case Know(claim):
            return knows(claim, state, binding)
        case KnowWhether(atom):
            return _will_be_known(atom, state, binding)
        case KnowValue(term):
            return _will_be_known(term, state, binding)
        case Truth(value):
            return value
        case Not(body):
            return not holds_here(body)
        case And(parts):
            return all(map(holds_here, parts))
        case Or(parts):
            return any(map(holds_here, parts))
        case Xor(first, second):
            return holds_here(first) != holds_here(second)
        case Forall(variables, body):
            return all(holds_here(body, more) for more in instances(problem, variables, binding))
        case Exists(variables, body):
            return any(holds_here(body, more) for more in instances(problem, variables, binding))
    raise NotVerifiableError(
        f"{_NAMES.get(type(formula).__name__, 'this formula')} is not judged by this verifier"
    )


_NAMES = {"Test": "a geometric test inside a formula", "Temporal": "initially(…) or always(…)"}


def _will_be_known(thing: Atom | Application, state: Knowledge, binding: Binding) -> bool:
    name = thing.predicate if isinstance(thing, Atom) else thing.function
    symbol = symbol_of(name, thing.arguments, state, binding)
    return symbol is not None and state.will_be_known(symbol)


def possible_values(problem: Problem, symbol: Symbol, state: Knowledge) -> tuple[Value, ...] | None:
    """The values that an atom or term may still have, in the order in which plans branch; None for numbers."""
    if symbol in state.known:
        return (state.known[symbol],)
    if symbol[0] in problem.domain.predicates:
        return (False, True)
    values = problem.values_of(symbol[0])
    return None if values is None else tuple(v for v in values if (symbol, v) not in state.excluded)
