"""A world: the true values of atoms and terms, and what must not be false in it for knowledge to be right.

A world is executed, not known: what an action may have changed either way is left open until somebody looks.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from kabo.language.formulas import (
    And,
    Exists,
    Forall,
    Formula,
    Know,
    Not,
    Or,
    Temporal,
    Truth,
    Xor,
)
from kabo.language.problem import Problem
from kabo.verify.ground import Binding, Entry, GroundClaim, Symbol, Value, instances, range_of
from kabo.verify.knowledge import Facts, Knowledge, truth
from kabo.verify.questions import knows

Verdict = Callable[["World"], "bool | None"]


class OpenError(Exception):
    """Somebody looks at a value that the world leaves open: every value that it may have must be tried."""

    def __init__(self, symbol: Symbol) -> None:
        super().__init__(symbol)
        self.symbol = symbol
        self.phase = 0  # of the step that was interrupted, which goes on there


@dataclass(frozen=True)
class Pending:
    """What an action says of the world after it.

    Attributes:
        entries: Kx and Kor, which must hold.
        conjunctions: of which each must be false (LCW).
        changed: what the action changed.
        chosen: whether a value was chosen to agree with these.
    """

    entries: tuple[tuple[str, Entry], ...]
    conjunctions: tuple[tuple[GroundClaim, ...], ...]
    changed: frozenset[Symbol]
    chosen: bool = False


@dataclass
class World:
    """True values; what is not there is open. It answers formulas as if all that is true were known.

    Attributes:
        known: the values.
        excluded: values that an open term cannot have.
        mind: what the agent knows here, of which conditions on knowledge are asked.
        first: the world as it was at the start.
        failed: the `always` goals, by number, that were false somewhere on the way.
        ramified: whether an update rule had to change the world.
        pending: what the last action says of the world after it, and that is still to be looked at.
    """

    known: dict[Symbol, Value]
    excluded: dict[Symbol, frozenset[Value]] = field(default_factory=dict)
    mind: Facts = field(default_factory=lambda: Knowledge({}))
    first: "World | None" = None
    failed: frozenset[int] = frozenset()
    pending: "Pending | None" = None
    ramified: bool = False
    whether: frozenset[Symbol] = frozenset()

    def copy(self) -> "World":
        """Another world with the same values."""
        return replace(self, known=dict(self.known), excluded=dict(self.excluded))

    def as_known(self) -> Knowledge:
        """What somebody would know who knew all of it: update rules are asked of this."""
        return Knowledge(self.known, self.excluded)

    def value(self, symbol: Symbol) -> Value:
        """The value.

        Raises:
            OpenError: it is open.
        """
        if symbol not in self.known:
            raise OpenError(symbol)
        return self.known[symbol]

    def holds(self, claim: GroundClaim) -> bool:
        """Whether a claim is true.

        Raises:
            OpenError: the value is open, and it matters.
        """
        true = truth(claim, self)
        if true is None:
            raise OpenError(claim[0])
        return true

    def put(self, symbol: Symbol, value: Value) -> None:
        """The value is this now."""
        self.known[symbol] = value
        self.excluded.pop(symbol, None)

    def leave_open(self, symbol: Symbol, without: Iterable[Value] = ()) -> None:
        """The value may be any but these now."""
        self.known.pop(symbol, None)
        self.excluded[symbol] = frozenset(without)

    def possible(self, symbol: Symbol, problem: Problem) -> list[Value]:
        """The values that an open symbol can have; none for numbers."""
        values = range_of(problem, symbol) or ()
        return [value for value in values if value not in self.excluded.get(symbol, ())]


def verdict(
    formula: Formula, problem: Problem, binding: Binding, temporal: Callable[..., Verdict] | None = None
) -> Verdict:
    """What a world says of a query: False where it cannot hold, for something it claims to know is false.

    True where it holds whatever is known, None where it depends on what is known, which a world cannot say.

    Args:
        formula: the query.
        problem: its problem.
        binding: what parameters and variables stand for.
        temporal: gives the verdict on a temporal formula under a binding; they stand in goals only.
    """

    def inside(part: Formula, more: Binding = binding) -> Verdict:
        return verdict(part, problem, more, temporal)

    match formula:
        case Know(claim):
            true = knows(claim, problem, binding)
            return lambda world: None if true(world) else False
        case Truth(value):
            return lambda world: value
        case Not(body):
            inner = inside(body)
            return lambda world: _negated(inner(world))
        case And(parts):
            return _all(map(inside, parts))
        case Or(parts):
            return _any(map(inside, parts))
        case Xor(first, second):
            one, two = inside(first), inside(second)
            return lambda world: _differ(one(world), two(world))
        case Forall(variables, body):
            return _all(inside(body, more) for more in instances(problem, variables, binding))
        case Exists(variables, body):
            return _any(inside(body, more) for more in instances(problem, variables, binding))
        case Temporal() if temporal is not None:
            return temporal(formula, binding)
    return lambda world: None


def _negated(value: bool | None) -> bool | None:
    return None if value is None else not value


def _differ(one: bool | None, two: bool | None) -> bool | None:
    return None if one is None or two is None else one != two


def _all(parts: Iterable[Verdict]) -> Verdict:
    whole = tuple(parts)

    def judge(world: World) -> bool | None:
        result: bool | None = True
        for part in whole:
            value = part(world)
            if value is False:
                return False
            if value is None:
                result = None
        return result

    return judge


def _any(parts: Iterable[Verdict]) -> Verdict:
    whole = tuple(parts)

    def judge(world: World) -> bool | None:
        result: bool | None = False
        for part in whole:
            value = part(world)
            if value:
                return True
            if value is None:
                result = None
        return result

    return judge
