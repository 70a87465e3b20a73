"""How far a motion is from straight lines that are proportional to time: the bound for several motions at once.

Motions that run at the same time are proven together, on one path whose way points are their places at common times.
Between two of these times each motion is compared with the chord between its places then, at the same time.
"""

import numpy as np

from kabo.arrays import Array
from kabo.motion.bernstein import bernstein, halved, recentred

HALVINGS = 2  # of each interval, for tighter bounds


def chord_deviations(times: Array, padded: Array, waypoints: Array, passing: Array) -> Array:
    """The distance (m - 1, n) that no joint exceeds from the line proportional to time between two way points.

    Args:
        times: the ends of the motion's pieces (k + 1,) [s].
        padded: the motion's coefficients (k, n, 6).
        waypoints: the places (m, n) that are compared with, straight between them.
        passing: their times (m,) [s], increasing, within those of the motion; no end of a piece lies between two.
    """
    piece = np.clip(np.searchsorted(times, (passing[:-1] + passing[1:]) / 2, side="right") - 1, 0, len(times) - 2)
    spans = np.diff(passing)
    delays = np.broadcast_to((passing[:-1] - times[piece])[:, None], padded[piece].shape[:2])
    parts = recentred(padded[piece], delays)
    parts[..., 0] -= waypoints[:-1]
    parts[..., 1] -= np.diff(waypoints, axis=0) / spans[:, None]
    controls = bernstein(parts, np.broadcast_to(spans[:, None], parts.shape[:2]))[None]
    for _ in range(HALVINGS):
        controls = halved(controls).reshape(-1, *controls.shape[1:])
    return np.asarray(np.abs(controls).max(axis=(0, -1)))
