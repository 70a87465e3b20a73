"""How far a trajectory may be from the path that is proven: bounds for each joint and each piece of the path.

The trajectory between the times of two way points is compared with the straight piece between them: its projection is a
polynomial, so are the residuals of all joints, and what the projection leaves the piece by is added. Trajectories
of several robots are joined: their joints are one chain. Bernstein's coefficients bound both; nothing that a plan states
is used but the times at which it says to pass its way points.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.verify.motion.trajectories.curves import Curve, halves

TIME_ROUNDING = 2e-6  # [s] by which a way point may be passed earlier or later than its time says
ROUNDING = 1e-9  # [rad or m] of way points in plan files
SURE_HALVINGS, MAX_HALVINGS = 2, 12  # of an interval, always and while a bound is above `wanted`


class Deviations(NamedTuple):
    """The bounds (m - 1, n) for each piece of the path and each joint [rad or m]; when the greatest occurs [s]."""

    bounds: Array
    time: float

    @property
    def greatest(self) -> float:
        """The greatest of all bounds."""
        return float(self.bounds.max(initial=0.0))


def from_path(curve: Curve, waypoints: Array, times: Array, wanted: float = 0.0) -> Deviations:
    """The greatest distances of a trajectory from the straight pieces of its path.

    Args:
        curve: the trajectory of n joints.
        waypoints: the path (m, n).
        times: when the way points are passed (m,) [s].
        wanted: bounds above it are improved by further halvings until they are nearly exact.
    """
    passed = _passed(curve, waypoints, times)
    passed[0], passed[-1] = curve.times[0], curve.times[-1]
    return _from_path(curve, waypoints, passed, wanted)


def from_rest_of_piece(curve: Curve, ends: Array, times: Array) -> Array:
    """The deviations (n,) from `times[0]` on from the rest of one piece of the path, between two `ends` (2, n)."""
    passed = _passed(curve, ends, times)
    passed[0] = times[0]
    return np.asarray(_from_path(curve, ends, passed, 0.0).bounds[0])


def _from_path(curve: Curve, waypoints: Array, passed: Array, wanted: float) -> Deviations:
    starts, ends, pieces = _parts(curve, passed)
    ways = np.diff(waypoints, axis=0)
    offsets = curve.between(starts, ends) - waypoints[pieces][:, :, None]
    found = _from_pieces(offsets, ways[pieces], wanted)
    return _by_piece(found, pieces, len(ways), ends)


def from_joined(curves: Sequence[Curve], times: Array) -> Array:
    """The greatest distances (m - 1, n) of several trajectories, joined, from the pieces between their joined values.

    The joints of all trajectories are one chain, whose path is straight between its values at `times` (m,) [s]. No
    border of the trajectories' pieces may lie inside one of the m - 1 intervals.
    """
    rows = np.hstack([curve.at(times) for curve in curves])
    offsets = np.concatenate([curve.between(times[:-1], times[1:]) for curve in curves], axis=1)
    return _from_pieces(offsets - rows[:-1, :, None], np.diff(rows, axis=0), 0.0)


def _from_pieces(offsets: Array, ways: Array, wanted: float) -> Array:
    """The bounds (T, n) for polynomials (T, n, 6) relative to the first end of the straight piece of each (T, n)."""
    squares = np.einsum("tn,tn->t", ways, ways)
    along = ways / np.where(squares > 0.0, squares, 1.0)[:, None]
    shares = np.einsum("tnk,tn->tk", offsets, along)
    return _bounds(offsets - shares[:, None, :] * ways[:, :, None], shares, np.abs(ways), wanted)


def _passed(curve: Curve, waypoints: Array, times: Array) -> Array:
    """The times at which the trajectory is nearest to each way point, within what rounding of times may do."""
    q, speed = curve.at(times), curve.at(times, 1)
    square = np.einsum("mn,mn->m", speed, speed)
    late = np.einsum("mn,mn->m", waypoints - q, speed) / np.where(square > 1e-12, square, np.inf)
    room = np.minimum(np.diff(times, prepend=-np.inf), np.diff(times, append=np.inf)) / 4
    most = np.minimum(TIME_ROUNDING, room)
    return np.asarray(np.clip(times + np.clip(late, -most, most), curve.times[0], curve.times[-1]))


def _parts(curve: Curve, passed: Array) -> tuple[Array, Array, Integers]:
    """The intervals of time without a way point or a border of pieces inside, and the path's piece for each."""
    inner = curve.times[(curve.times > passed[0]) & (curve.times < passed[-1])]
    cuts = np.unique(np.concatenate([inner, passed]))
    starts, ends = cuts[:-1], cuts[1:]
    pieces = np.searchsorted(passed, (starts + ends) / 2, side="right") - 1
    return starts, ends, np.clip(pieces, 0, len(passed) - 2)


def _bounds(residuals: Array, shares: Array, lengths: Array, wanted: float) -> Array:
    """The bounds (T, n): of residuals (T, n, 6), with what shares (T, 6) leave [0, 1] by of the lengths (T, n)."""
    own = np.arange(len(residuals))
    result = np.zeros(residuals.shape[:2])
    for depth in range(MAX_HALVINGS + 1):
        beyond = np.maximum(0.0, np.maximum(shares.max(axis=1) - 1.0, -shares.min(axis=1)))
        bounds = np.abs(residuals).max(axis=2) + beyond[:, None] * lengths
        enough = wanted if depth >= SURE_HALVINGS else 0.0
        open_ = bounds.max(axis=1) > max(enough, ROUNDING)
        if depth == MAX_HALVINGS:
            open_[:] = False
        elif depth >= SURE_HALVINGS:
            ends = np.abs(residuals[..., [0, -1]]).max(axis=2)  # is reached: halving does not help
            open_ &= (ends <= wanted).all(axis=1)
        np.maximum.at(result, own[~open_], bounds[~open_])
        if not open_.any():
            break
        first, second = halves(residuals[open_])
        share, other = halves(shares[open_])
        residuals, shares = np.concatenate([first, second]), np.concatenate([share, other])
        lengths, own = np.tile(lengths[open_], (2, 1)), np.tile(own[open_], 2)
    return result


def _by_piece(found: Array, pieces: Integers, count: int, ends: Array) -> Deviations:
    result = np.zeros((count, found.shape[1]))
    np.maximum.at(result, pieces, found)
    worst = int(found.max(axis=1, initial=0.0).argmax()) if len(found) else 0
    return Deviations(result, float(ends[worst]))
