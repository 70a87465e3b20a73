"""Shortcuts: random pairs of points along a path are connected directly where this is proven free.

[Geraerts, Overmars 2007]. Every segment of the result is proven, remainders of cut segments too.
"""

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.kinematics.sampling import uniform
from kabo.streams import Key
from kabo.ways.edges import STORED_DECIMALS, FreeConfigurations, FreeSegment, FreeSpace, Projection

MIN_GAIN = 1e-3  # [rad, L2] that a shortcut must save: less is not worth its proof


def shortcut(
    waypoints: ArrayLike,
    free_segment: FreeSegment,
    key: Key,
    attempts: int,
    *,
    free_configurations: FreeConfigurations | None = None,
    projection: Projection | None = None,
    patience: int | None = None,
) -> Array:
    """A path (m, n) with the same ends that is no longer (L2) and whose new segments are all proven free.

    Args:
        waypoints: (k, n), each segment proven free.
        free_segment: the proof that a segment is free, as for `connect`.
        projection: the projection onto the path's constraint, as for `connect`.
        key: the key of the random numbers; attempt i depends on (key, i) and the path before it only.
        attempts: the number of pairs of points to try.
        free_configurations: the cheaper check before the proof, as for `connect`; None: no such check.
        patience: the number of attempts in a row that may fail; None for no limit.
    """
    path = np.array(waypoints, np.float64)
    space, vain = FreeSpace(free_segment, free_configurations, projection), 0
    for attempt in range(attempts):
        if len(path) < 3 or (patience is not None and vain >= patience):
            break
        ends = sorted(uniform(key, attempt, k) for k in range(2))
        found = _shortened(path, ends[0], ends[1], space)
        vain = vain + 1 if found is None else 0
        path = path if found is None else found
    return path


def length(waypoints: Array) -> float:
    """The length of a path [rad, L2 over the joints]."""
    return float(np.linalg.norm(np.diff(waypoints, axis=0), axis=1).sum())


def _shortened(path: Array, share0: float, share1: float, space: FreeSpace) -> Array | None:
    """The path with a shortcut between two fractions of its length; None if it is blocked or saves too little."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    (i, a), (j, b) = (_point(path, lengths, share * lengths[-1]) for share in (share0, share1))
    if i == j or lengths[-1] == 0.0:
        return None
    saved = (share1 - share0) * lengths[-1] - float(np.linalg.norm(b - a))
    if saved < MIN_GAIN:
        return None
    between = _way(a, b, space)
    if between is None:
        return None
    found = _distinct([*path[: i + 1], a, *between, *path[j + 1 :]])
    if not length(found) < lengths[-1]:
        return None
    remainders = [(path[i], a), (b, path[j + 1])]
    whole = all(np.array_equal(q0, q1) or space.free_segment(q0, q1) < 0 for q0, q1 in remainders)
    return found if whole else None


def _way(a: Array, b: Array, space: FreeSpace) -> list[Array] | None:
    """The way points after a of a proven path to b, straight or along the constraint; None if blocked."""
    if space.is_free(a, b):
        return [b]
    if space.projection is None:
        return None
    way = space.extend(a, b, 2.0 * float(np.linalg.norm(b - a)))
    return way if way and np.array_equal(way[-1], b) else None


def _point(path: Array, lengths: Array, at: float) -> tuple[int, Array]:
    """The index of the segment at a length along the path, and the rounded point there."""
    i = min(int(np.searchsorted(lengths, at, side="right")) - 1, len(path) - 2)
    piece = lengths[i + 1] - lengths[i]
    share = (at - lengths[i]) / piece if piece > 0.0 else 0.0
    if share <= 0.0 or share >= 1.0:
        return i, path[i if share <= 0.0 else i + 1]
    return i, np.round(path[i] + share * (path[i + 1] - path[i]), STORED_DECIMALS)


def _distinct(way: list[Array]) -> Array:
    """The way points without consecutive repetitions."""
    kept = [way[0]]
    kept += [q for before, q in zip(way, way[1:], strict=False) if not np.array_equal(before, q)]
    return np.array(kept)
