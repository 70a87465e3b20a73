"""The point of a simplex nearest to the origin, for searches of separating axes [Gilbert 1988]."""

import numpy as np

from kabo.compilation import lean_kernel


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
