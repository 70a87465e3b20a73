"""Queries on worlds: K(claim) holds if the claim is true in every world that agrees with what was observed.

A perfect reasoner knows every such claim. kabo's own inference may know fewer, but at least those of the explicit
belief. If a condition depends on this difference, worlds cannot judge the plan. A query is evaluated in three
ways:

- *perfect*: K means true in all worlds. The conditions of a plan must hold in this sense.
- *perfect in favour*: K means true in all worlds where knowing helps, and explicitly believed where it hurts (below
  `not`). A condition that is false even so is false for every reasoner.
- *explicit in favour*: K means explicitly believed where knowing helps, and true in all worlds where it hurts.
  A condition that is true even so is true for every reasoner.
"""

from collections.abc import Callable, Iterable
from typing import Protocol

from kabo.language.formulas import (
    And,
    Claim,
    Comparison,
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
from kabo.verify.knowledge.ground import Binding, Symbol, instances
from kabo.verify.knowledge.terms import Namer, Question, knows, symbol_of
from kabo.verify.knowledge.worlds.world import CannotJudgeError

INFERENCE = "what is asked for must not be known, and it follows only from several facts together"


class Knower(Protocol):
    """The interface by which queries ask a reasoner what is known, or will be known at run time."""

    def knows(self, claim: Question, at_start: bool, compared: frozenset[Symbol]) -> bool:
        """Whether a claim about the present, or about the start, is known; `compared` are the terms that it compares."""

    def will_know(self, name: "Symbol | Namer | None", at_start: bool) -> bool:
        """Whether the value of an atom or term is known, or will be known at run time."""

    def always_held(self, number: int) -> bool:
        """Whether the `always` goal of this number has held in every state so far."""


Knowers = tuple[Knower, Knower]  # the reasoner asked where knowing helps, and the one asked where it hurts
Query = Callable[[Knowers], bool]
Temporals = Callable[
    [Temporal, Binding], int
]  # records a temporal formula; returns the number of an `always` goal


def query(
    formula: Formula,
    problem: Problem,
    binding: Binding,
    temporal: Temporals | None = None,
    *,
    helps: bool = True,
    at_start: bool = False,
) -> Query:
    """Compiles a query to a function of two reasoners: one is asked where knowing helps, the other where it hurts.

    Args:
        formula: the query.
        problem: the problem to which the query belongs.
        binding: the values of parameters and variables.
        temporal: the function that numbers `always(…)`; None where temporal formulas are not allowed.
        helps: whether more knowledge can only make the query true; False below `not`.
        at_start: whether the query is about the start.

    Raises:
        CannotJudgeError: the query calls a procedure.
    """

    def inside(part: Formula, more: Binding = binding, *, same: bool = True) -> Query:
        return query(part, problem, more, temporal, helps=helps is same, at_start=at_start)

    who = 0 if helps else 1
    match formula:
        case Know(claim):
            asked = knows(claim, problem, binding)
            about = _compared(claim, problem, binding)
            return lambda knowers: knowers[who].knows(asked, at_start, about)
        case KnowWhether(thing) | KnowValue(thing):
            name = symbol_of(thing, problem, binding)
            return lambda knowers: knowers[who].will_know(name, at_start)
        case Truth(value):
            return lambda knowers: value
        case Not(body):
            denied = inside(body, same=False)
            return lambda knowers: not denied(knowers)
        case And(parts):
            return _all(map(inside, parts))
        case Or(parts):
            return _any(map(inside, parts))
        case Xor(first, second):
            one, other = inside(first), inside(second)
            no_one, no_other = inside(first, same=False), inside(second, same=False)
            return lambda knowers: (
                (one(knowers) and not no_other(knowers)) or (other(knowers) and not no_one(knowers))
            )
        case Forall(variables, body):
            return _all(inside(body, more) for more in instances(problem, variables, binding))
        case Exists(variables, body):
            return _any(inside(body, more) for more in instances(problem, variables, binding))
        case Temporal(kind, body) if temporal is not None:
            number = temporal(formula, binding)
            if kind == "initially":
                return query(body, problem, binding, helps=helps, at_start=True)
            return lambda knowers: knowers[who].always_held(number)
        case Test(call) if problem.scene is None and not isinstance(call, External):
            return lambda knowers: True  # without a scene every geometric test succeeds
    raise CannotJudgeError("a condition asks a procedure, or what is not a matter of knowledge")


def _compared(claim: Claim, problem: Problem, binding: Binding) -> frozenset[Symbol]:
    """The terms that a claim compares with each other, whose values must be enumerated together."""
    if not isinstance(claim, Comparison):
        return frozenset()
    names = [symbol_of(side, problem, binding) for side in (claim.left, claim.right)]
    return frozenset(name for name in names if isinstance(name, tuple)) if None not in names else frozenset()


def _all(parts: Iterable[Query]) -> Query:
    whole = tuple(parts)
    return whole[0] if len(whole) == 1 else lambda knowers: all(part(knowers) for part in whole)


def _any(parts: Iterable[Query]) -> Query:
    whole = tuple(parts)
    return whole[0] if len(whole) == 1 else lambda knowers: any(part(knowers) for part in whole)


def asks_procedures(tree: object) -> bool:
    """Whether a term of a formula or effect is the answer of an external procedure."""
    if isinstance(tree, External):
        return True
    if isinstance(tree, tuple | list):
        return any(map(asks_procedures, tree))
    return any(map(asks_procedures, vars(tree).values())) if hasattr(tree, "__dataclass_fields__") else False


def required(asked: Query, perfect: Knower, explicit: Knower) -> bool:
    """Whether a condition of a plan holds.

    Raises:
        CannotJudgeError: the condition fails for a perfect reasoner, but may hold for kabo's own inference.
    """
    if asked((perfect, perfect)):
        return True
    if asked((perfect, explicit)):
        raise CannotJudgeError(INFERENCE)
    return False


def fires(asked: Query, perfect: Knower, explicit: Knower) -> bool:
    """Whether the condition of an effect (`query => …`) holds.

    Raises:
        CannotJudgeError: whether the condition holds depends on how much a reasoner infers.
    """
    if asked((explicit, perfect)):
        return True
    if asked((perfect, explicit)):
        raise CannotJudgeError(
            "an effect depends on what is known, and that follows only from several facts together"
        )
    return False
