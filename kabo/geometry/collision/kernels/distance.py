"""Distances of convex parts, as a proven lower bound and an upper bound from two actual points.

The lower bound is the gap along an axis, as in `separation`; the upper one the distance of two points of the
parts. Both are wrong by at most `rounding(offset)`, which is subtracted and added.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import DISC, RADIUS
from kabo.geometry.collision.kernels.separation import apart, greatest_gap, rounding

ROUND_SLACK = 1e-9  # [m] of upper bounds of discs: points on a rim make simplices too small to be exact


@lean_kernel  # Hulls, i8, i8, Search -> f8, f8
def parts_distance(hulls, a, b, search):
    """The lower and upper bound of the distance of two parts [Gilbert 1988]; (0, upper) if not proven apart.

    `search.axis`: at first any direction from which the search starts; afterwards the axis of the lower bound.
    """
    lower, upper = greatest_gap(hulls, a, a, b, b, np.inf, 0.0, search)
    balls, delta = hulls.rounds[a, RADIUS] + hulls.rounds[b, RADIUS], rounding(search.offset)
    if hulls.rounds[a, DISC] + hulls.rounds[b, DISC] > 0.0:
        upper += ROUND_SLACK
    return max(0.0, lower - balls - delta), max(0.0, upper - balls) + delta


@lean_kernel  # (B, 6) f8, i8, i8 -> f8
def _boxes_distance(boxes, a, b):
    square = 0.0
    for r in range(3):
        gap = max(0.0, max(boxes[a, r] - boxes[b, 3 + r], boxes[b, r] - boxes[a, 3 + r]))
        square += gap * gap
    return np.sqrt(square)


@lean_kernel  # (B, 6) f8, i8, i8 -> writes (3,) f8
def between(boxes, a, b, axis):
    """Writes twice the vector from the centre of box b to that of box a, as a first axis."""
    for r in range(3):
        axis[r] = boxes[a, r] + boxes[a, 3 + r] - boxes[b, r] - boxes[b, 3 + r]


@lean_kernel  # Hulls, (B, 6) f8, i8, Search -> f8, f8, i8, i8
def unions_distance(hulls, boxes, first, search):
    """Both bounds of the distance of two bodies: the parts before index `first`, and all others; and the parts nearest."""
    lower, upper, near, other = np.inf, np.inf, 0, first
    for a in range(first):
        for b in range(first, boxes.shape[0]):
            if _boxes_distance(boxes, a, b) > upper:
                continue
            between(boxes, a, b, search.axis)
            low, high = parts_distance(hulls, a, b, search)
            if low < lower:
                near, other = a, b
            lower, upper = min(lower, low), min(upper, high)
    return min(lower, upper), upper, near, other


@lean_kernel  # Hulls, (B, 6) f8, i8, f8, Search -> i8, i8
def unions_near(hulls, boxes, first, margin, search):
    """The first two parts, before and from index `first`, not proven farther apart than `margin` - rounding; or -1, -1."""
    for a in range(first):
        for b in range(first, boxes.shape[0]):
            if _boxes_distance(boxes, a, b) > margin + rounding(search.offset):
                continue
            between(boxes, a, b, search.axis)
            if not apart(hulls, a, a, b, b, margin, search):
                return a, b
    return -1, -1
