"""Stores solved continuations by the partial state that each of them needs."""

from bisect import insort
from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple

from kabo.knowledge.queries import bits_of
from kabo.planner.search.skeleton import SkeletonNode


class Solved(NamedTuple):
    """A continuation that solves a node, with the mask of the state bits on which its success depends."""

    needed: int
    node: SkeletonNode
    length: int  # actions to the goal if sensing turns out best


class _Record(NamedTuple):
    """A continuation with the bits that must be set and clear; `rank` sorts by length, then by age."""

    rank: tuple[int, int]
    ones: int
    zeros: int
    solved: Solved


class Memo:
    """A store of continuations, searched by the bits that they need.

    Each continuation is stored under one bit that it needs to be set: if possible a bit that gives the value of a
    term, otherwise the bit with the fewest continuations. A look-up examines only the continuations stored under
    bits that are set in the state.
    """

    def __init__(self, functional: int = 0) -> None:
        self._functional = functional
        self._files: dict[Hashable, dict[int, list[_Record]]] = {}  # the shortest first
        self._known: set[tuple[Hashable, int, int]] = set()
        self._filed: dict[Hashable, int] = {}  # all bits under which something is filed

    @property
    def is_empty(self) -> bool:
        """Whether the memo contains no continuation."""
        return not self._known

    def add(self, extended: int, geometry: Hashable, solved: Solved) -> None:
        """Stores a continuation that was found at a state, unless one with the same needs is stored already."""
        ones, zeros = extended & solved.needed, ~extended & solved.needed
        if (geometry, ones, zeros) in self._known:
            return
        record = _Record((solved.length, len(self._known)), ones, zeros, solved)
        self._known.add((geometry, ones, zeros))
        files = self._files.setdefault(geometry, {})
        filed = self._filed.get(geometry, 0)
        bit = _emptiest(ones & self._functional or ones, filed, files)
        insort(files.setdefault(bit, []), record)
        self._filed[geometry] = filed | bit

    def find(self, extended: int, geometry: Hashable) -> Solved | None:
        """The shortest continuation whose needs the state fulfils, for an equal geometry key; or None."""
        files = self._files.get(geometry)
        if files is None:
            return None
        best: _Record | None = None
        absent = ~extended
        waiting, bit = extended & self._filed[geometry], 0  # 0: what needs no bit at all
        while True:
            for record in files.get(bit, ()):
                if best is not None and record.rank > best.rank:
                    break
                if not (record.ones & absent or record.zeros & extended):
                    best = record
                    break
            if not waiting:
                return None if best is None else best.solved
            bit = waiting & -waiting
            waiting ^= bit


def _emptiest(bits: int, filed: int, files: Mapping[int, Sequence[_Record]]) -> int:
    """The bit under which fewest continuations are filed, the lowest if equal; 0 if `bits` is 0."""
    free = bits & ~filed
    return free & -free or min(bits_of(bits), key=lambda bit: len(files[bit]), default=0)
