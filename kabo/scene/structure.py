"""The axis structure of an arm, which determines the closed form, if any, of the arm's inverse kinematics [K A.3].

It follows from the joint axes with all joints at zero, not from names or frames: link lengths and offsets are free
as long as axes are parallel, or meet, where the form needs it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Integers
from kabo.scene.tree import REVOLUTE, KinematicTree

ALIGNMENT_TOLERANCE = 1e-5  # [m or rad] up to which axes count as parallel, or as meeting
MIN_DIFFERENCE = 1e-3  # [m or rad] above which axes count as apart, or at an angle
_TRIAL_ANGLES = (0.7, -1.9)  # [rad] values of a locked joint at which the structure must be the same
_LOCKS = (
    2,
    6,
    0,
    3,
    1,
    4,
    5,
)  # which joint of seven is locked: the elbow's turn where that will do, else the last


@dataclass(frozen=True)
class Structure:
    """A chain of revolute joints whose inverse kinematics has a known closed form.

    `form` and `placing` are as in kinematics/kernels/closed_form.py; `axes` (m, 6) are directions and points in the
    world where all joints are at zero, `zero` (12,) the pose of the last of `joints` (m,) there. Of seven axes one
    is locked: `lock` is its index, or -1 if no axis is locked.
    """

    form: int
    placing: int
    mirrored: bool
    backwards: bool
    lock: int
    joints: Integers
    axes: Array
    zero: Array

    @property
    def end(self) -> int:
        """The last joint of the chain, for whose poses inverse kinematics is solved."""
        return int(self.joints[-1])


@dataclass(frozen=True)
class NoStructure:
    """The reason why an arm has no known closed form, as a phrase about its axes."""

    reason: str


def structure_of(tree: KinematicTree, planned: int, base: int = 0) -> Structure | NoStructure:
    """The structure of the chain of the first `planned` values of a tree's configuration, or why it has none.

    The first `base` values move the base and are left out: axes are those with the base at zero.
    """
    chain = _chain(tree, planned, base)
    if isinstance(chain, str):
        return NoStructure(chain)
    axes, zero = _axes(tree, chain, base)
    joints = np.array(chain, np.int64)
    if len(chain) in (5, 6):
        form = _form(axes)
        if form is not None:
            return Structure(*form, -1, joints, axes, zero)
    if len(chain) == 7:
        for lock in _LOCKS:
            forms = [_form(_locked(axes, lock, value)) for value in _TRIAL_ANGLES]
            if forms[0] is not None and forms[0] == forms[1]:
                return Structure(*forms[0], lock, joints, axes, zero)
    return NoStructure(_NEEDED.get(len(chain), f"its {len(chain)} planned joints are not five, six or seven"))


_NEEDED = {
    5: "its axes 2, 3 and 4 are not parallel",
    6: "it has neither a spherical wrist behind (or before) three axes of which two are parallel or meet, nor three "
    "parallel axes followed by two that meet",
    7: "no one joint can be held such that the other six have a spherical wrist or three parallel axes",
}


def _chain(tree: KinematicTree, planned: int, base: int) -> list[int] | str:
    """The joints of the planned values in order from the base, or a sentence that says why they form no chain."""
    moving = [j for j in range(1, len(tree.parent)) if tree.ratio[j] != 0.0 and tree.source[j] < planned]
    movers, count = [j for j in moving if tree.source[j] >= base], planned - base
    if len(movers) != count or len({int(tree.source[j]) for j in movers}) != count:
        return "a planned value moves several joints"
    if any(tree.kind[j] != REVOLUTE for j in movers):
        return "a planned joint slides"
    if any(abs(tree.ratio[j]) != 1.0 for j in movers):
        return "a planned joint is geared to its value"
    for before, after in zip(movers, movers[1:], strict=False):
        joint = int(tree.parent[after])
        while joint > 0 and tree.ratio[joint] == 0.0:
            joint = int(tree.parent[joint])
        if joint != before:
            return "its planned joints are not one chain"
    return movers


def _axes(tree: KinematicTree, chain: Sequence[int], base: int) -> tuple[Array, Array]:
    """The axes (m, 6), direction and point in the world with the chain at zero, and the pose of its end (12,)."""
    poses: dict[int, Array] = {0: np.eye(4)}
    for j in range(1, chain[-1] + 1):
        parent = poses.get(int(tree.parent[j]))
        moves = tree.ratio[j] != 0.0 and tree.source[j] >= base
        if parent is None or (moves and j not in chain):
            continue  # of another branch
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = tree.placement[j, :9].reshape(3, 3), tree.placement[j, 9:]
        poses[j] = parent @ step if j in chain else parent @ step @ _standing(tree, j)
    axes = np.array([[*poses[j][:3, 2], *poses[j][:3, 3]] for j in chain])
    end = poses[chain[-1]]
    return axes, np.concatenate([end[:3, :3].ravel(), end[:3, 3]])


def _standing(tree: KinematicTree, joint: int) -> Array:
    """The transform (4, 4) of a joint that does not move."""
    result, value = np.eye(4), float(tree.shift[joint])
    if tree.kind[joint] == REVOLUTE:
        c, s = np.cos(value), np.sin(value)
        result[:2, :2] = [[c, -s], [s, c]]
    else:
        result[2, 3] = value
    return result


def _form(axes: Array) -> tuple[int, int, bool, bool] | None:
    """Form, placing, mirrored and backwards of `Structure` for five or six axes; None if no form fits."""
    if len(axes) == 5:
        return (2, 0, False, False) if _bends(axes) and not _parallel(axes[3], axes[4]) else None
    for backwards, chain in ((False, axes), (True, axes[::-1])):
        wrist = _meeting(chain[3:6])
        if wrist is not None:
            for mirrored, first in ((False, chain[:3]), (True, chain[2::-1])):
                placing = _placing(first)
                if placing is not None:
                    return 0, placing, mirrored, backwards
    for backwards, chain in ((False, axes), (True, axes[::-1])):
        if _bends(chain) and not _parallel(chain[3], chain[4]) and _meeting(chain[4:6]) is not None:
            return 1, 0, False, backwards
    return None


def _bends(axes: Array) -> bool:
    """Whether axes 2, 3 and 4 are parallel and apart, and the first is not."""
    parallel = _parallel(axes[1], axes[2]) and _parallel(axes[2], axes[3]) and not _parallel(axes[0], axes[1])
    return parallel and _apart(axes[1], axes[2]) > MIN_DIFFERENCE and _apart(axes[2], axes[3]) > MIN_DIFFERENCE


def _placing(axes: Array) -> int | None:
    """How three axes move a point: 0 if the second and third are parallel, 1 if the first and second meet, else None."""
    a, b, c = axes
    if _parallel(b, c) and not _parallel(a, b) and _apart(b, c) > MIN_DIFFERENCE:
        return 0
    centre = _meeting(axes[:2])
    if centre is not None and np.linalg.norm(np.cross(c[:3], centre - c[3:])) > MIN_DIFFERENCE:
        return 1
    return None


def _parallel(a: Array, b: Array) -> bool:
    return float(np.linalg.norm(np.cross(a[:3], b[:3]))) < ALIGNMENT_TOLERANCE


def _apart(a: Array, b: Array) -> float:
    """The distance between parallel axes [m]."""
    return float(np.linalg.norm(np.cross(a[:3], b[3:] - a[3:])))


def _meeting(axes: Array) -> Array | None:
    """The point (3,) where all axes meet, with an angle between neighbours; None if there is no such point."""
    if any(np.linalg.norm(np.cross(a[:3], b[:3])) < MIN_DIFFERENCE for a, b in zip(axes, axes[1:], strict=False)):
        return None
    across = np.concatenate([np.eye(3) - np.outer(a[:3], a[:3]) for a in axes])
    target = np.concatenate([a[3:] - a[:3] * (a[:3] @ a[3:]) for a in axes])
    point: Array = np.linalg.lstsq(across, target, rcond=None)[0]
    return point if float(np.max(np.abs(across @ point - target))) < ALIGNMENT_TOLERANCE else None


def _locked(axes: Array, lock: int, value: float) -> Array:
    """The other axes after one joint is locked at a value."""
    z, p = axes[lock, :3], axes[lock, 3:]
    c, s, hat = np.cos(value), np.sin(value), np.cross(np.eye(3), z)
    turn = np.eye(3) + s * hat + (1.0 - c) * hat @ hat
    moved = axes.copy()
    moved[lock:, :3] = axes[lock:, :3] @ turn.T
    moved[lock:, 3:] = (axes[lock:, 3:] - p) @ turn.T + p
    return np.delete(moved, lock, axis=0)
