"""Separation of convex hulls of vertices: proofs by an axis that two are farther apart than a margin.

"Apart" is returned only if an axis was found along which the gap exceeds the margin, however it was found. The gap
of an axis of length 1 is wrong by at most `rounding(offset)`, which callers add to the margin: the index of the
farthest vertex lies in the low six bits of the shifted product, which costs offset * 2^-46 for each body;
products, sums and the axis' length cost a few 2^-53. Comparisons are such that NaN and "undecided" mean "not
apart".

A body is one vertex block, or two: the convex hull of one part at both ends of an interval, never built. Blocks are
(3, K) rows of a pool; unused columns repeat the first vertex, so that loops run over multiples of eight.
"""

import numpy as np

from kabo.compilation import leaf_kernel, lean_kernel, reduction_kernel

MAX_ITERATIONS = 48  # real scenes need 13 at most; "not apart" if still undecided


@leaf_kernel  # f8 -> f8
def rounding(offset):
    """A bound of all rounding errors of one gap, with a safety factor of two; `offset` as passed to `support`."""
    return offset * 2.0**-44


@reduction_kernel  # (B, 3, K) f8, i8, i8, f8, f8, f8, f8 -> i8
def support(blocks, block, count, x, y, z, offset):
    """The key of the vertex farthest along (x, y, z): its index in the low six bits; greater keys are farther.

    `offset` is a power of two of at least twice every |vertex|, so that products plus offset are positive and
    their bits order as integers: one vectorised maximum. (x, y, z) has length 1. Of equal vertices the one with
    the higher index is taken.
    """
    best = np.int64(0)
    for i in range(count):
        product = blocks[block, 0, i] * x + blocks[block, 1, i] * y + (blocks[block, 2, i] * z + offset)
        best = max(best, (np.float64(product).view(np.int64) & np.int64(-64)) | np.int64(i))
    return best


@lean_kernel
def _farthest(blocks, first, second, count, x, y, z, offset):
    """The block and the column of the farthest vertex of two blocks."""
    best, block = support(blocks, first, count, x, y, z, offset), first
    if second != first:
        other = support(blocks, second, count, x, y, z, offset)
        if other > best:
            best, block = other, second
    return block, best & 63


@lean_kernel
def _nearest_on_triangle(simplex, i, j, k):
    """The point of triangle i, j, k nearest to the origin: the number of its supporting corners, these first, the point."""
    ax, ay, az = simplex[i, 0], simplex[i, 1], simplex[i, 2]
    bx, by, bz = simplex[j, 0], simplex[j, 1], simplex[j, 2]
    cx, cy, cz = simplex[k, 0], simplex[k, 1], simplex[k, 2]
    abx, aby, abz = bx - ax, by - ay, bz - az
    acx, acy, acz = cx - ax, cy - ay, cz - az
    d1, d2 = -(abx * ax + aby * ay + abz * az), -(acx * ax + acy * ay + acz * az)
    if d1 <= 0.0 and d2 <= 0.0:
        return 1, i, j, k, ax, ay, az
    d3, d4 = -(abx * bx + aby * by + abz * bz), -(acx * bx + acy * by + acz * bz)
    if d3 >= 0.0 and d4 <= d3:
        return 1, j, i, k, bx, by, bz
    if d1 * d4 - d3 * d2 <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3) if d1 != d3 else 0.0
        return 2, i, j, k, ax + t * abx, ay + t * aby, az + t * abz
    d5, d6 = -(abx * cx + aby * cy + abz * cz), -(acx * cx + acy * cy + acz * cz)
    if d6 >= 0.0 and d5 <= d6:
        return 1, k, i, j, cx, cy, cz
    if d5 * d2 - d1 * d6 <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6) if d2 != d6 else 0.0
        return 2, i, k, j, ax + t * acx, ay + t * acy, az + t * acz
    if d3 * d6 - d5 * d4 <= 0.0 and (d4 - d3) >= 0.0 and (d5 - d6) >= 0.0:
        whole = (d4 - d3) + (d5 - d6)
        t = (d4 - d3) / whole if whole != 0.0 else 0.0
        return 2, j, k, i, bx + t * (cx - bx), by + t * (cy - by), bz + t * (cz - bz)
    nx, ny, nz = aby * acz - abz * acy, abz * acx - abx * acz, abx * acy - aby * acx
    square = nx * nx + ny * ny + nz * nz
    if square <= 0.0:
        return 1, i, j, k, ax, ay, az
    h = (ax * nx + ay * ny + az * nz) / square
    return 3, i, j, k, h * nx, h * ny, h * nz


@lean_kernel
def _outside(simplex, i, j, k, other):
    """Whether the origin and the other corner lie on different sides of face i, j, k, or the tetrahedron is flat."""
    ax, ay, az = simplex[i, 0], simplex[i, 1], simplex[i, 2]
    abx, aby, abz = simplex[j, 0] - ax, simplex[j, 1] - ay, simplex[j, 2] - az
    acx, acy, acz = simplex[k, 0] - ax, simplex[k, 1] - ay, simplex[k, 2] - az
    nx, ny, nz = aby * acz - abz * acy, abz * acx - abx * acz, abx * acy - aby * acx
    origin = -(ax * nx + ay * ny + az * nz)
    height = (simplex[other, 0] - ax) * nx + (simplex[other, 1] - ay) * ny + (simplex[other, 2] - az) * nz
    return origin * height < 0.0 or height * height <= 1e-24 * (nx * nx + ny * ny + nz * nz)


@lean_kernel
def _nearest_on_segment(simplex):
    """As `nearest`, for two corners."""
    ax, ay, az = simplex[1, 0], simplex[1, 1], simplex[1, 2]
    ex, ey, ez = simplex[0, 0] - ax, simplex[0, 1] - ay, simplex[0, 2] - az
    t, square = -(ax * ex + ay * ey + az * ez), ex * ex + ey * ey + ez * ez
    if t <= 0.0:
        simplex[0, 0], simplex[0, 1], simplex[0, 2] = ax, ay, az
        return 1, ax, ay, az
    if t >= square:
        return 1, simplex[0, 0], simplex[0, 1], simplex[0, 2]
    t /= square
    return 2, ax + t * ex, ay + t * ey, az + t * ez


@lean_kernel
def nearest(simplex, size):
    """The point of the simplex nearest to the origin, and the number of supporting corners, which move to the front.

    Four supporting corners mean that the origin is inside. Degenerate simplices may cost a round or a needless
    "not apart", never a wrong "apart".
    """
    if size == 1:
        return 1, simplex[0, 0], simplex[0, 1], simplex[0, 2]
    if size == 2:
        return _nearest_on_segment(simplex)
    if size == 3:
        found, i, j, k, x, y, z = _nearest_on_triangle(simplex, 2, 1, 0)
    else:
        least, found, i, j, k, x, y, z = np.inf, 4, 0, 1, 2, 0.0, 0.0, 0.0
        for face in range(4):  # the corner that is left out
            a, b, c = (2 if face == 3 else 3), (1 if face >= 2 else 2), (1 if face == 0 else 0)
            if _outside(simplex, a, b, c, face):
                f, fi, fj, fk, fx, fy, fz = _nearest_on_triangle(simplex, a, b, c)
                square = fx * fx + fy * fy + fz * fz
                if square < least:
                    least, found, i, j, k, x, y, z = square, f, fi, fj, fk, fx, fy, fz
        if found == 4:
            return 4, 0.0, 0.0, 0.0
    a0, a1, a2 = simplex[i, 0], simplex[i, 1], simplex[i, 2]
    b0, b1, b2 = simplex[j, 0], simplex[j, 1], simplex[j, 2]
    c0, c1, c2 = simplex[k, 0], simplex[k, 1], simplex[k, 2]
    simplex[0, 0], simplex[0, 1], simplex[0, 2] = a0, a1, a2
    simplex[1, 0], simplex[1, 1], simplex[1, 2] = b0, b1, b2
    simplex[2, 0], simplex[2, 1], simplex[2, 2] = c0, c1, c2
    return found, x, y, z


@lean_kernel
def apart(blocks, a0, a1, count_a, b0, b1, count_b, margin, offset, axis, simplex, counters):
    """Whether hull(a0, a1) and hull(b0, b1) are proven farther apart than `margin` - rounding(offset) [Gilbert 1988].

    `axis` (3,): initially any direction from which the search starts; afterwards the separating axis, or the last
    axis tried. False means a distance of at most margin * (1 + 1e-9) + 1e-10 + rounding, or undecided.
    `counters` counts pairs, iterations and undecided pairs.
    """
    x, y, z = axis[0], axis[1], axis[2]
    square, size = x * x + y * y + z * z, 0
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    counters[0] += 1
    for iteration in range(MAX_ITERATIONS):
        counters[1] += 1
        norm = np.sqrt(square)
        scale = 1.0 / norm
        ux, uy, uz = x * scale, y * scale, z * scale
        a, i = _farthest(blocks, a0, a1, count_a, -ux, -uy, -uz, offset)
        b, j = _farthest(blocks, b0, b1, count_b, ux, uy, uz, offset)
        wx = blocks[a, 0, i] - blocks[b, 0, j]
        wy = blocks[a, 1, i] - blocks[b, 1, j]
        wz = blocks[a, 2, i] - blocks[b, 2, j]
        gap = ux * wx + uy * wy + uz * wz
        if gap > margin:
            axis[0], axis[1], axis[2] = ux, uy, uz
            return True
        if size > 0 and norm - gap <= 1e-9 * norm + 1e-10:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        if size == 4 or not square > margin * margin or square < 1e-20:
            break
        if iteration == MAX_ITERATIONS - 1:
            counters[2] += 1
    axis[0], axis[1], axis[2] = x, y, z
    return False


@lean_kernel
def posed_apart(blocks, a, count_a, b, count_b, pose, margin, offset, axis, simplex, counters):
    """The result of `apart` for block `a` and block `b` moved by `pose` (12,), computed in the frame of `a`.

    Blocks stay in their own frames and only farthest vertices are transformed, since few rounds decide most pairs.
    Of `rounding`, indices take half, and moving and multiplying numbers of at most 2 * offset a twentieth.
    """
    x, y, z = axis[0], axis[1], axis[2]
    square, size = x * x + y * y + z * z, 0
    if not 1e-20 < square < 1e20:
        x, y, z, square = 1.0, 0.0, 0.0, 1.0
    counters[0] += 1
    for iteration in range(MAX_ITERATIONS):
        counters[1] += 1
        norm = np.sqrt(square)
        scale = 1.0 / norm
        ux, uy, uz = x * scale, y * scale, z * scale
        vx = pose[0] * ux + pose[3] * uy + pose[6] * uz
        vy = pose[1] * ux + pose[4] * uy + pose[7] * uz
        vz = pose[2] * ux + pose[5] * uy + pose[8] * uz
        i = support(blocks, a, count_a, -ux, -uy, -uz, offset) & 63
        j = support(blocks, b, count_b, vx, vy, vz, offset) & 63
        px, py, pz = blocks[b, 0, j], blocks[b, 1, j], blocks[b, 2, j]
        wx = blocks[a, 0, i] - (pose[0] * px + pose[1] * py + pose[2] * pz + pose[9])
        wy = blocks[a, 1, i] - (pose[3] * px + pose[4] * py + pose[5] * pz + pose[10])
        wz = blocks[a, 2, i] - (pose[6] * px + pose[7] * py + pose[8] * pz + pose[11])
        gap = ux * wx + uy * wy + uz * wz
        if gap > margin:
            axis[0], axis[1], axis[2] = ux, uy, uz
            return True
        if size > 0 and norm - gap <= 1e-9 * norm + 1e-10:
            break
        simplex[size, 0], simplex[size, 1], simplex[size, 2] = wx, wy, wz
        size, x, y, z = nearest(simplex, size + 1)
        square = x * x + y * y + z * z
        if size == 4 or not square > margin * margin or square < 1e-20:
            break
        if iteration == MAX_ITERATIONS - 1:
            counters[2] += 1
    axis[0], axis[1], axis[2] = x, y, z
    return False
