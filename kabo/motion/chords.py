"""How far motions that run at the same time are from their joined path: bounds per piece and joint, without sampling.

The joints of all robots that move at once are one chain. Its path is straight between the joined places at common times.
While the motions are between two of these places, they are compared with the projection of the joined place onto the
piece between them, so motions with a common law along a straight line follow it exactly.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.motion.bernstein import recentred
from kabo.motion.following import away_from_pieces

TIME_STEP = 0.02  # [s] at most between way points of motions that run at the same time,
MAX_STEPS = 100  # but no more of them between two ends of pieces: slow motions have the same shape as fast ones


class Polynomials(NamedTuple):
    """A motion: the ends of its pieces (k + 1,) [s], and their coefficients (k, n, 6)."""

    times: Array
    padded: Array


def joined_deviations(motions: Sequence[Polynomials], waypoints: Array, passing: Array) -> Array:
    """The distance (m - 1, n) that no joint of several motions exceeds from each piece of their joined path.

    Args:
        motions: at least one; the joints of all, one motion after the other, are the columns of the path.
        waypoints: the joined path (m, n), straight between way points.
        passing: their times (m,) [s], increasing, within those of each motion; no end of a piece of a motion lies between
            two of them.
    """
    middle, spans = (passing[:-1] + passing[1:]) / 2, np.diff(passing)
    parts = np.concatenate([_between(motion, passing[:-1], middle) for motion in motions], axis=1)
    parts[..., 0] -= waypoints[:-1]
    return away_from_pieces(parts, np.diff(waypoints, axis=0), spans)


def passing_times(ends: Sequence[float]) -> Array:
    """The times (m,) [s] of the way points of motions that run at the same time, given the ends of all their pieces."""
    counts = np.clip(np.ceil(np.diff(ends) / TIME_STEP - 1e-9), 1, MAX_STEPS).astype(int)
    cut = [np.arange(n) / n * (b - a) + a for a, b, n in zip(ends, ends[1:], counts, strict=False)]
    return np.concatenate([*cut, ends[-1:]])


def _between(motion: Polynomials, begin: Array, middle: Array) -> Array:
    """The coefficients (m - 1, n, 6) of a motion in times that count from each `begin` (m - 1,)."""
    piece = np.clip(np.searchsorted(motion.times, middle, side="right") - 1, 0, len(motion.times) - 2)
    own = motion.padded[piece]
    return recentred(own, np.broadcast_to((begin - motion.times[piece])[:, None], own.shape[:2]))
