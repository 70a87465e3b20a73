"""Solved continuations, found again by what they need: a partial state and the continuation that starts there."""

from bisect import insort
from collections.abc import Hashable
from dataclasses import dataclass

from kabo.knowledge.queries import bits_of
from kabo.planner.skeleton import SkeletonNode


@dataclass(frozen=True)
class Solved:
    """A continuation, and the bits of the (extended) state that it needs, with the values where it was found."""

    needed: int
    node: SkeletonNode
    length: int  # actions to the goal if sensing turns out best


@dataclass(frozen=True)
class _Record:
    number: int
    ones: int
    zeros: int
    solved: Solved


def _rank(record: _Record) -> tuple[int, int]:
    return record.solved.length, record.number


class Memo:
    """Continuations by needed bits.

    Each is filed under one bit that must be set: of those that it needs one that says the value of a term, if there
    is any, and the one under which fewest are filed. Only the files of the bits of a state are searched.
    """

    def __init__(self, functional: int = 0) -> None:
        self._functional = functional
        self._files: dict[Hashable, dict[int, list[_Record]]] = {}  # the shortest first
        self._known: set[tuple[Hashable, int, int]] = set()
        self._filed: dict[Hashable, int] = {}  # all bits under which something is filed

    @property
    def is_empty(self) -> bool:
        """Whether nothing is remembered yet."""
        return not self._known

    def add(self, extended: int, geometry: Hashable, solved: Solved) -> None:
        """Remembers a continuation found at a state; an older one for the same need stays."""
        ones, zeros = extended & solved.needed, ~extended & solved.needed
        if (geometry, ones, zeros) in self._known:
            return
        record = _Record(len(self._known), ones, zeros, solved)
        self._known.add((geometry, ones, zeros))
        files = self._files.setdefault(geometry, {})
        bit = min(bits_of(ones & self._functional or ones), key=lambda one: len(files.get(one, ())), default=0)
        insort(files.setdefault(bit, []), record, key=_rank)
        self._filed[geometry] = self._filed.get(geometry, 0) | bit

    def find(self, extended: int, geometry: Hashable) -> Solved | None:
        """The shortest continuation whose needs the state has in an equal geometry; of equals the oldest."""
        files = self._files.get(geometry)
        if files is None:
            return None
        best: _Record | None = None
        absent = ~extended
        for bit in (0, *bits_of(extended & self._filed[geometry])):
            for record in files.get(bit, ()):
                if best is not None and _rank(record) > _rank(best):
                    break
                if not (record.ones & absent or record.zeros & extended):
                    best = record
                    break
        return None if best is None else best.solved
