"""Number terms: how a value is read from a state, and computed from others."""

from collections.abc import Callable, Mapping, Sequence

from kabo.knowledge.facts import NumberBits, finite
from kabo.knowledge.queries import NumberTerm, Query, union


def stored(choices: Sequence[tuple[Query, NumberBits]], static: int | None) -> NumberTerm:
    """The number that a state holds.

    Args:
        choices: the bits of the term for whatever objects its arguments are known to be, each with the condition.
        static: what is known for good, if the number is among that; it takes no bits of states.
    """

    def value(state: int) -> float | None:
        for condition, bits in choices:
            if condition.holds(state):
                return bits.decode(state if static is None else static)
        return None

    reads = union(condition.reads | (bits.field if static is None else 0) for condition, bits in choices)
    return NumberTerm(reads, value)


def computed(operator: str, left: NumberTerm, right: NumberTerm) -> NumberTerm:
    """A sum, difference, product or quotient; unknown if a side is, or if it is no finite number."""

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
