"""Times along a path: each segment takes as long as its slowest joint needs."""

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array

TIME_STEP = 1e-6  # [s]: times in plans are whole microseconds


def retime(waypoints: ArrayLike, velocity_limits: ArrayLike, *, factor: float = 1.0) -> Array:
    """The time of each way point (m,) [s], from 0, strictly increasing, whole microseconds.

    Every segment is linear in time; no joint exceeds `factor` times its limit, since times are rounded up.
    Velocities jump at corners, so a caller who wants gentle motions passes a small factor.

    Args:
        waypoints: (m, n) [rad or m].
        velocity_limits: (n,) [rad/s or m/s], positive; only those of joints that move matter.

    Raises:
        ValueError: a joint that moves has no positive velocity limit, or shapes do not fit.
    """
    path, limits = np.array(waypoints, np.float64), np.array(velocity_limits, np.float64)
    if path.ndim != 2 or path.shape[1:] != limits.shape or not len(path):
        raise ValueError(f"way points (m, n) and limits (n,) do not fit: {path.shape}, {limits.shape}")
    changes = np.abs(np.diff(path, axis=0))
    moved = changes.max(axis=0, initial=0.0) > 0.0
    if not np.all(limits[moved] > 0.0):
        raise ValueError(f"joints that move need positive velocity limits, not {limits[moved]}")
    seconds = (changes[:, moved] / (factor * limits[moved])).max(axis=1, initial=0.0)
    ticks = np.maximum(1, np.ceil(seconds / TIME_STEP)).astype(np.int64)
    return np.concatenate([[0], np.cumsum(ticks)]) / 1e6
