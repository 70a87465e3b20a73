"""Samples drawn pose first: even parameters of the family of poses, then a closed form; for one arm, or two together.

This takes rows whose equalities leave one turn and translations (see `families`), and arms with a closed form. For
everything else the answer is None, and `sample` projects random seeds instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array, Integers
from kabo.kinematics.closed_form import chain_of
from kabo.kinematics.constraints import Rows, stacked
from kabo.kinematics.families import UNMOVED, between_frames, family_of
from kabo.kinematics.joined_trees import JoinedTree
from kabo.kinematics.kernels import drawing as kernels
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.kernels.families import Family
from kabo.kinematics.kernels.forms import FIVE, MAX_SOLUTIONS
from kabo.kinematics.projection import arrays_of
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.structure import Structure
from kabo.scene.transforms import inverse, length, unflat
from kabo.scene.tree import PRISMATIC, KinematicTree
from kabo.streams import Key

# Draws of one sample for its own aims, and in all; values of the locked joint of seven for each.
ONE_ARM, TWO_ARMS = (2, 8, 16), (96, 128, 6)


@dataclass(frozen=True)
class ClosedArm:
    """An arm with a closed form; `base` (n,) holds the values of the joints outside its chain."""

    tree: KinematicTree
    structure: Structure
    base: Array

    @cached_property
    def poses(self) -> Array:
        """The poses (J, 12) of all joints at the base configuration."""
        world_T = np.zeros((len(self.tree.parent), 12))
        world_T[0, [0, 4, 8]] = 1.0
        forward_kinematics(self.base, *arrays_of(self.tree), world_T)
        return world_T

    @property
    def reaches_poses(self) -> bool:
        """Whether poses within reach are reached in general; five axes reach but few of those that rows allow."""
        return self.structure.form != FIVE

    def carries(self, joint: int) -> bool:
        """Whether a joint is the end of the chain, or is carried by it."""
        while joint > self.structure.end:
            joint = int(self.tree.parent[joint])
        return joint == self.structure.end

    def end_T(self, joint: int) -> Array:  # noqa: N802
        """The pose (4, 4) of a joint that is carried by the chain's end, in its frame."""
        if joint not in self._end_T:
            self._end_T[joint] = inverse(unflat(self.poses[self.structure.end])) @ unflat(self.poses[joint])
        return self._end_T[joint]

    @cached_property
    def _end_T(self) -> dict[int, Array]:  # noqa: N802
        return {}

    @cached_property
    def arrays(self) -> kernels.Arm:
        """The arm as kernels take it."""
        first, reach, joint = int(self.structure.joints[0]), 0.0, self.structure.end
        while joint != first:
            reach += length(self.tree.placement[joint, 9:])
            if self.tree.kind[joint] == PRISMATIC:
                value = self.tree.ratio[joint] * self.base[self.tree.source[joint]] + self.tree.shift[joint]
                reach += abs(float(value))
            joint = int(self.tree.parent[joint])
        centre = self.poses[first, 9:].copy()
        return kernels.Arm(chain_of(self.structure), self.tree, self.base, centre, reach)


def drawn(
    arm: ClosedArm,
    rows: Rows,
    key: Key,
    first: int,
    count: int,
    *,
    free: Rows | None = None,
    every_branch: bool = False,
) -> tuple[Array, Integers] | None:
    """Configurations (M, n) of samples `first` … that fulfil the rows, and each one's sample, 0 to count - 1 (M,).

    Parameters are even: heights between bounds, rows of `free`, a turn, and otherwise translations within reach. With
    `every_branch` all configurations with the same pose and value of the locked joint, else one that is drawn of them.
    None if the rows, or the joints that they name, have no family.
    """
    family = _family_in_world(arm, rows, free)
    if family is None:
        return None
    found = np.empty((count, MAX_SOLUTIONS if every_branch else 1, arm.tree.size))
    counts = np.zeros(count, np.int64)
    kernels.draw_arm(family, arm.arrays, kernels.Draws(np.uint64(key), first, *ONE_ARM), found, counts)
    return found[np.arange(found.shape[1]) < counts[:, None]], np.repeat(np.arange(count), counts)


def drawn_together(
    arms: Sequence[ClosedArm],
    joined: JoinedTree,
    rows: Rows,
    key: Key,
    first: int,
    count: int,
    *,
    free: Rows | None = None,
) -> tuple[Array, NDArray[np.bool_]] | None:
    """Configurations (count, n) of two arms that fulfil rows on their joined tree, and which are valid (count,).

    The poses of one arm's end are drawn, wherever rows between it and the world allow, then that of the other from the
    rows between both; orientations that nothing aims at are drawn anew until both arms reach.
    None if the arms are not two, if rows tie both to the world, or if rows have no family.
    """
    if len(arms) != 2 or len(joined.values) != 2:
        return None
    families = _families_of_two(arms, joined, rows, free)
    if families is None:
        return None
    lead, made = families
    firsts, seconds = (np.empty((count, arms[k].tree.size)) for k in (lead, 1 - lead))
    succeeded = np.zeros(count, np.bool_)
    both = arms[lead].arrays, arms[1 - lead].arrays
    kernels.draw_pair(made, both, kernels.Draws(np.uint64(key), first, *TWO_ARMS), firsts, seconds, succeeded)
    Q = np.empty((count, joined.tree.size))
    Q[:, joined.values[lead]], Q[:, joined.values[1 - lead]] = firsts, seconds
    return Q, succeeded


def _family_in_world(arm: ClosedArm, rows: Rows, free: Rows | None) -> Family | None:
    every = rows if free is None else stacked([rows, free])
    joints = _joints(every)
    if not arm.reaches_poses or not all(arm.carries(joint) for joint in joints):
        return None
    placed = {0: (0, UNMOVED), **{joint: (1, arm.end_T(joint)) for joint in joints}}
    moved = between_frames(every, placed)
    return None if moved is None else family_of(moved[: len(rows)], moved[len(rows) :])


def _families_of_two(
    arms: Sequence[ClosedArm], joined: JoinedTree, rows: Rows, free: Rows | None
) -> tuple[int, tuple[Family, Family]] | None:
    """The arm that leads, the family of its poses in the world, and that of the other's poses relative to it."""
    every = rows if free is None else stacked([rows, free])
    required = np.arange(len(every)) < len(rows)
    owners = np.array([[_owner(joined, int(row[c])) for c in (columns.FIRST, columns.SECOND)] for row in every])
    if not len(rows):
        return None
    least, most = owners.min(axis=1), owners.max(axis=1)
    tied = sorted({int(most[i]) for i in range(len(every)) if least[i] < 0})
    if tied not in ([], [0], [1]) or np.any(least == most):
        return None
    lead = tied[0] if tied else 0
    placed = []
    for k, arm in enumerate(arms):
        own = [joint - joined.joints[k] for joint in _joints(every) if _owner(joined, joint) == k]
        if not arm.reaches_poses or not all(arm.carries(joint) for joint in own):
            return None
        placed.append({joined.joint(k, joint): arm.end_T(joint) for joint in own})
    front = {joint: (1, pose) for joint, pose in placed[lead].items()}
    there = {joint: (0, pose) for joint, pose in placed[lead].items()}
    back = {joint: (1, pose) for joint, pose in placed[1 - lead].items()}
    families = []
    for chosen, where in ((least < 0, {0: (0, UNMOVED), **front}), (least >= 0, {**there, **back})):
        moved = between_frames(every[chosen], where)
        if moved is None:
            return None
        needed = required[chosen]
        family = family_of(np.ascontiguousarray(moved[needed]), np.ascontiguousarray(moved[~needed]))
        if family is None:
            return None
        families.append(family)
    return lead, (families[0], families[1])


def _joints(rows: Rows) -> list[int]:
    """The joints that rows name, without the world."""
    return sorted({int(j) for j in rows[:, (columns.FIRST, columns.SECOND)].ravel()} - {0})


def _owner(joined: JoinedTree, joint: int) -> int:
    """The part of a joined tree that has a joint; -1 for the world."""
    return -1 if joint == 0 else max(k for k, before in enumerate(joined.joints) if joint > before)


def base_of(tree: KinematicTree, base: ArrayLike | None = None) -> Array:
    """The values (n,) that joints outside a chain have: those given, else zeros clipped to the limits."""
    return np.clip(0.0, tree.lower, tree.upper) if base is None else np.array(base, np.float64)
