"""How far a motion is from the path that it follows: bounds per piece of the path and joint, without sampling.

A path is straight in joint space between way points. While the motion passes piece i, from way point w_i along D_i, it is
compared with the point w_i + λ D_i, where λ(t) is the projection onto the piece: a polynomial, as the motion is one. The
difference is bounded by its Bernstein coefficients; where λ leaves [0, 1], the end of the piece is the point to compare
with, which is farther by the excess of λ.
"""

from collections.abc import Sequence
from itertools import chain
from math import isfinite

import numpy as np

from kabo.arrays import Array, Integers
from kabo.motion.bernstein import derivative, values

SNAPPED = 1e-9  # [rad or m]: a place on the path that is closer to a way point is this way point
Row = tuple[float, ...]
Rows = tuple[Row, ...]
BACKWARDS = 1e-3  # [rad or m]: how far a motion against the direction of a piece counts as being from it
INNER_SAMPLES = 3  # inside each piece of a motion, where places on the path are looked for


def require_way_points(waypoints: Sequence[Sequence[float]]) -> None:
    """Checks the path of a motion.

    Raises:
        ValueError: a value is not finite, or too large for a float.
    """
    try:
        finite = all(map(isfinite, chain.from_iterable(waypoints)))
    except OverflowError:  # a whole number of Python has no bounds
        finite = False
    if not finite:
        raise ValueError("a value of a way point is not a finite number")


def divided_path(padded: Array, times: Array, waypoints: Sequence[Row], time: float) -> tuple[Rows, Rows]:
    """The path that a motion follows until `time`, and the one from then on; of a motion without a path both are empty."""
    if not waypoints:
        return (), ()
    path = (*waypoints, *waypoints) if len(waypoints) == 1 else tuple(waypoints)  # from a place to itself
    index, place = place_on_path(padded, times, np.asarray(path), time)
    first, second, point = path[: index + 1], path[index + 1 :], tuple(map(float, place))
    return (
        first if first[-1] == point and len(first) > 1 else (*first, point),
        second if second[0] == point and len(second) > 1 else (point, *second),
    )


def path_deviations(times: Array, padded: Array, waypoints: Array, passing: Array) -> Array:
    """The distance (m - 1, n) that no joint exceeds from the path, while the motion follows each of its pieces.

    Args:
        times: the ends of the motion's pieces (k + 1,) [s].
        padded: the motion's coefficients (k, n, 6).
        waypoints: the path (m, n).
        passing: when the motion passes each way point (m,) [s], not decreasing, from `times[0]` to `times[-1]`.
    """
    from kabo.motion.kernels.deviations import distances_of_path  # noqa: PLC0415 - plans are read without kernels

    rows = (np.ascontiguousarray(each, np.float64) for each in (times, padded, waypoints, passing))
    return np.asarray(distances_of_path(*rows))


def away_from_pieces(parts: Array, steps: Array, spans: Array) -> Array:
    """The distance (p, n) that no joint exceeds from straight pieces: residuals of the projection, and its excess.

    Args:
        parts: the coefficients (p, n, 6) of motions relative to the first way point of their piece.
        steps: from the first to the last way point of the piece of each (p, n).
        spans: the durations (p,) [s].
    """
    from kabo.motion.kernels.deviations import distances_of_parts  # noqa: PLC0415 - plans are read without kernels

    rows = (np.ascontiguousarray(each, np.float64) for each in (parts, steps, spans))
    return np.asarray(distances_of_parts(*rows))


def place_on_path(padded: Array, times: Array, waypoints: Array, time: float) -> tuple[int, Array]:
    """The piece of the path that the motion follows at `time`, and the nearest point (n,) of this piece.

    The motion may pass the same place several times, so the pieces are found for the whole motion: in the order of the
    path, with the least sum of distances. Motion against the direction of a piece counts as some distance, too.
    """
    spans = np.diff(times)
    inner = times[:-1, None] + spans[:, None] * np.arange(1, INNER_SAMPLES + 1) / (INNER_SAMPLES + 1)
    instants = np.unique(np.concatenate([times, inner.ravel(), [time]]))
    k = np.clip(np.searchsorted(times, instants, side="right") - 1, 0, len(spans) - 1)
    places = values(padded[k], (instants - times[k])[:, None])
    if len(waypoints) < 2:
        return 0, waypoints[0]
    velocities = values(derivative(padded, 1)[k], (instants - times[k])[:, None])
    costs = _distances(places, waypoints) + BACKWARDS * _backwards(velocities, waypoints)
    now = int(np.searchsorted(instants, time))
    index = int(_in_order(costs)[now])
    here, step = places[now], waypoints[index + 1] - waypoints[index]
    share = float(np.clip((here - waypoints[index]) @ step / max(step @ step, 1e-300), 0.0, 1.0))
    point = waypoints[index] + share * step
    for end in (index, index + 1):
        if np.abs(point - waypoints[end]).max() <= SNAPPED:
            point = waypoints[end]
    return index, point


def _distances(places: Array, waypoints: Array) -> Array:
    """The distances (k, m - 1) of places (k, n) from the pieces of a path (m, n)."""
    steps = np.diff(waypoints, axis=0)
    squares = np.maximum((steps**2).sum(axis=1), 1e-300)
    columns = []
    for start, step, square in zip(waypoints, steps, squares, strict=False):
        shares = np.clip((places - start) @ step / square, 0.0, 1.0)
        columns.append(np.linalg.norm(places - start - shares[:, None] * step, axis=1))
    return np.stack(columns, axis=1)


def _backwards(velocities: Array, waypoints: Array) -> Array:
    """The cosine (k, m - 1) by which velocities (k, n) point against pieces of a path (m, n); 0 if they do not."""
    steps = np.diff(waypoints, axis=0)
    norms = np.linalg.norm(velocities, axis=1)[:, None] * np.linalg.norm(steps, axis=1)
    return np.asarray(np.maximum(0.0, -(velocities @ steps.T) / np.maximum(norms, 1e-300)))


def _in_order(costs: Array) -> Integers:
    """The column of each row (k,), never decreasing from the first to the last column, with the least sum of `costs`."""
    total = np.empty_like(costs)
    total[0] = np.where(np.arange(costs.shape[1]) == 0, costs[0], np.inf)
    for i in range(1, len(costs)):
        total[i] = costs[i] + np.minimum.accumulate(total[i - 1])
    found = np.empty(len(costs), np.int64)
    last = costs.shape[1] - 1
    for i in range(len(costs) - 1, -1, -1):
        last = int(np.argmin(total[i, : last + 1])) if i < len(costs) - 1 else last
        found[i] = last
    return found
