"""Separation of convex parts: proofs by an axis that two are farther apart than a margin.

A part is the sum of the hull of its corners, a ball of radius r and a flat disc of radius s across an axis n. Along
u of length 1 two parts leave the gap

    min u·a - max u·b - (r_a + r_b) - s_a |u x n_a| - s_b |u x n_b|

of which the balls are part of the margin in every search, and discs cost nothing where there are none. "Apart" is
returned only if an axis was found along which the gap exceeds the margin, however it was found. The gap is wrong by
at most `rounding(offset)`, which callers add to the margin: the index of the farthest vertex lies in the low six bits
of the shifted product, which costs offset * 2^-46 for each body; products, sums and the axis' length cost a few
2^-53, and so does |u x n| (which sqrt(1 - (u·n)^2) would not). Comparisons are such that NaN and "undecided" mean
"not apart".

A body is one row of `Hulls`, or two: the convex hull of one part at both ends of an interval, never built. Unused
columns of blocks repeat the first vertex, so that loops run over multiples of eight.
"""

import numpy as np

from kabo.compilation import farthest, inner, joined_kernel, leaf_kernel, lean_kernel
from kabo.geometry.collision.kernels.bundles import AXIS, DISC, ITERATIONS, RADIUS, SEARCHES, UNDECIDED
from kabo.geometry.collision.kernels.simplex import nearest

MAX_ITERATIONS = 48  # real scenes need 13 at most; "not apart" if still undecided
MAX_ROUND_ITERATIONS = 200  # of a search with discs, which comes nearer in every round without an end


@leaf_kernel  # f8 -> f8
def rounding(offset):
    """A bound of all rounding errors of one gap, with a safety factor of two; `offset` as passed to `farthest`."""
    return offset * 2.0**-44


@lean_kernel
def _farther(hulls, first, second, x, y, z, offset):
    """The row and the column of the farthest vertex of two rows."""
    best, row = farthest(hulls.blocks, first, hulls.sizes[first], (x, y, z), offset), first
    if second != first:
        other = farthest(hulls.blocks, second, hulls.sizes[second], (x, y, z), offset)
        if other > best:
            best, row = other, second
    return row, best & 63


@lean_kernel  # (B, 5) f8, i8, f8 x 3 -> f8 x 4
def bulge(rounds, row, x, y, z):
    """How far a part's disc reaches beyond its corners along (x, y, z), and the point of the disc that does so."""
    a, b, c, disc = rounds[row, AXIS], rounds[row, AXIS + 1], rounds[row, AXIS + 2], rounds[row, DISC]
    u, v, w = y * c - z * b, z * a - x * c, x * b - y * a
    across = np.sqrt(u * u + v * v + w * w)
    if not across > 0.0:
        return 0.0, 0.0, 0.0, 0.0
    k = disc / across
    return disc * across, k * (b * w - c * v), k * (c * u - a * w), k * (a * v - b * u)


@lean_kernel  # -> f8; writes two rows of (4, 3) f8
def _farthest_round(hulls, first, second, x, y, z, offset, points, e):
    """Writes the farthest point of one or two rows, without and with its disc; returns how far the disc reaches."""
    greatest, own = -np.inf, 0.0
    for end in range(1 if second == first else 2):
        row = second if end else first
        i = farthest(hulls.blocks, row, hulls.sizes[row], (x, y, z), offset) & 63
        px, py, pz = hulls.blocks[row, 0, i], hulls.blocks[row, 1, i], hulls.blocks[row, 2, i]
        reach, dx, dy, dz = bulge(hulls.rounds, row, x, y, z)
        height = px * x + py * y + pz * z + reach
        if not height <= greatest:
            greatest, own = height, reach
            points[e, 0], points[e, 1], points[e, 2] = px, py, pz
            points[2 + e, 0], points[2 + e, 1], points[2 + e, 2] = px + dx, py + dy, pz + dz
    return own


@lean_kernel
def greatest_gap(hulls, a0, a1, b0, b1, enough, least, search):
    """The greatest gap found, without the balls, and the least distance of two points, of parts of any kind.

    The search stops at a gap of more than `enough`, and where no gap can be more than `least`. `search.axis`: at
    first any direction from which the search starts; afterwards the axis of the gap.
    """
    axis, simplex, points, counters = search.axis, search.simplex, search.points, search.counters
    x, y, z = axis[0], axis[1], axis[2]
    square, size, greatest, nearest_points = x * x + y * y + z * z, 0, -np.inf, np.inf
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    counters[SEARCHES] += 1
    ended = 1e-10 if enough < np.inf else 1e-12  # [m] between both bounds
    for iteration in range(MAX_ROUND_ITERATIONS):
        counters[ITERATIONS] += 1
        norm = np.sqrt(square)
        ux, uy, uz = x / norm, y / norm, z / norm
        reach = _farthest_round(hulls, a0, a1, -ux, -uy, -uz, search.offset, points, 0)
        reach += _farthest_round(hulls, b0, b1, ux, uy, uz, search.offset, points, 1)
        gap = (
            ux * (points[0, 0] - points[1, 0])
            + uy * (points[0, 1] - points[1, 1])
            + uz * (points[0, 2] - points[1, 2])
        ) - reach
        if gap > greatest:
            greatest = gap
            axis[0], axis[1], axis[2] = ux, uy, uz
            if gap > enough:
                break
        if nearest_points < np.inf and nearest_points - greatest <= ended * (1.0 + nearest_points):
            break
        wx, wy, wz = points[2, 0] - points[3, 0], points[2, 1] - points[3, 1], points[2, 2] - points[3, 2]
        known = False
        for k in range(size):
            known = known or (simplex[k, 0] == wx and simplex[k, 1] == wy and simplex[k, 2] == wz)
        if known:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        nearest_points = min(nearest_points, np.sqrt(square))
        if size == 4 or not square > max(1e-24, least * least):
            if size == 4 or square < 1e-24:
                nearest_points = 0.0
            break
        if iteration == MAX_ROUND_ITERATIONS - 1:
            counters[UNDECIDED] += 1
    return greatest, nearest_points


@lean_kernel
def apart(hulls, a0, a1, b0, b1, margin, search):
    """Whether hull(a0, a1) and hull(b0, b1) are proven farther apart than `margin` - rounding(offset) [Gilbert 1988].

    `search.axis`: at first any direction from which the search starts; afterwards the separating axis, or the last
    axis tried. False means a distance of at most margin * (1 + 1e-9) + 1e-10 + rounding, or undecided.
    """
    balls = hulls.rounds[a0, RADIUS] + hulls.rounds[b0, RADIUS]
    margin += balls
    if hulls.rounds[a0, DISC] + hulls.rounds[b0, DISC] > 0.0:
        return greatest_gap(hulls, a0, a1, b0, b1, margin, margin, search)[0] > margin
    axis, simplex, counters, offset, blocks = (
        search.axis, search.simplex, search.counters, search.offset, hulls.blocks
    )  # fmt: skip
    x, y, z = axis[0], axis[1], axis[2]
    square, size = x * x + y * y + z * z, 0
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    counters[SEARCHES] += 1
    for iteration in range(MAX_ITERATIONS):
        counters[ITERATIONS] += 1
        norm = np.sqrt(square)
        scale = 1.0 / norm
        ux, uy, uz = x * scale, y * scale, z * scale
        a, i = _farther(hulls, a0, a1, -ux, -uy, -uz, offset)
        b, j = _farther(hulls, b0, b1, ux, uy, uz, offset)
        wx = blocks[a, 0, i] - blocks[b, 0, j]
        wy = blocks[a, 1, i] - blocks[b, 1, j]
        wz = blocks[a, 2, i] - blocks[b, 2, j]
        gap = ux * wx + uy * wy + uz * wz
        if gap > margin:
            axis[0], axis[1], axis[2] = ux, uy, uz
            return True
        if size > 0 and norm - gap <= 1e-9 * (norm - balls) + 1e-10:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        if size == 4 or not square > margin * margin or square < 1e-20:
            break
        if iteration == MAX_ITERATIONS - 1:
            counters[UNDECIDED] += 1
    axis[0], axis[1], axis[2] = x, y, z
    return False


@joined_kernel
def posed_apart(hulls, a, b, pose, margin, balls, known, search):
    """The result of `apart` for row `a` and row `b` moved by `pose` (12,), computed in the frame of `a`.

    Corners stay in their own frames and only farthest ones are transformed, since few rounds decide most pairs.
    Of `rounding`, indices take half, and moving and multiplying numbers of at most 2 * offset a twentieth. Neither
    row has a disc; `balls` is the sum of their balls' radii. So many points of the difference of both hulls are
    `known` beforehand (0 or 1), in the simplex.
    """
    axis, simplex, counters, offset, blocks = (
        search.axis, search.simplex, search.counters, search.offset, hulls.blocks
    )  # fmt: skip
    count_a, count_b = hulls.sizes[a], hulls.sizes[b]
    margin += balls
    x, y, z = axis[0], axis[1], axis[2]
    square, size = x * x + y * y + z * z, known
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    counters[SEARCHES] += 1
    for iteration in range(MAX_ITERATIONS):
        counters[ITERATIONS] += 1
        norm = np.sqrt(square)
        scale = 1.0 / norm
        ux, uy, uz = x * scale, y * scale, z * scale
        u = ux, uy, uz
        vx = inner((pose[0], pose[3], pose[6]), u)
        vy = inner((pose[1], pose[4], pose[7]), u)
        vz = inner((pose[2], pose[5], pose[8]), u)
        i = farthest(blocks, a, count_a, (-ux, -uy, -uz), offset) & 63
        j = farthest(blocks, b, count_b, (vx, vy, vz), offset) & 63
        p = blocks[b, 0, j], blocks[b, 1, j], blocks[b, 2, j]
        wx = blocks[a, 0, i] - (inner((pose[0], pose[1], pose[2]), p) + pose[9])
        wy = blocks[a, 1, i] - (inner((pose[3], pose[4], pose[5]), p) + pose[10])
        wz = blocks[a, 2, i] - (inner((pose[6], pose[7], pose[8]), p) + pose[11])
        gap = inner(u, (wx, wy, wz))
        if gap > margin:
            axis[0], axis[1], axis[2] = ux, uy, uz
            return True
        if iteration > 0 and norm - gap <= 1e-9 * (norm - balls) + 1e-10:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        if size == 4 or not square > margin * margin or square < 1e-20:
            break
        if iteration == MAX_ITERATIONS - 1:
            counters[UNDECIDED] += 1
    axis[0], axis[1], axis[2] = x, y, z
    return False
