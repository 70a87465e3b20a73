"""Random numbers that depend on a seed and a counter only: equal seeds give equal numbers everywhere."""

from collections.abc import Iterable
from typing import TypeVar

_Thing = TypeVar("_Thing")

_MASK = (1 << 64) - 1


class Stream:
    """One stream of random numbers (SplitMix64); streams of other indices are independent of it."""

    def __init__(self, seed: int, index: int) -> None:
        self._state = (seed * 0x9E3779B97F4A7C15 + index * 0xD1B54A32D192ED03) & _MASK

    def below(self, bound: int) -> int:
        """A whole number from 0 to `bound` - 1."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        mixed = self._state
        mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & _MASK
        return (mixed ^ (mixed >> 31)) % bound

    def shuffled(self, things: Iterable[_Thing]) -> list[_Thing]:
        """The things in another order."""
        result = list(things)
        for last in range(len(result) - 1, 0, -1):
            other = self.below(last + 1)
            result[last], result[other] = result[other], result[last]
        return result
