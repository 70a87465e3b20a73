"""From corners to a motion: the path that is followed, and the fastest times along it within the limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.motion.bernstein import recentred
from kabo.motion.following import path_deviations
from kabo.motion.limits import Held, MotionLimits
from kabo.motion.s_curves import TICK, line_pieces
from kabo.motion.trajectory import DECIMALS, Trajectory, short_pieces

WAYPOINT_DECIMALS = 9  # of joint values in plans
MIN_DEVIATION = 1e-9  # [rad or m]: what rounding of coefficients and way points may leave


@dataclass(frozen=True)
class Timed:
    """A path of n joints with its motion, from rest at time 0 to rest.

    Attributes:
        waypoints: the path (m, n), straight in joint space between way points: corners where the motion stops, and chords
            where they are rounded. Values are rounded to 9 decimals.
        passing: when the motion passes each way point (m,) [s]; whole microseconds, not decreasing.
        corners: for each corner that was given its index in `waypoints`; of a rounded corner, the middle of the round.
        times: the ends of the motion's pieces (k + 1,) [s], whole microseconds.
        coefficients: the pieces (k, n, 6), as in `Trajectory`, rounded to 12 decimals.
    """

    waypoints: Array
    passing: Array
    corners: tuple[int, ...]
    times: Array
    coefficients: Array

    @property
    def duration(self) -> float:
        """The time of the whole motion [s]."""
        return float(self.times[-1])

    @cached_property
    def deviations(self) -> Array:
        """The distance (m - 1, n) that no joint exceeds while the motion follows each piece of the path."""
        return path_deviations(self.times, self.coefficients, self.waypoints, self.passing)

    def trajectory(self, joints: Sequence[str], *, start: float = 0.0) -> Trajectory:
        """The whole motion as a trajectory that begins at the time `start` [s]."""
        return self.parts(joints, (), start=start)[0]

    def parts(self, joints: Sequence[str], corners: Sequence[int], *, start: float = 0.0) -> list["Trajectory"]:
        """The motion cut at some of its corners (numbers of the given ones), as trajectories one after the other.

        The first begins at the time `start` [s]. Each follows its part of the path.
        """
        cuts = [0, *(self.corners[number] for number in corners), len(self.waypoints) - 1]
        return [self._part(joints, first, last, start) for first, last in zip(cuts, cuts[1:], strict=False)]

    def passed(self, first: int, last: int, *, start: float = 0.0) -> tuple[float, ...]:
        """When the way points from `first` to `last` (indices) are passed, if the whole motion begins at `start` [s]."""
        return tuple(np.round(self.passing[first : last + 1] + start, 6).tolist())

    def _part(self, joints: Sequence[str], first: int, last: int, start: float) -> Trajectory:
        begin, end = self.passing[first], self.passing[last]
        low = int(np.searchsorted(self.times, begin, side="right")) - 1
        high = int(np.searchsorted(self.times, end, side="left"))
        times, pieces = self.times[low : high + 1].copy(), self.coefficients[low:high].copy()
        if times[0] < begin:
            pieces[0] = np.round(recentred(pieces[0], np.full(pieces.shape[1], begin - times[0])), DECIMALS)
        times[0], times[-1] = begin, end
        return Trajectory.of_arrays(
            joints,
            self.waypoints[first : last + 1],
            np.round(times + start, 6),
            pieces,
            stated(self.deviations[first:last]),
        )


def stated(deviations: Array) -> float:
    """The deviation that a trajectory states [rad or m]: none of those found is greater; nine decimals, at least 1e-9."""
    return float(np.ceil(deviations.max(initial=0.0) / MIN_DEVIATION + 1e-3) * MIN_DEVIATION)


def timed_path(
    corners: ArrayLike,
    limits: MotionLimits,
    *,
    deviation: float = 0.0,
    shares: Sequence[float] | None = None,
    held: Held | None = None,
) -> Timed:
    """The fastest motion along corners (m, n) within the limits, from rest to rest.

    Values of corners are rounded to 9 decimals, as plans keep them. Corners that then equal the one before are passed at
    once with it.

    Args:
        corners: at least one.
        limits: of the n joints, positive for joints that move.
        deviation: how far the path may pass by its corners [rad, L2].
        held: what the robot holds, and how hard it may be accelerated.
        shares: (m,) the fraction of its greatest trim that each corner gets; at 0 the motion stops there. Without them it
            stops at every corner.

    Raises:
        ValueError: a joint that moves has a limit of zero, or shapes do not fit.
    """
    points = np.round(np.array(corners, np.float64), WAYPOINT_DECIMALS) + 0.0
    if points.ndim != 2 or not len(points) or points.shape[1:] != limits.velocity.shape:
        raise ValueError(f"corners (m, n) and limits (n,) do not fit: {points.shape}, {limits.velocity.shape}")
    different = np.concatenate([[True], np.any(np.diff(points, axis=0) != 0.0, axis=1)])
    numbers = np.cumsum(different) - 1
    return _stopping(points[different], limits, tuple(numbers.tolist()))


def _stopping(points: Array, limits: MotionLimits, corners: tuple[int, ...]) -> Timed:
    """The motion that stops at all way points, which differ from their neighbours."""
    if len(points) == 1:
        return _still(points[0], corners)
    spans: list[int] = []
    pieces: list[Array] = []
    passing = [0]
    for start, end in zip(points, points[1:], strict=False):
        own, coefficients = line_pieces(start, end, limits)
        spans += own
        pieces.append(coefficients)
        passing.append(passing[-1] + sum(own))
    times, padded = short_pieces(np.cumsum([0, *spans]) / 1e6, np.concatenate(pieces))
    return Timed(points, np.asarray(passing) / 1e6, corners, times, np.round(padded, DECIMALS) + 0.0)


def _still(point: Array, corners: tuple[int, ...]) -> Timed:
    """A motion of one microsecond that stays where it is, for a path needs two way points and a time between them."""
    pieces = np.zeros((1, len(point), 6))
    pieces[0, :, 0] = point
    ends = np.array([0.0, TICK])
    return Timed(np.stack([point, point]), ends, (*corners[:-1], min(1, len(corners) - 1)), ends, pieces)
