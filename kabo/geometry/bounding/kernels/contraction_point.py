"""The cheapest point outside some planes: a quadratic minimum under linear inequalities in space [K 4.3.4].

At most three planes are active at the optimum [K Eq. 4.12-4.18]. Instead of trying all subsets, the most violated
plane enters in each round, and at most seven subsets of the active planes that contain it are solved directly: the
work is linear in the number of planes [Sharir and Welzl 1992]. In coordinates in which the quadric is a sphere,
the problem is the projection of a point.
"""

import numpy as np

from kabo.compilation import lean_kernel

MAX_ROUNDS = 60
FEASIBILITY_SHARE = 0.1  # of the planes' slack, by which a point may miss it


@lean_kernel  # (10,) f8, f8, (6,) f8 -> bool
def factor(q, regular, lower):
    """Writes the Cholesky factor l00, l10, l20, l11, l21, l22 of the quadric's matrix, regularised by its trace."""
    r = regular * (q[0] + q[3] + q[5]) + 1e-300
    lower[0] = np.sqrt(q[0] + r)
    lower[1], lower[2] = q[1] / lower[0], q[2] / lower[0]
    lower[3] = np.sqrt(max(q[3] + r - lower[1] * lower[1], 1e-3 * r))
    lower[4] = (q[4] - lower[1] * lower[2]) / lower[3]
    lower[5] = np.sqrt(max(q[5] + r - lower[2] * lower[2] - lower[4] * lower[4], 1e-3 * r))


@lean_kernel  # (N, 5) f8, i8 x 4, f8 x 3 -> bool, f8 x 3
def _held(g, count, i, j, k, x, y, z):
    """The point nearest to x, y, z on the first `count` of planes i, j, k; fails if they are parallel or not all active."""
    si = g[i, 3] - (g[i, 0] * x + g[i, 1] * y + g[i, 2] * z)
    if count == 1:
        return si >= 0.0, x + si * g[i, 0], y + si * g[i, 1], z + si * g[i, 2]
    if count == 2:
        sj = g[j, 3] - (g[j, 0] * x + g[j, 1] * y + g[j, 2] * z)
        cosine = g[i, 0] * g[j, 0] + g[i, 1] * g[j, 1] + g[i, 2] * g[j, 2]
        det = 1.0 - cosine * cosine
        if det <= 1e-12:
            return False, x, y, z
        s, t = (si - cosine * sj) / det, (sj - cosine * si) / det
        good = s >= -1e-9 * abs(t) and t >= -1e-9 * abs(s)
        return good, x + s * g[i, 0] + t * g[j, 0], y + s * g[i, 1] + t * g[j, 1], z + s * g[i, 2] + t * g[j, 2]
    jkx = g[j, 1] * g[k, 2] - g[j, 2] * g[k, 1]
    jky = g[j, 2] * g[k, 0] - g[j, 0] * g[k, 2]
    jkz = g[j, 0] * g[k, 1] - g[j, 1] * g[k, 0]
    det = g[i, 0] * jkx + g[i, 1] * jky + g[i, 2] * jkz
    if abs(det) <= 1e-9:
        return False, x, y, z
    kix = g[k, 1] * g[i, 2] - g[k, 2] * g[i, 1]
    kiy = g[k, 2] * g[i, 0] - g[k, 0] * g[i, 2]
    kiz = g[k, 0] * g[i, 1] - g[k, 1] * g[i, 0]
    ijx = g[i, 1] * g[j, 2] - g[i, 2] * g[j, 1]
    ijy = g[i, 2] * g[j, 0] - g[i, 0] * g[j, 2]
    ijz = g[i, 0] * g[j, 1] - g[i, 1] * g[j, 0]
    a, b, c = g[i, 3] / det, g[j, 3] / det, g[k, 3] / det
    return True, a * jkx + b * kix + c * ijx, a * jky + b * kiy + c * ijy, a * jkz + b * kiz + c * ijz


@lean_kernel  # (N, 4) f8, f8 x 4 -> f8
def _height(g, i, x, y, z):
    return g[i, 0] * x + g[i, 1] * y + g[i, 2] * z - g[i, 3]


@lean_kernel
def _best_subset(g, entering, holding, held, tolerance, x0, y0, z0):
    """The point nearest to the start with `entering` and at most two other planes active, and outside all active planes."""
    best, bx, by, bz, count, p, q = np.inf, 0.0, 0.0, 0.0, 0, -1, -1
    for i in range(-1, held):
        for j in range(i, held if i >= 0 else 0):  # nothing, one (j = i), or two holding planes join
            first, second = holding[max(i, 0)], holding[max(j, 0)]
            many = 1 if i < 0 else 2 if j == i else 3
            good, x, y, z = _held(g, many, entering, first, second, x0, y0, z0)
            if good:
                for k in range(held):
                    if _height(g, holding[k], x, y, z) < -tolerance:
                        good = False
                        break
            squared = (x - x0) ** 2 + (y - y0) ** 2 + (z - z0) ** 2
            if good and squared < best:
                best, bx, by, bz, count, p, q = squared, x, y, z, many, first, second
    return best, bx, by, bz, count, p, q


@lean_kernel  # (N, 5) f8, i8, f8, f8 x 3, (4,) i8 -> bool, f8 x 3
def project(g, count, tolerance, x0, y0, z0, holding):
    """The point nearest to x0, y0, z0 with n·x >= d for all planes, with a flag whether such a point was found.

    Planes are unit normals, d, and metres per unit of height; the point may miss a plane by `tolerance` [m].
    """
    x, y, z, held = x0, y0, z0, 0
    for _ in range(MAX_ROUNDS):
        entering, worst = -1, -tolerance
        for i in range(count):
            height = _height(g, i, x, y, z)
            if height < worst:
                entering, worst = i, height
        if entering < 0:
            return True, x, y, z
        for k in range(held):
            if holding[k] == entering:
                return worst > -4.0 * tolerance, x, y, z
        best, x, y, z, held_now, p, q = _best_subset(g, entering, holding, held, 4.0 * tolerance, x0, y0, z0)
        if best == np.inf:
            return False, x, y, z
        holding[0], holding[1], holding[2] = entering, p, q
        held = held_now
    return False, x, y, z


@lean_kernel
def cheapest_outside(q, planes, count, regular, slack, lower, turned, holding):
    """The cheapest point at least `slack` outside all planes (count, 4), n·x >= d, with a flag whether it exists.

    The quadric and the planes are relative to a point near the answer, towards which the cost is regularised.
    Scratch: lower (6,), turned (N, 5) f8, holding (4,) i8.
    """
    factor(q, regular, lower)
    l00, l10, l20, l11, l21, l22 = lower[0], lower[1], lower[2], lower[3], lower[4], lower[5]
    x0 = -q[6] / l00
    y0 = (-q[7] - l10 * x0) / l11
    z0 = (-q[8] - l20 * x0 - l21 * y0) / l22
    for i in range(count):
        u = planes[i, 0] / l00
        v = (planes[i, 1] - l10 * u) / l11
        w = (planes[i, 2] - l20 * u - l21 * v) / l22
        length = 1.0 / np.sqrt(u * u + v * v + w * w)
        turned[i, 0], turned[i, 1], turned[i, 2] = u * length, v * length, w * length
        turned[i, 3], turned[i, 4] = (planes[i, 3] + slack) * length, 1.0 / length
    good, x, y, z = project(turned, count, FEASIBILITY_SHARE * slack, x0, y0, z0, holding)
    z = z / l22
    y = (y - l21 * z) / l11
    x = (x - l10 * y - l20 * z) / l00
    return good and np.isfinite(x + y + z), x, y, z
