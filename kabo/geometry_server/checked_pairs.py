"""The pairs of bodies that a workspace checks, by their indices and by their names."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry_server.answers import Pair

Contacts = frozenset[frozenset[str]]


def contacts(pairs: Iterable[Pair]) -> Contacts:
    """The pairs of things as a set of unordered pairs."""
    return frozenset(frozenset(pair) for pair in pairs)


def first_along(
    segments_hit: Callable[[Array, Array, Array], Integers], path: Array, strays: Array | None, *, by_one: bool
) -> int:
    """The answer of `segments_hit` about the first segment of a path (m, n) that is not free; -1 if all are.

    `strays` (m - 1, n) are its third argument, None for zeros. Kernels check all segments sooner than Python asks for each;
    `by_one` is for meshes, which are slow: there the first hit ends it.
    """
    count = len(path) - 1
    off = np.zeros((max(0, count), path.shape[-1])) if strays is None else strays
    step = 1 if by_one else max(1, count)
    for k in range(0, count, step):
        found = segments_hit(path[k : k + step], path[k + 1 : k + 1 + step], off[k : k + step])
        if found.max() >= 0:
            return int(found[found >= 0][0])
    return -1


@dataclass(frozen=True, eq=False)
class CheckedPairs:
    """Pairs of a moving body and another one: `indices` (P, 2) among the moving and then the fixed ones, and names."""

    indices: Integers
    names: list[Pair]

    @cached_property
    def _places(self) -> dict[frozenset[str], list[int]]:
        """Where the pairs of two names are; there are several if a body may be at several poses."""
        found: dict[frozenset[str], list[int]] = {}
        for place, pair in enumerate(self.names):
            found.setdefault(frozenset(pair), []).append(place)
        return found

    @cached_property
    def _others(self) -> dict[Contacts, "CheckedPairs"]:
        """What `without` has found."""
        return {}

    def without(self, permitted: Contacts) -> "CheckedPairs":
        """These pairs without those that are permitted to touch, in the same order."""
        if permitted not in self._others:
            self._others[permitted] = self._without(permitted)
        return self._others[permitted]

    def _without(self, permitted: Contacts) -> "CheckedPairs":
        places = self._places
        dropped = sorted(place for pair in permitted for place in places.get(pair, ()))
        names = self.names.copy()
        for place in reversed(dropped):
            del names[place]
        return CheckedPairs(np.delete(self.indices, dropped, axis=0), names)

    def among(self, permitted: Contacts) -> list[tuple[int, Pair]]:
        """The moving bodies of the pairs that are permitted to touch, with their names, in order."""
        places = sorted(place for pair in permitted for place in self._places.get(pair, ()))
        return [(int(self.indices[place, 0]), self.names[place]) for place in places]
