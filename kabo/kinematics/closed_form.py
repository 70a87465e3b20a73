"""Inverse kinematics in closed form: every configuration that brings the end of an arm to a pose [K A.3].

Covered are six axes with a spherical wrist, or with three parallel axes; five axes, which reach any point with any
pitch and roll; seven with one of them locked. Every solution is confirmed by forward kinematics. If there is none,
the answer says why.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from kabo.arrays import Array, Integers
from kabo.kinematics.kernels import closed_form as kernels
from kabo.kinematics.kernels import forms
from kabo.scene.structure import Structure
from kabo.scene.tree import KinematicTree

POSE_TOLERANCE = kernels.POSE_TOLERANCE
_FREE = {
    forms.ON_FIRST_AXIS: "on the first axis",
    forms.ON_SECOND_AXIS: "on the second axis",
    forms.ON_THIRD_AXIS: "on the third axis",
    forms.WRIST_ALIGNED: "wrist aligned",
}


@dataclass(frozen=True)
class Reached:
    """Configurations (N, n) that reach a pose, in a fixed order; N > 0.

    `singular[i]` names the singularities of configuration i ("wrist aligned", "on the first axis"), where joints
    can move without changing the pose: the configuration then represents a whole family. It is empty for isolated
    solutions.
    """

    configurations: Array
    singular: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class OutOfReach:
    """The reason why no configuration reaches a pose; fields that do not apply are zero or None.

    `missing`: an estimate, no bound, of how much too short the links are [m], from the first step that fails.
    `tilt`: the rotation of the end that five axes cannot make [rad]. `joint`: index of the value whose limits are
    exceeded least, by `beyond` [rad].
    """

    missing: float = 0.0
    tilt: float = 0.0
    joint: int | None = None
    beyond: float = 0.0

    def __str__(self) -> str:
        if self.missing > 0.0:
            return f"{self.missing:.3f} m out of reach"
        if self.tilt > 0.0:
            return f"tilted by {math.degrees(self.tilt):.2f} deg from what its axes can do"
        if self.joint is not None:
            return f"beyond the limits of joint {self.joint + 1} by {math.degrees(self.beyond):.2f} deg"
        return "not reached"


@dataclass(frozen=True)
class Branches:
    """The closed-form solutions for N poses: `configurations` (N, 8, n), of which pose i has the first `counts[i]`.

    `free` (N, 8) holds the singularities of each solution as bits, `short` (N, 4) why a pose has no solution (see
    kernels/closed_form.py).
    """

    configurations: Array
    counts: Integers
    free: Integers
    short: Array

    def answer(self, i: int, tree: KinematicTree, structure: Structure) -> Reached | OutOfReach:
        """The configurations of pose i, or the reason why there are none."""
        count = int(self.counts[i])
        if count:
            marks = tuple(
                tuple(words for bit, words in _FREE.items() if int(m) & bit) for m in self.free[i, :count]
            )
            return Reached(self.configurations[i, :count].copy(), marks)
        missing, tilt, beyond, axis = (float(v) for v in self.short[i])
        if missing > 0.0:
            return OutOfReach(missing=missing)
        if tilt > 0.0 and not math.isfinite(beyond):
            return OutOfReach(tilt=tilt)
        if not math.isfinite(beyond):
            return OutOfReach()
        return OutOfReach(joint=int(tree.source[structure.joints[int(axis)]]), beyond=beyond)


def branches(
    tree: KinematicTree, structure: Structure, goals: Array, base: Array, locked: Array | None = None
) -> Branches:
    """All configurations within limits, up to whole turns, that bring the last joint of a structure to each pose.

    Args:
        tree, structure: the arm's tree, and its structure from `structure_of`.
        goals: (N, 12) poses world_T_joint of `structure.end`, rotation row-major, then translation.
        base: (n,) a configuration that gives the values of the joints outside the chain.
        locked: (N,) for seven axes, the value of the locked joint for each pose.

    Raises:
        ValueError: shapes do not fit, or a number is not finite.
    """
    poses, start = np.array(goals, np.float64, order="C", ndmin=2), np.array(base, np.float64)
    held = np.zeros(len(poses)) if locked is None else np.array(locked, np.float64)
    if poses.shape[1] != 12 or start.shape != (tree.size,) or held.shape != (len(poses),):
        raise ValueError(f"poses must be (N, 12), the base ({tree.size},), not {poses.shape}, {start.shape}")
    if not (np.all(np.isfinite(poses)) and np.all(np.isfinite(start)) and np.all(np.isfinite(held))):
        raise ValueError("a pose or a value of a joint is not finite")
    if structure.lock >= 0 and locked is None:
        raise ValueError("of seven axes one must be held: give its value for each pose")
    found = np.empty((len(poses), forms.MAX_SOLUTIONS, tree.size))
    counts, free = np.zeros(len(poses), np.int64), np.zeros((len(poses), forms.MAX_SOLUTIONS), np.int64)
    short = np.empty((len(poses), 4))
    answers = kernels.Answers(found, counts, free, short)
    kernels.solve_poses(poses, held, start, chain_of(structure), tree, answers)
    return Branches(found, counts, free, short)


def chain_of(structure: Structure) -> kernels.Chain:
    """The numbers of a structure, as kernels take them."""
    s = structure
    return kernels.Chain(s.form, s.placing, s.mirrored, s.backwards, s.lock, s.axes, s.zero, s.joints)


def unlimited(tree: KinematicTree, structure: Structure) -> tuple[Array, Array]:
    """The limits (n,), infinite for the joints of a closed form: if a sample exceeds them, another branch may not."""
    low, high = tree.lower.copy(), tree.upper.copy()
    turning = [int(tree.source[j]) for i, j in enumerate(structure.joints) if i != structure.lock]
    low[turning], high[turning] = -np.inf, np.inf
    return low, high


def end_poses(tree: KinematicTree, structure: Structure, Q: Array) -> Array:
    """The poses (N, 12) of the structure's last joint at configurations (N, n), by forward kinematics."""
    return joint_poses(tree, structure.end, Q)


def joint_poses(tree: KinematicTree, joint: int, Q: Array) -> Array:
    """The poses (N, 12) of a joint in the world at configurations (N, n), by forward kinematics."""
    values = np.array(Q, np.float64, order="C", ndmin=2)
    poses: Array = kernels.poses_of(values, joint, tree)
    return poses


def with_the_same_pose(tree: KinematicTree, structure: Structure, Q: Array) -> tuple[Array, Integers]:
    """All configurations (M, n) with the same end pose as a row of Q (N, n), and for each the index of this row (M,).

    Of seven axes, the locked axis keeps its value. Rows of Q may exceed the limits; results do not. Joints outside
    the chain have the values in the first row of Q.
    """
    values = np.array(Q, np.float64, order="C", ndmin=2)
    if not len(values):
        return values, np.empty(0, np.int64)
    locked = None
    if structure.lock >= 0:
        locked = values[:, tree.source[structure.joints[structure.lock]]]
    made = branches(tree, structure, end_poses(tree, structure, values), values[0], locked)
    filled = np.arange(made.configurations.shape[1]) < made.counts[:, None]
    return made.configurations[filled], np.repeat(np.arange(len(values)), made.counts)


def with_turns(tree: KinematicTree, structure: Structure, q: Array, most: int = 64) -> Array:
    """At most `most` configurations (N, n) within limits that equal q up to whole turns, nearest to q first."""
    places = [int(tree.source[j]) for j in structure.joints]
    choices = [_turns(float(q[i]), float(tree.lower[i]), float(tree.upper[i])) for i in places]
    every = sorted(product(*choices), key=lambda shifts: (sum(abs(k) for k in shifts), shifts))[:most]
    made = np.repeat(np.asarray(q, np.float64)[None, :], len(every), axis=0)
    made[:, places] += 2.0 * math.pi * np.array(every, np.float64)
    return np.clip(made, tree.lower, tree.upper)


def _turns(value: float, low: float, high: float) -> list[int]:
    """The numbers of whole turns that can be added to a value within its limits."""
    turn = 2.0 * math.pi
    return list(range(math.ceil((low - value) / turn - 1e-11), math.floor((high - value) / turn + 1e-11) + 1)) or [
        0
    ]
