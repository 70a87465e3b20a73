"""Number terms: values that are read from a state, computed from others, and compared."""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from kabo.knowledge.facts import NumberBits, finite
from kabo.knowledge.queries import GeometricOracle, Query, Signed, optimistic, union

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(frozen=True)
class NumberTerm:
    """A number that may be known: `value` reads the bits `reads` of a state and returns None if it is unknown.

    `asks`: whether reading it calls an external procedure.
    """

    reads: int
    value: Callable[[int], float | None]
    asks: bool = False


@dataclass(frozen=True)
class Compare(Signed):
    """A query that compares two numbers; with `positive` False it holds unless the comparison is known to hold."""

    operator: str
    left: NumberTerm
    right: NumberTerm
    positive: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "has_tests", self.left.asks or self.right.asks)

    @property
    def reads(self) -> int:
        """The bits of both numbers."""
        return self.left.reads | self.right.reads

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether both numbers are known and the comparison holds; the opposite if `positive` is False."""
        left, right = self.left.value(state), self.right.value(state)
        known = left is not None and right is not None and COMPARISONS[self.operator](left, right)
        return known == self.positive

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The bits of both numbers."""
        return self.reads

    def possible(self, ones: int, zeros: int) -> bool:
        """True: in the relaxation a number may have any value."""
        return True


def stored(choices: Sequence[tuple[Query, NumberBits]], static: int | None) -> NumberTerm:
    """The number that a state, or static knowledge, records.

    Args:
        choices: for each tuple of objects that the term's arguments may be known to be, the condition under which
            they are, and the bits of the ground term.
        static: the bits of static knowledge if the number is part of it and takes no bits of states; else None.
    """

    def value(state: int) -> float | None:
        for condition, bits in choices:
            if condition.holds(state):
                return bits.decode(state if static is None else static)
        return None

    reads = union(condition.reads | (bits.field if static is None else 0) for condition, bits in choices)
    return NumberTerm(reads, value)


def computed(operator: str, left: NumberTerm, right: NumberTerm) -> NumberTerm:
    """The sum, difference, product or quotient; unknown if either number is or the result is not finite."""

    def value(state: int) -> float | None:
        first, second = left.value(state), right.value(state)
        if first is None or second is None or (operator == "/" and second == 0.0):
            return None
        return finite(_OPERATIONS[operator](first, second))

    return NumberTerm(left.reads | right.reads, value, left.asks or right.asks)


_OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}
