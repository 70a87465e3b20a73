"""Straight lines of the tool: joint paths whose tool moves along a segment in the world with constant orientation.

The line is a constraint of rows: two for the distance from it, one for the progress along it, the rest for the
orientation. Way points are found by projection, and the joint-linear segments between them are proven by `keeps`,
so the deviation is bounded, not sampled, and a jump to another branch of solutions is impossible.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array
from kabo.kinematics.constraints import FrameFeature, Rows, normals, rows_of, stacked
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.kernels.line_following import followed
from kabo.kinematics.kernels.motion_bounds import Pieces, first_row_not_kept, pieces_of
from kabo.kinematics.kernels.projection import FREEZES, Rule, Wanted, project_seeds
from kabo.kinematics.projection import NO_AIMS, arrays_of, checked, limited, storable_limits, values
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.tree import KinematicTree

MAX_DEVIATION = 1e-3  # [m] of the whole path from the line
MAX_TILT = 5e-3  # [rad] of the whole path from the orientation at its start
WAYPOINT_TOLERANCE = 1e-7  # [m or rad] of the rows at way points
MAX_JOINT_CHANGE = 0.5  # [rad or m] of a joint between way points
MIN_LINE_SHARE = 1.0 / 512  # of the line between way points: at a singularity shorter ones would be needed
MAX_ITERATIONS = 20  # of a projection from one way point to the next
STORED_DECIMALS = 9  # of joint values in plans: what is proven is what is stored


@dataclass(frozen=True)
class OffLine:
    """The reason why the tool cannot follow the line, and the distance that it covered [m].

    The reasons are `limit` (a joint reaches its limit; `joint` is its index in q), `out_of_reach` (no
    configuration nearby continues the line) and `singular` (joints would have to turn without bound).
    """

    reason: Literal["limit", "out_of_reach", "singular"]
    travelled: float
    joint: int | None = None


def straight_line(
    tree: KinematicTree,
    q: ArrayLike,
    joint: int,
    joint_T_tool: ArrayLike,
    translation: ArrayLike,
    *,
    keep: Rows | None = None,
    active: ArrayLike | None = None,
    deviation: float = MAX_DEVIATION,
    tilt: float = MAX_TILT,
) -> Array | OffLine:
    """Way points (m, n) of a joint path from q that moves the tool by a translation, or the reason why there is none.

    The joint-linear path through them is proven to stay within `deviation` [m] of the straight segment and `tilt`
    [rad] of the first orientation, each joint within its limits and less than 0.5 rad from one way point to the
    next. All way points except the first are rounded to 1e-9 before they are proven.

    Args:
        tree, q: the tree and the start (n,).
        joint: the index of the joint that carries the tool.
        joint_T_tool: the pose (4, 4) of the tool in the joint's frame.
        translation: the translation (3,) of the tool in the world [m].
        keep: rows instead of those of the orientation, for arms with fewer than six joints; they must hold at q.
        active: the mask (n,) of the joints that may move; None: all joints.

    Raises:
        ValueError: shapes do not fit, a number is not finite, or `keep` does not hold at q.
    """
    start, shift = np.array(q, np.float64), np.array(translation, np.float64)
    moving = np.ones(tree.size, np.bool_) if active is None else np.array(active, np.bool_)
    if start.shape != (tree.size,) or shift.shape != (3,) or not np.isfinite(start.sum() + shift.sum()):
        raise ValueError(f"q must be finite, ({tree.size},), and the translation (3,)")
    if keep is not None and not _holds(keep, values(keep, start, tree), 10 * WAYPOINT_TOLERANCE):
        raise ValueError("the rows to keep do not hold at the start")
    length = float(np.linalg.norm(shift))
    if length == 0.0:
        return start[None]
    rows = _line_rows(tree, start, joint, np.array(joint_T_tool, np.float64), shift / length, keep)
    checked(tree, rows, tree.lower, tree.upper, moving)
    return _Follower(tree, rows, moving, _tolerances(rows, deviation, tilt)).follow(start, length)


@dataclass(frozen=True)
class _Follower:
    """A line as rows (the first is the progress along it), with the means to follow it."""

    tree: KinematicTree
    rows: Rows
    active: NDArray[np.bool_]
    tolerances: Array

    @cached_property
    def pieces(self) -> Pieces:
        """Scratch arrays of proofs."""
        return Pieces(*pieces_of(len(self.rows), len(self.tree.parent), self.tree.size))

    def follow(self, start: Array, length: float) -> Array | OffLine:
        """The way points from start to end of the line, or why there are none; steps are halved where they fail."""
        limits = np.array([MAX_JOINT_CHANGE, MIN_LINE_SHARE, 10.0**STORED_DECIMALS])
        given = self.rows, self.tolerances, self.tree, self.within, self.active, self.pieces
        way, here, there = followed(start, length, *given, MAX_ITERATIONS, limits)
        if here == 1.0:
            return np.asarray(way)
        fault = self.fault(way[-1], self.configuration_at(way[-1], there * length), here * length, there * length)
        assert fault is not None, "the last step failed"
        return fault

    def configuration_at(self, near: Array, progress: float, *, limits: bool = True) -> Array | None:
        """The configuration near another one with the tool at a point of the line, rounded; None if there is none.

        A joint that reaches its limit stops there, and the other joints compensate if they can.
        """
        self._set_progress(progress, progress)
        Q, succeeded = near[None].copy(), np.zeros(1, np.bool_)
        wanted, rule = (
            Wanted(self.rows, len(self.rows), self.no_aims, 0.0),
            Rule(MAX_ITERATIONS, FREEZES, *NO_AIMS),
        )
        project_seeds(Q, succeeded, wanted, self.within if limits else self.anywhere, self.active, rule)
        return np.round(Q[0], STORED_DECIMALS) if succeeded[0] else None

    def fault(self, q0: Array, q1: Array | None, progress0: float, progress1: float) -> OffLine | None:
        """Why the joint-linear segment between two way points does not follow the line, or None if it does."""
        if q1 is None:
            return self._why_not_there(q0, progress0, progress1)
        self._set_progress(progress0, progress1)
        smooth = np.abs(q1 - q0).max() <= MAX_JOINT_CHANGE
        kept = smooth and first_row_not_kept(self.rows, self.tolerances, q0, q1, self.tree, self.pieces) < 0
        return None if kept else OffLine("singular", progress0)

    def _why_not_there(self, q0: Array, progress0: float, progress1: float) -> OffLine:
        beyond = self.configuration_at(q0, progress1, limits=False)
        if beyond is None:
            return OffLine("out_of_reach", progress0)
        low, high = self.limits
        outside = ((beyond < low) | (beyond > high)).nonzero()[0]
        return OffLine("limit", progress0, int(outside[0])) if len(outside) else OffLine("singular", progress0)

    def _set_progress(self, lower: float, upper: float) -> None:
        self.rows[0, columns.LOWER] = lower
        self.rows[0, columns.UPPER] = upper

    @cached_property
    def no_aims(self) -> Array:
        """An array (R,) of NaN: no row aims at a value inside its bounds."""
        return np.full((1, len(self.rows)), np.nan)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """The joint limits, rounded inwards to the decimals of plans."""
        return storable_limits(self.tree.lower, self.tree.upper)

    @cached_property
    def within(self) -> KinematicTree:
        """The tree with these limits."""
        return limited(self.tree, *self.limits)

    @cached_property
    def anywhere(self) -> KinematicTree:
        """The tree without limits, to find the joint that would leave its own."""
        wide = np.full(self.tree.size, np.inf)
        return limited(self.tree, -wide, wide)


def _line_rows(
    tree: KinematicTree, q: Array, joint: int, joint_T_tool: Array, direction: Array, keep: Rows | None
) -> Rows:
    """Rows of the line: progress, two distances, and three for the orientation, which is zero at the start."""
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, *arrays_of(tree), world_T)
    rotation, origin = world_T[joint, :9].reshape(3, 3), world_T[joint, 9:]
    place = tuple(rotation @ joint_T_tool[:3, 3] + origin)
    point = FrameFeature(joint, "point", tuple(joint_T_tool[:3, 3]))
    across = normals(direction)
    parts = [
        rows_of("height", point, FrameFeature(0, "plane", place, tuple(n)), 0.0, 0.0) for n in (direction, *across)
    ]
    if keep is None:
        axes, turned = joint_T_tool[:3, :3].T, (rotation @ joint_T_tool[:3, :3]).T
        for k in range(3):
            moved = FrameFeature(joint, "line", point.origin, tuple(axes[k]))
            parts.append(
                rows_of("perpendicular", moved, FrameFeature(0, "line", place, tuple(turned[(k + 1) % 3])))
            )
    rows = stacked(parts if keep is None else [*parts, keep])
    rows[:, columns.TOLERANCE] = WAYPOINT_TOLERANCE
    return rows


def _tolerances(rows: Rows, deviation: float, tilt: float) -> Array:
    # Two distances add up to a deviation, at most three angular rows to a tilt.
    angular = rows[:, columns.KIND] >= columns.DIRECTION
    worst: Array = np.where(angular, tilt / np.sqrt(3.0), deviation / np.sqrt(2.0)) - WAYPOINT_TOLERANCE
    return worst


def _holds(rows: Rows, at: Array, tolerance: float) -> bool:
    return bool(np.all((at >= rows[:, columns.LOWER] - tolerance) & (at <= rows[:, columns.UPPER] + tolerance)))
