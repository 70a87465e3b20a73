"""Distances of convex parts, as a proven lower bound and an upper bound from two actual points.

The lower bound is the gap along an axis, as in `separation`; the upper one the distance of two points of the
parts. Both are wrong by at most `rounding(offset)`, which is subtracted and added.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.separation import MAX_ITERATIONS, _farthest, apart, nearest, rounding

ABSOLUTE_GAP = 1e-12  # [m] between both bounds at which the search ends
RELATIVE_GAP = 1e-12


@lean_kernel  # (B, 3, K) f8, i8, i8, i8, i8, f8, (3,) f8, (4, 3) f8 -> f8, f8
def parts_distance(blocks, a, count_a, b, count_b, offset, axis, simplex):
    """The lower and upper bound of the distance of two parts [Gilbert 1988]; (0, upper) if not proven apart.

    `axis` (3,): initially any direction from which the search starts; afterwards the axis of the lower bound.
    """
    x, y, z = axis[0], axis[1], axis[2]
    square, size = x * x + y * y + z * z, 0
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    lower, upper = -np.inf, np.inf
    for _ in range(2 * MAX_ITERATIONS):
        norm = np.sqrt(square)
        ux, uy, uz = x / norm, y / norm, z / norm
        _, i = _farthest(blocks, a, a, count_a, -ux, -uy, -uz, offset)
        _, j = _farthest(blocks, b, b, count_b, ux, uy, uz, offset)
        wx = blocks[a, 0, i] - blocks[b, 0, j]
        wy = blocks[a, 1, i] - blocks[b, 1, j]
        wz = blocks[a, 2, i] - blocks[b, 2, j]
        gap = ux * wx + uy * wy + uz * wz
        if gap > lower:
            lower = gap
            axis[0], axis[1], axis[2] = ux, uy, uz
        if upper < np.inf and upper - lower <= ABSOLUTE_GAP + RELATIVE_GAP * upper:
            break
        known = False
        for k in range(size):
            known = known or (simplex[k, 0] == wx and simplex[k, 1] == wy and simplex[k, 2] == wz)
        if known:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        upper = min(upper, np.sqrt(square))
        if size == 4 or square < 1e-24:
            upper = 0.0
            break
    delta = rounding(offset)
    return max(0.0, lower - delta), upper + delta


@lean_kernel  # (B, 6) f8, i8, i8 -> f8
def _boxes_distance(boxes, a, b):
    square = 0.0
    for r in range(3):
        gap = max(0.0, max(boxes[a, r] - boxes[b, 3 + r], boxes[b, r] - boxes[a, 3 + r]))
        square += gap * gap
    return np.sqrt(square)


@lean_kernel  # (B, 3, K) f8, (B,) i8, (B, 6) f8, i8, f8, (3,) f8, (4, 3) f8 -> f8, f8
def unions_distance(blocks, sizes, boxes, first, offset, axis, simplex):
    """The lower and upper bound of the distance of two bodies: the parts before index `first`, and all other parts."""
    lower, upper = np.inf, np.inf
    for a in range(first):
        for b in range(first, sizes.shape[0]):
            if _boxes_distance(boxes, a, b) > upper:
                continue
            for r in range(3):
                axis[r] = boxes[a, r] + boxes[a, 3 + r] - boxes[b, r] - boxes[b, 3 + r]
            low, high = parts_distance(blocks, a, sizes[a], b, sizes[b], offset, axis, simplex)
            lower, upper = min(lower, low), min(upper, high)
    return min(lower, upper), upper


@lean_kernel  # (B, 3, K) f8, (B,) i8, (B, 6) f8, i8, f8, f8, (3,) f8, (4, 3) f8, (3,) i8 -> bool
def unions_apart(blocks, sizes, boxes, first, margin, offset, axis, simplex, counters):
    """Whether each part before index `first` is proven farther than `margin` - rounding(offset) from all other parts."""
    for a in range(first):
        for b in range(first, sizes.shape[0]):
            if _boxes_distance(boxes, a, b) > margin + rounding(offset):
                continue
            for r in range(3):
                axis[r] = boxes[a, r] + boxes[a, 3 + r] - boxes[b, r] - boxes[b, 3 + r]
            if not apart(blocks, a, a, sizes[a], b, b, sizes[b], margin, offset, axis, simplex, counters):
                return False
    return True
