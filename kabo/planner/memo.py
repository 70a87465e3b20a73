"""Solved continuations, found again by what they need: a partial state and the continuation that starts there."""

from collections.abc import Hashable
from dataclasses import dataclass

from kabo.planner.skeleton import SkeletonNode


@dataclass(frozen=True)
class Solved:
    """A continuation, and the bits of the (extended) state that it needs, with the values where it was found."""

    needed: int
    node: SkeletonNode
    length: int  # actions to the goal if sensing turns out best


class Memo:
    """Continuations by needed bits: one table for each set of bits, keyed by their values and the geometry."""

    def __init__(self) -> None:
        self._tables: dict[int, dict[tuple[int, Hashable], Solved]] = {}

    @property
    def is_empty(self) -> bool:
        """Whether nothing is remembered yet."""
        return not self._tables

    def add(self, extended: int, geometry: Hashable, solved: Solved) -> None:
        """Remembers a continuation found at a state; an older one for the same need stays."""
        table = self._tables.setdefault(solved.needed, {})
        table.setdefault((extended & solved.needed, geometry), solved)

    def find(self, extended: int, geometry: Hashable) -> Solved | None:
        """The shortest continuation whose needs the state has in an equal geometry; of equals the oldest."""
        best = None
        for needed, table in self._tables.items():
            solved = table.get((extended & needed, geometry))
            if solved is not None and (best is None or solved.length < best.length):
                best = solved
        return best
