"""Axes that separate the swept hulls of two ranges of parts: the gap along an axis, and the axis of the greatest gap.

A swept hull is that of all parts of a range at several poses; `ends` and `poses` are those of `kernels.witness`.
"""

import numpy as np

from kabo.compilation import farthest, lean_kernel
from kabo.geometry.collision.kernels.bundles import DISC, RADIUS
from kabo.geometry.collision.kernels.separation import bulge
from kabo.geometry.collision.kernels.simplex import nearest

MAX_ITERATIONS = 32
AXIS_SCALE = 32767.0  # of an axis in three short integers
LOW, HIGH, START, END = 0, 1, 2, 3  # columns of `ends`


@lean_kernel  # Hulls, i8, f8 x 3, f8 -> i8
def _key(hulls, part, x, y, z, shift):
    """The key of a part along (x, y, z), in its own frame, as `farthest`; ball and disc count."""
    key = farthest(hulls.blocks, part, hulls.sizes[part], (x, y, z), shift)
    if hulls.rounds[part, RADIUS] > 0.0 or hulls.rounds[part, DISC] > 0.0:
        reach = hulls.rounds[part, RADIUS] + bulge(hulls.rounds, part, x, y, z)[0]
        height = np.int64(key & np.int64(-64)).view(np.float64) + reach
        key = (np.float64(height).view(np.int64) & np.int64(-64)) | (key & np.int64(63))
    return key


@lean_kernel
def gap_along(hulls, ends, poses, x, y, z, search):
    """The gap along an axis of length 1 from the second body to the first; writes the supporting points (2, 3)."""
    points = search.points
    for e in range(2):
        x, y, z = -x, -y, -z  # towards the second body, then back
        best, part, at = np.int64(-1), 0, 0
        for k in range(ends[e, START], ends[e, END] + 1):
            u = poses[e, k, 0] * x + poses[e, k, 3] * y + poses[e, k, 6] * z
            v = poses[e, k, 1] * x + poses[e, k, 4] * y + poses[e, k, 7] * z
            w = poses[e, k, 2] * x + poses[e, k, 5] * y + poses[e, k, 8] * z
            shift = search.offset + (poses[e, k, 9] * x + poses[e, k, 10] * y + poses[e, k, 11] * z)
            for p in range(ends[e, LOW], ends[e, HIGH]):
                key = _key(hulls, p, u, v, w, shift)
                if key > best:
                    best, part, at = key, p, k
        column = best & 63
        a, b, c = hulls.blocks[part, 0, column], hulls.blocks[part, 1, column], hulls.blocks[part, 2, column]
        if hulls.rounds[part, DISC] > 0.0:
            u = poses[e, at, 0] * x + poses[e, at, 3] * y + poses[e, at, 6] * z
            v = poses[e, at, 1] * x + poses[e, at, 4] * y + poses[e, at, 7] * z
            w = poses[e, at, 2] * x + poses[e, at, 5] * y + poses[e, at, 8] * z
            _, du, dv, dw = bulge(hulls.rounds, part, u, v, w)
            a, b, c = a + du, b + dv, c + dw
        for r in range(3):
            points[e, r] = (
                poses[e, at, 3 * r] * a + poses[e, at, 3 * r + 1] * b + poses[e, at, 3 * r + 2] * c
            ) + poses[e, at, 9 + r]
        ball = hulls.rounds[part, RADIUS]
        if ball > 0.0:
            points[e, 0], points[e, 1], points[e, 2] = (
                points[e, 0] + ball * x,
                points[e, 1] + ball * y,
                points[e, 2] + ball * z,
            )
    return (
        x * (points[0, 0] - points[1, 0]) + y * (points[0, 1] - points[1, 1]) + z * (points[0, 2] - points[1, 2])
    )


@lean_kernel
def greatest_gap(hulls, ends, poses, enough, least, loss, search):
    """The greatest gap found, its axis in `axis` [Gilbert 1988].

    Stops at a gap of more than `enough`, where a gap of more than `least` is within `loss` of the distance (a share of
    it), and where none can be more than `least`.
    """
    axis, points, simplex = search.axis, search.points, search.simplex
    x, y, z = axis[0], axis[1], axis[2]
    square, size, greatest = x * x + y * y + z * z, 0, -np.inf
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    for _ in range(MAX_ITERATIONS):
        norm = np.sqrt(square)
        ux, uy, uz = x / norm, y / norm, z / norm
        gap = gap_along(hulls, ends, poses, ux, uy, uz, search)
        if gap > greatest:
            greatest, axis[0], axis[1], axis[2] = gap, ux, uy, uz
            if gap > enough:
                break
        if size > 0 and norm - greatest <= (loss * norm if greatest > least else 1e-9 * norm + 1e-10):
            break
        for r in range(3):
            simplex[size, r] = points[0, r] - points[1, r]
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        if size == 4 or not square > max(1e-20, least * least):
            break
    return greatest
