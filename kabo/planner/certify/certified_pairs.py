"""Chooses the body pairs to be proven apart along a stretch of motion, and the joint frame for each proof."""

from collections.abc import Callable, Mapping, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.separation_proofs import PlacedBody
from kabo.scene import KinematicTree


class Thing(NamedTuple):
    """A body at one of its possible poses; a moving body has the robot that carries it."""

    name: str
    place: int
    body: PlacedBody  # with its pose in the frame of the joint that carries it, or in the world
    robot: str | None
    kept: float = 0.0  # [m]: a pair keeps the sum of both from each other
    hand: int = 0  # the last planned joint of the robot that carries it


class PairChoice:
    """Chooses the pairs of bodies to be proven apart; caches them, since many stretches move the same bodies."""

    def __init__(self, never_collide: Callable[[str, str], bool]) -> None:
        """`never_collide` says whether two things, by their names, need no proof."""
        self.never_collide = never_collide
        self._known: dict[object, tuple[Integers, dict[str, int], Integers]] = {}
        self._never: dict[tuple[str, str], bool] = {}

    def pairs(
        self, things: Sequence[Thing], moving: int, permitted: frozenset[frozenset[str]], tree: KinematicTree
    ) -> Integers:
        """The pairs to be proven apart: rows (P, 3) of two indices of things and the nearest common joint.

        Args:
            things: the moving bodies, then the bodies at rest; the indices refer to this sequence.
            moving: the number of moving bodies.
            permitted: pairs of names whose contact is allowed; they are left out.
            tree: the kinematic tree whose joints carry the moving bodies.
        """
        names = tuple(thing.name for thing in things)
        key = moving, len(tree.parent), names, tuple(thing.body.joint for thing in things[:moving])
        if key not in self._known:
            rows = self._comparable(things, moving, tree)
            numbers = {name: number for number, name in enumerate(dict.fromkeys(names))}
            own = np.array([numbers[name] for name in names], np.int64)[rows[:, :2]]
            self._known[key] = rows, numbers, own.min(axis=1) * len(names) + own.max(axis=1)
        rows, numbers, keys = self._known[key]
        stay = np.ones(len(rows), bool)
        for pair in permitted:
            ends = sorted(numbers[name] for name in pair if name in numbers)
            if len(ends) == 2:
                stay &= keys != ends[0] * len(names) + ends[1]
        return rows[stay] if permitted else rows

    def _comparable(self, things: Sequence[Thing], moving: int, tree: KinematicTree) -> Integers:
        """The pairs that may not touch."""
        rows: list[tuple[int, int, int]] = []
        chains = [_chain(tree, thing.body.joint) for thing in things[:moving]]
        never = self._never
        for i in range(moving):
            first, own = things[i].name, chains[i]
            for k in range(i + 1, len(things)):
                second = things[k].name
                if (first, second) not in never:
                    never[first, second] = self.never_collide(first, second)
                if first != second and not never[first, second]:
                    frame = next((joint for joint in chains[k] if joint in own), 0) if k < moving else 0
                    rows.append((i, k, frame))
        return np.array(rows, np.int64).reshape(-1, 3)

    def across(self, first: Sequence[Thing], second: Sequence[Thing]) -> Integers:
        """All pairs (P, 3) of a body in `first` and one in `second` that may collide, to be proven apart in the world."""
        numbers = [
            (i, k, 0)
            for i, thing in enumerate(first)
            for k, other in enumerate(second)
            if not self.never_collide(thing.name, other.name)
        ]
        return np.array(numbers, np.int64).reshape(-1, 3)


def kept_distances(
    things: Sequence[Thing],
    pairs: Integers,
    permitted: frozenset[frozenset[str]],
    roots: Mapping[str, str],
) -> Array | None:
    """What each pair keeps from each other (P,) [m]; None if no body keeps anything.

    `roots` has for each object the one that it is attached to at last, itself if to none.
    """
    if not any(thing.kept for thing in things):
        return None
    grasped = _grasped(things, permitted, roots)
    return np.array([_kept(things[i], things[k], grasped) for i, k in pairs[:, :2].tolist()])


def _grasped(
    things: Sequence[Thing], permitted: frozenset[frozenset[str]], roots: Mapping[str, str]
) -> set[tuple[str, str | None, int]]:
    """Bodies from which a hand and what it holds keep nothing, each with the robot and the hand.

    They are those that the hand may touch, and what is attached to a body that something in the hand may touch.
    """
    hands = {thing.name: (thing.robot, thing.hand) for thing in things if thing.robot is not None and thing.hand}
    found: set[tuple[str, str | None, int]] = set()
    for pair in permitted:
        for own, other in permutations(pair, 2):
            if own in hands and "." in own:
                found.add((other, *hands[own]))
            elif own in hands and other in roots:
                beside = (name for name, root in roots.items() if root == roots[other] and name != other)
                found |= {(name, *hands[own]) for name in beside}
    return found


def _kept(first: Thing, second: Thing, grasped: set[tuple[str, str | None, int]]) -> float:
    """What two bodies keep from each other [m].

    It is nothing if only a gripper moves one relative to the other, or if one is of a hand that may come near the other.
    """
    same = first.robot is not None and (first.robot, first.hand) == (second.robot, second.hand) and first.hand > 0
    taken = (second.name, first.robot, first.hand) in grasped or (first.name, second.robot, second.hand) in grasped
    return 0.0 if same or taken else first.kept + second.kept


def _chain(tree: KinematicTree, joint: int) -> dict[int, None]:
    """The joints from one to the base, in this order; the first one that two chains share carries both."""
    chain: dict[int, None] = {}
    while joint > 0:
        chain[joint] = None
        joint = int(tree.parent[joint])
    return chain
