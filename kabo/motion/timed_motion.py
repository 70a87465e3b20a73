"""From corners to a motion: the path that is followed, and the fastest times along it within the limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array, Integers
from kabo.motion.bernstein import derivative, recentred, values
from kabo.motion.blending import (
    CORNER_SHARE,
    GENTLE_TURN,
    MAX_SHRINKING,
    MIN_PIECE_LENGTH,
    MIN_SHRINKING,
    Blended,
    blended,
)
from kabo.motion.following import path_deviations
from kabo.motion.kernels.deviations import pieces_beyond, positions_at
from kabo.motion.kernels.near_pieces import Course, with_middles
from kabo.motion.kernels.rounded_paths import rounded_path_of, usable_corners
from kabo.motion.limits import Held, MotionLimits
from kabo.motion.rounding import rounded_coefficients
from kabo.motion.s_curves import TICK, line_limits, line_pieces, stopping_ticks
from kabo.motion.section import CURVATURE_SAMPLES, LEAST_SPARE, Section, held_share, section, way_points
from kabo.motion.trajectory import Trajectory

WAYPOINT_DECIMALS = 9  # of joint values in plans
SAME_CORNER = 2e-9  # [rad or m, L2]: corners that are closer differ by rounding
REVERSAL = 1.99  # norm of the difference of two unit vectors from which the path turns back on itself
_SHRINKING = np.array([MIN_SHRINKING, MAX_SHRINKING])
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
        coefficients: the pieces (k, n, 6), as in `Trajectory`, rounded as plans keep them.
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

    def with_deviations(self, deviations: Array) -> "Timed":
        """The same motion; its deviations (m - 1, n) are known already."""
        vars(self)["deviations"] = deviations
        return self

    @property
    def course(self) -> Course:
        """The arrays of the motion as kernels take them."""
        corners = np.array(self.corners, np.int64)
        return Course(self.times, self.coefficients, self.waypoints, self.passing, self.deviations, corners)

    def with_middles(self, pieces: Integers, decimals: int) -> tuple["Timed", Integers]:
        """The same motion with a way point in the middle of some pieces of its path, and the indices of their halves.

        Times of way points are rounded to some decimals.
        """
        waypoints, passing, deviations, corners, halves = with_middles(self.course, pieces, 10.0**decimals)
        found = Timed(waypoints, passing, tuple(corners.tolist()), self.times, self.coefficients)
        return found.with_deviations(deviations), halves

    def at(self, moments: Array) -> Array:
        """The values (k, n) of the joints at some moments (k,) [s]."""
        return np.asarray(positions_at(self.times, self.coefficients, moments))

    def beyond(self, lower: Array, upper: Array) -> NDArray[np.bool_]:
        """The pieces (k,) of the motion on which a joint may leave its bounds (n,)."""
        return np.asarray(pieces_beyond(self.times, self.coefficients, lower, upper))

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
            pieces[0] = recentred(pieces[0], np.full(pieces.shape[1], begin - times[0]))
        times[0], times[-1] = begin, end
        pieces = rounded_coefficients(pieces, np.diff(times))
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
    shares: ArrayLike | None = None,
    chord: float = 1e-3,
    tolerance: float = 1e-4,
    held: Held | None = None,
    slopes: Array | None = None,
) -> Timed:
    """The fastest motion along corners (m, n) within the limits, from rest to rest.

    Values of corners are rounded to 9 decimals, as plans keep them. Corners that then equal the one before, but
    for rounding, are passed at once with it.

    Args:
        corners: at least one.
        limits: of the n joints, positive for joints that move.
        deviation: how far the path may pass by its corners [rad, L2].
        shares: (m,) the fraction of its greatest trim that each corner gets; at 0 the motion stops there, as it does where
            the path turns back, and at corners that are given twice. Without shares it stops at every corner.
        chord: how far way points on blends may leave the straight pieces between them from the blend [rad, L2].
        tolerance: how far a joint may leave the blend, so that pieces are few [rad or m].
        held: what the robot holds, and how hard it may be accelerated.
        slopes: (m - 1, 2, n) the derivatives of the path where each piece begins and ends, as of `Blended`; corners then
            differ from their neighbours. Corners without a turn are passed exactly, and never stopped at.

    Raises:
        ValueError: a joint that moves has a limit of zero, or shapes do not fit.
    """
    rounding = _Rounding(deviation, shares, chord, tolerance, held, slopes)
    points, numbers, own = _prepared(corners, len(limits.velocity), rounding)
    return _still(points[0], numbers) if len(points) == 1 else _moving(points, limits, own, numbers)


def rounded_path(
    corners: ArrayLike,
    *,
    deviation: float,
    shares: ArrayLike,
    chord: float = 1e-3,
    slopes: Array | None = None,
) -> tuple[Timed, Array]:
    """The path that `timed_path` follows, as a motion at unit speed whose times are the parameter, and all trims (m,).

    Corners at which a stop saves time are rounded, too. What is not proven of the path need not be timed.
    """
    rows = np.ascontiguousarray(corners, np.float64)
    points, different, back = usable_corners(rows, SAME_CORNER, REVERSAL)
    if len(points) > 1 and different and deviation > 0.0:
        return _rounded_at_once(
            points, np.where(back, 0.0, np.asarray(shares, np.float64)), deviation, chord, slopes
        )
    points, numbers, own = _prepared(rows, rows.shape[1], _Rounding(deviation, shares, chord, 0.0, None, slopes))
    path = _blended(points, own)
    passing, indices = way_points(path, chord)
    waypoints = np.round(path.at(passing), WAYPOINT_DECIMALS) + 0.0
    places = tuple(indices[number] for number in numbers)
    return Timed(waypoints, passing, places, path.borders, path.coefficients), path.trims[numbers]


def _rounded_at_once(
    points: Array, shares: Array, deviation: float, chord: float, slopes: Array | None
) -> tuple[Timed, Array]:
    """`rounded_path` of corners (m, n) that differ, in one kernel."""
    given = np.zeros((0, 2, 0)) if slopes is None else np.ascontiguousarray(slopes, np.float64)
    limits = np.array([deviation, CORNER_SHARE, GENTLE_TURN, MIN_PIECE_LENGTH])
    trims, borders, pieces, passing, indices, waypoints, deviations = rounded_path_of(
        points, given, slopes is None, shares, chord, CURVATURE_SAMPLES, limits, _SHRINKING
    )
    path = Timed(waypoints, passing, tuple(indices.tolist()), borders, pieces)
    return path.with_deviations(deviations), trims


class _Rounding(NamedTuple):
    deviation: float
    shares: ArrayLike | None
    chord: float
    tolerance: float
    held: Held | None
    slopes: Array | None


def _prepared(corners: ArrayLike, joints: int, given: _Rounding) -> tuple[Array, list[int], _Rounding]:
    """The corners (m, n) that differ from the one before, the number of each given one, and the shares of those."""
    points: Array = np.asarray(np.round(np.array(corners, np.float64), WAYPOINT_DECIMALS) + 0.0, np.float64)
    if points.ndim != 2 or not len(points) or points.shape[1] != joints:
        raise ValueError(f"corners (m, n) and limits (n,) do not fit: {points.shape}, ({joints},)")
    different = np.ones(len(points), np.bool_)
    different[1:] = np.linalg.norm(np.diff(points, axis=0), axis=1) > SAME_CORNER
    wanted = np.zeros(len(points)) if given.shares is None else np.array(given.shares, np.float64)
    numbers, slopes = list(range(len(points))), given.slopes
    if not different.all():
        numbers, slopes = (np.cumsum(different) - 1).tolist(), None
        wanted = np.where(np.diff(np.flatnonzero(np.append(different, True))) == 1, wanted[different], 0.0)
        end, points = points[-1], points[different]
        if len(points) > 1:
            points[-1] = end  # the end is reached exactly
    if len(points) > 1:
        wanted[_reversals(points) | (given.deviation <= 0.0)] = 0.0
    return points, numbers, given._replace(shares=wanted, slopes=slopes)


def _blended(points: Array, rounding: _Rounding) -> Blended:
    return blended(points, max(rounding.deviation, 0.0), rounding.shares, rounding.slopes)


def _moving(points: Array, limits: MotionLimits, rounding: _Rounding, numbers: list[int]) -> Timed:
    """The motion along way points that differ from their neighbours; `numbers` says which of them each corner is."""
    shares = np.array(rounding.shares)
    while True:
        path = _blended(points, rounding._replace(shares=shares))
        stops = path.stops
        found = [
            _section(path, first, last, limits, rounding) for first, last in zip(stops, stops[1:], strict=False)
        ]
        slow = [
            corner
            for each, first in zip(found, stops, strict=False)
            for corner in _not_worth(each, first, points, limits, rounding)
            if path.trims[corner] > 0.0
        ]
        if not slow:
            break
        shares[slow] = 0.0
    begins = np.cumsum([0, *(int(each.ends[-1]) for each in found)])
    ends = np.concatenate([[0], *(each.ends[1:] + begin for each, begin in zip(found, begins, strict=False))])
    passing = np.concatenate(
        [[0], *(each.passing[1:] + begin for each, begin in zip(found, begins, strict=False))]
    )
    indices, before = [0], 0
    for each in found:
        indices += [before + index for index in each.corners[1:]]
        before += len(each.passing) - 1
    times = ends / 1e6
    padded = rounded_coefficients(np.concatenate([each.coefficients for each in found]), np.diff(times))
    waypoints = _places(times, padded, passing / 1e6)
    stopped = [indices[number] for number in stops]
    waypoints[stopped] = points[stops]
    return Timed(waypoints, passing / 1e6, tuple(indices[number] for number in numbers), times, padded)


def _section(path: Blended, first: int, last: int, limits: MotionLimits, rounding: _Rounding) -> Section:
    """The motion from one corner where it stops to the next."""
    own = path.between(first, last)
    if last == first + 1 and not own.curved.any():
        spans, pieces = line_pieces(path.corners[first], path.corners[last], limits)
        ends = np.cumsum([0, *spans])
        if rounding.held is None or (
            rounding.held.spare > LEAST_SPARE and held_share(ends, pieces, rounding.held) <= 1.0
        ):
            return Section(ends, pieces, ends[[0, -1]], [0, 1])
    if not all(each.all() for each in limits.rows):
        for step in np.diff(own.corners, axis=0):
            line_limits(step, limits)  # refuses joints that move without limits
    return section(own, limits, rounding.chord, rounding.tolerance, rounding.held)


def _not_worth(found: Section, first: int, points: Array, limits: MotionLimits, rounding: _Rounding) -> list[int]:
    """Corners where the motion should stop, as all in all it is slower than with stops: the slowest quarter of them."""
    count = len(found.corners) - 2
    if count < 1:
        return []
    between = points[first : first + count + 2]
    if found.ends[-1] < stopping_ticks(between, limits):
        return []
    if rounding.held is not None:  # with stops it is slower than that, too
        stopping = blended(between, 0.0, [0.0] * len(between))
        ways = [_section(stopping, k, k + 1, limits, rounding) for k in range(count + 1)]
        if found.ends[-1] < sum(int(each.ends[-1]) for each in ways):
            return []
    inner = found.passing[found.corners[1:-1]]
    k = np.clip(np.searchsorted(found.ends, inner, side="right") - 1, 0, len(found.coefficients) - 1)
    local = np.asarray((inner - found.ends[k])[:, None] * TICK, np.float64)
    speeds = np.abs(values(np.asarray(derivative(found.coefficients[k], 1), np.float64), local)) / np.maximum(
        limits.velocity, TICK
    )
    slowest = np.argsort(speeds.max(axis=1), kind="stable")[: (count + 3) // 4]
    return [first + 1 + int(k) for k in slowest]


def _reversals(points: Array) -> NDArray[np.bool_]:
    """Whether the path turns back on itself at each corner."""
    steps = np.diff(points, axis=0)
    units = steps / np.linalg.norm(steps, axis=1)[:, None]
    found = np.zeros(len(points), np.bool_)
    found[1:-1] = np.linalg.norm(np.diff(units, axis=0), axis=1) > REVERSAL
    return found


def _places(times: Array, padded: Array, passing: Array) -> Array:
    """The positions (m, n) at the increasing times `passing`, as plans keep them."""
    return np.asarray(np.round(positions_at(times, padded, passing), WAYPOINT_DECIMALS) + 0.0)


def _still(point: Array, corners: list[int]) -> Timed:
    """A motion of one microsecond that stays where it is, for a path needs two way points and a time between them."""
    pieces = np.zeros((1, len(point), 6))
    pieces[0, :, 0] = point
    ends = np.array([0.0, TICK])
    return Timed(np.stack([point, point]), ends, (*corners[:-1], int(len(corners) > 1)), ends, pieces)
