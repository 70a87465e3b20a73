"""What queries ask of worlds: K holds where every world has it that agrees with what was observed.

Whoever reasons perfectly knows that much; kabo's own inference may know less, but never less than what it was told.
Where a condition turns on the difference, worlds cannot judge:

- *perfect*: K means true in all worlds. What a plan asks for must hold so.
- *perfect in favour*: K means true in all worlds where that helps, and told where it hurts (below `not`). What does not
  hold even so is wrong for everybody.
- *told in favour*: the other way round. What holds even so holds for everybody.
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
    """Somebody who knows something."""

    def knows(self, claim: Question, at_start: bool, compared: frozenset[Symbol]) -> bool:
        """Whether a claim about the world now, or about the start, is known; `compared`: terms that it compares."""

    def will_know(self, name: "Symbol | Namer | None", at_start: bool) -> bool:
        """Whether the value of an atom or term is known, or will be at run time."""

    def kept_always(self, number: int) -> bool:
        """Whether the `always` goal of this number has held all the way."""


Knowers = tuple[Knower, Knower]  # who is asked where knowing helps, and where it hurts
Query = Callable[[Knowers], bool]
Temporals = Callable[[Temporal, Binding], int]  # notes a temporal formula; numbers the `always` goals


def query(
    formula: Formula,
    problem: Problem,
    binding: Binding,
    temporal: Temporals | None = None,
    *,
    helps: bool = True,
    at_start: bool = False,
) -> Query:
    """Whether a query holds, as a function of who is asked.

    Args:
        formula: the query.
        problem: its problem.
        binding: what parameters and variables stand for.
        temporal: numbers `always(…)`; temporal formulas stand in goals only.
        helps: whether more knowledge makes it hold rather than fail; below `not` it is the other way round.
        at_start: whether it asks about the start.

    Raises:
        CannotJudgeError: it calls a procedure.
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
            return lambda knowers: knowers[who].kept_always(number)
        case Test(call) if problem.scene is None and not isinstance(call, External):
            return lambda knowers: True  # without a scene every geometric test succeeds
    raise CannotJudgeError("a condition asks a procedure, or what is not a matter of knowledge")


def _compared(claim: Claim, problem: Problem, binding: Binding) -> frozenset[Symbol]:
    """The terms that a claim compares with each other: two may be equal whatever they are."""
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


def required(asked: Query, perfect: Knower, told: Knower) -> bool:
    """Whether what a plan asks for holds.

    Raises:
        CannotJudgeError: it does not for somebody who reasons perfectly, and may for kabo's own inference.
    """
    if asked((perfect, perfect)):
        return True
    if asked((perfect, told)):
        raise CannotJudgeError(INFERENCE)
    return False


def fires(asked: Query, perfect: Knower, told: Knower) -> bool:
    """Whether the condition of an effect (`query => …`) holds.

    Raises:
        CannotJudgeError: that depends on how well somebody reasons.
    """
    if asked((told, perfect)):
        return True
    if asked((perfect, told)):
        raise CannotJudgeError(
            "an effect depends on what is known, and that follows only from several facts together"
        )
    return False
