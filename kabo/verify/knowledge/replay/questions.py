"""Queries on knowledge: each formula becomes a function of a state, its quantifiers unrolled once [K 3.3.1].

Conjunctions and disjunctions are evaluated from left to right, until a part decides the result.
"""

from collections.abc import Callable, Iterable

from kabo.language.formulas import (
    And,
    Exists,
    External,
    Forall,
    Formula,
    Know,
    KnowValue,
    KnowWhether,
    Not,
    Or,
    Temporal,
    Test,
    Truth,
    Xor,
)
from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import Facts, will_be_known
from kabo.verify.knowledge.ground import Binding, NotVerifiableError, Symbol, instances
from kabo.verify.knowledge.terms import Namer, Question, answered, knows, named, symbol_of


def question(
    formula: Formula, problem: Problem, binding: Binding, temporal: Callable[..., Question] | None = None
) -> Question:
    """A function of a state that says whether the query holds in it.

    Args:
        formula: the query.
        problem: the problem to which the query belongs.
        binding: the values of parameters and variables.
        temporal: makes the function of `initially(…)` or `always(…)` under a binding; None where they are not allowed.

    Raises:
        NotVerifiableError: the formula calls a geometric test, or is temporal outside of a goal.
    """

    def inside(part: Formula, more: Binding = binding) -> Question:
        return question(part, problem, more, temporal)

    match formula:
        case Know(claim):
            return knows(claim, problem, binding)
        case KnowWhether(thing) | KnowValue(thing):
            return _will_be_known(symbol_of(thing, problem, binding))
        case Truth(value):
            return lambda state: value
        case Not(body):
            inner = inside(body)
            return lambda state: not inner(state)
        case And(parts):
            return _all(map(inside, parts))
        case Or(parts):
            return _any(map(inside, parts))
        case Xor(first, second):
            one, two = inside(first), inside(second)
            return lambda state: one(state) != two(state)
        case Forall(variables, body):
            return _all(inside(body, more) for more in instances(problem, variables, binding))
        case Exists(variables, body):
            return _any(inside(body, more) for more in instances(problem, variables, binding))
        case Test(External() as external):
            answer = answered(external, problem, binding)
            return lambda state: answer(state) is True
        case Test() if problem.scene is None:
            return lambda state: True  # without a scene every geometric test succeeds
        case Temporal() if temporal is not None:
            return temporal(formula, binding)
    raise NotVerifiableError(f"{_NAMES.get(type(formula), 'this formula')} is not judged by this verifier")


_NAMES: dict[type, str] = {Test: "a geometric test inside a formula", Temporal: "initially(…) or always(…)"}


def _all(parts: Iterable[Question]) -> Question:
    whole = tuple(parts)
    return whole[0] if len(whole) == 1 else lambda state: all(part(state) for part in whole)


def _any(parts: Iterable[Question]) -> Question:
    whole = tuple(parts)
    return whole[0] if len(whole) == 1 else lambda state: any(part(state) for part in whole)


def _will_be_known(namer: Symbol | Namer | None) -> Question:
    if isinstance(namer, tuple):
        return lambda state: will_be_known(namer, state)

    def ask(state: Facts) -> bool:
        symbol = named(namer, state)
        return symbol is not None and will_be_known(symbol, state)

    return ask
