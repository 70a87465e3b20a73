"""Samples that fulfil constraints, each a pure function of a key and an index, so that any worker can draw any sample."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array
from kabo.kinematics.constraints import ROW_TOLERANCE, Rows, stacked
from kabo.kinematics.kernels import projection as kernels
from kabo.kinematics.kernels import streams
from kabo.kinematics.projection import MAX_ITERATIONS, checked, limited
from kabo.scene.tree import KinematicTree
from kabo.streams import Key

AIM_TRIES = 4  # seeds from which a sample tries to reach its aims: nine of ten reachable aims are then reached


def uniform(key: Key, index: int, dimension: int) -> float:
    """Number `dimension` of sample `index` of the stream, in [0, 1)."""
    return float(streams.uniform(np.uint64(key), index, dimension))


def seeds(lower: ArrayLike, upper: ArrayLike, key: Key, first: int, count: int) -> Array:
    """Samples from `first` on, (count, n), uniform between the bounds; an unbounded joint takes one turn."""
    low, high = _bounded(lower, upper)
    drawn = np.empty((count, len(low)))
    streams.draw(np.uint64(key), first, drawn, low, high)
    return drawn


def sample(
    tree: KinematicTree,
    rows: Rows,
    key: Key,
    first: int,
    count: int,
    lower: ArrayLike,
    upper: ArrayLike,
    active: ArrayLike,
    free: Rows | None = None,
    *,
    base: ArrayLike | None = None,
    starts: Array | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Configurations (count, n) that fulfil the rows, from sample `first` on, and which of them are valid (count,).

    Seeds are uniform between the limits. A joint that ends outside its limits, after whole turns, is fixed at its
    seed, and the others compensate; so samples do not accumulate at limits. A row with an interval aims at a value
    inside it, evenly spread over the samples, and so does each row of `free`, which need not hold in the end.
    Sample i depends on (key, i) only.

    Args:
        tree, rows, lower, upper, active: tree, constraint rows, limits and mask, as for `project`.
        key: the key of the random stream, from `stream_key`.
        free: rows that spread the samples along what the constraints leave free, such as an azimuth.
        base: (n,) the values of the joints that are not active; default zero, clipped to the limits.
        starts: (count, n) the seeds, instead of uniform ones, and the values of the joints that are not active.

    Raises:
        ValueError: shapes do not fit, or a number is not finite.
    """
    every = stacked([rows] if free is None else [rows, free])  # a copy: one kind of array, one kernel
    low, high, moving = checked(tree, every, lower, upper, np.asarray(active, np.bool_))
    start = np.clip(0.0, low, high) if base is None else np.array(base, np.float64)
    if start.shape != (tree.size,) or not np.all(np.isfinite(start)):
        raise ValueError(f"the base configuration must be finite, ({tree.size},), not {start.shape}")
    drawn = starts is None
    if starts is None:
        starts = np.where(moving, seeds(low, high, key, first, count), start)
    Q = np.array(starts, np.float64, order="C")
    succeeded = np.zeros(count, np.bool_)
    aims = np.empty((count, len(every)))
    kernels.draw_aims(np.uint64(key), first, every, aims)
    tries = AIM_TRIES if drawn else 1  # other seeds are nowhere near
    wanted = kernels.Wanted(every, len(rows), aims, 2 * ROW_TOLERANCE)
    rule = kernels.Rule(MAX_ITERATIONS, kernels.WRAPS | kernels.RETURNS, np.uint64(key), first, tries)
    kernels.project_seeds(Q, succeeded, wanted, limited(tree, low, high), moving, rule)
    return Q, succeeded


def _bounded(lower: ArrayLike, upper: ArrayLike) -> tuple[Array, Array]:
    low, high = np.array(lower, np.float64), np.array(upper, np.float64)
    return np.where(np.isfinite(low), low, -np.pi), np.where(np.isfinite(high), high, np.pi)
