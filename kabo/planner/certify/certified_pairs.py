"""Chooses the body pairs to be proven apart along a stretch of motion, and the joint frame for each proof."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.scene import KinematicTree

Numbers = list[tuple[int, int]]  # of two things


class Thing(NamedTuple):
    """A body at one of its possible poses; a moving body has the robot and the joint that carry it."""

    name: str
    place: int
    mesh: str
    robot: str | None
    joint: int
    pose: Array  # (12,) in the joint's frame, or in the world
    kept: float = 0.0  # [m]: a pair keeps the sum of both from each other
    hand: int = 0  # the last planned joint of the robot that carries it


class PairChoice:
    """Chooses the pairs of bodies to be proven apart; caches them, since many stretches move the same bodies."""

    def __init__(self, never_collide: Callable[[str, str], bool]) -> None:
        """`never_collide` says whether two things, by their names, need no proof."""
        self.never_collide = never_collide
        self._known: dict[object, tuple[Numbers, Integers, dict[frozenset[str], list[int]]]] = {}

    def pairs(
        self, things: Sequence[Thing], moving: int, permitted: frozenset[frozenset[str]], tree: KinematicTree
    ) -> tuple[Numbers, Integers]:
        """The pairs to be proven apart: index pairs, and rows (P, 3) of two indices and the nearest common joint.

        Args:
            things: the moving bodies, then the bodies at rest; the indices refer to this sequence.
            moving: the number of moving bodies.
            permitted: pairs of names whose contact is allowed; they are left out.
            tree: the kinematic tree whose joints carry the moving bodies.
        """
        key = moving, len(tree.parent), tuple((thing.name, thing.joint) for thing in things)
        if key not in self._known:
            self._known[key] = self._comparable(things, moving, tree)
        numbers, rows, by_names = self._known[key]
        left_out = [number for pair in permitted for number in by_names.get(pair, ())]
        if not left_out:
            return numbers, rows
        kept = np.ones(len(numbers), bool)
        kept[left_out] = False
        return [numbers[i] for i in np.flatnonzero(kept)], rows[kept]

    def _comparable(
        self, things: Sequence[Thing], moving: int, tree: KinematicTree
    ) -> tuple[Numbers, Integers, dict[frozenset[str], list[int]]]:
        """The pairs that may not touch, and the numbers of each by its names."""
        numbers: Numbers = []
        rows: list[tuple[int, int, int]] = []
        by_names: dict[frozenset[str], list[int]] = {}
        chains = [_chain(tree, thing.joint) for thing in things]
        for i in range(moving):
            first, own = things[i].name, chains[i]
            for k in range(i + 1, len(things)):
                second = things[k].name
                if first != second and not self.never_collide(first, second):
                    by_names.setdefault(frozenset((first, second)), []).append(len(numbers))
                    numbers.append((i, k))
                    rows.append((i, k, next((joint for joint in chains[k] if joint in own), 0)))
        return numbers, np.array(rows, np.int64).reshape(-1, 3), by_names

    def across(self, first: Sequence[Thing], second: Sequence[Thing]) -> tuple[Numbers, Integers]:
        """All pairs of a body in `first` and one in `second` that may collide, to be proven apart in the world."""
        numbers = [
            (i, k)
            for i, thing in enumerate(first)
            for k, other in enumerate(second)
            if not self.never_collide(thing.name, other.name)
        ]
        return numbers, np.array([(i, k, 0) for i, k in numbers], np.int64).reshape(-1, 3)


def _chain(tree: KinematicTree, joint: int) -> dict[int, None]:
    """The joints from one to the base, in this order; the first one that two chains share carries both."""
    chain: dict[int, None] = {}
    while joint > 0:
        chain[joint] = None
        joint = int(tree.parent[joint])
    return chain
