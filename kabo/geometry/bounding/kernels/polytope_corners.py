"""The point to which an edge of a convex polytope may be contracted so that the new hull contains the old one."""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle


@lean_kernel  # (R, 4) f8, i8 (rows of `held`), (3,) f8, (3,) f8 -> bool
def _meets(rows, i, j, k, y):
    """Writes the point of least norm with g.y = h for one, two or three rows (-1: none); False if they are parallel."""
    ax, ay, az, ah = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3]
    aa = ax * ax + ay * ay + az * az
    if j < 0:
        y[0], y[1], y[2] = ax * ah / aa, ay * ah / aa, az * ah / aa
        return True
    bx, by, bz, bh = rows[j, 0], rows[j, 1], rows[j, 2], rows[j, 3]
    ux, uy, uz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    uu, bb = ux * ux + uy * uy + uz * uz, bx * bx + by * by + bz * bz
    if uu <= 1e-12 * aa * bb:
        return False
    if k < 0:
        # The point on the line of both planes that is nearest to the origin.
        y[0] = (ah * (by * uz - bz * uy) + bh * (uy * az - uz * ay)) / uu
        y[1] = (ah * (bz * ux - bx * uz) + bh * (uz * ax - ux * az)) / uu
        y[2] = (ah * (bx * uy - by * ux) + bh * (ux * ay - uy * ax)) / uu
        return True
    cx, cy, cz, ch = rows[k, 0], rows[k, 1], rows[k, 2], rows[k, 3]
    det = ux * cx + uy * cy + uz * cz
    if det * det <= 1e-16 * uu * (cx * cx + cy * cy + cz * cz):
        return False
    y[0] = (ah * (by * cz - bz * cy) + bh * (cy * az - cz * ay) + ch * ux) / det
    y[1] = (ah * (bz * cx - bx * cz) + bh * (cz * ax - cx * az) + ch * uy) / det
    y[2] = (ah * (bx * cy - by * cx) + bh * (cx * ay - cy * ax) + ch * uz) / det
    return True


@lean_kernel  # (R, 4) f8, i8, (3,) f8, (3,) f8, (4,) i8 -> bool
def least_beyond(rows, count, y, trial, held):
    """Writes the point of least norm with g.y >= h for all rows (g, h); False if there is none.

    In each round the most violated row is added to the at most three active rows, and the best subset stays
    active.
    """
    y[0], y[1], y[2] = 0.0, 0.0, 0.0
    many = 0
    for _ in range(60):
        worst, row = -1e-12, -1
        for r in range(count):
            value = rows[r, 0] * y[0] + rows[r, 1] * y[1] + rows[r, 2] * y[2] - rows[r, 3]
            if value < worst:
                worst, row = value, r
        if row < 0:
            return True
        best, keep_j, keep_k = np.inf, -2, -2
        for jj in range(-1, many):
            for kk in range(-1, many):
                if kk >= 0 and kk <= jj or jj < 0 and kk >= 0:
                    continue
                j = held[jj] if jj >= 0 else -1
                k = held[kk] if kk >= 0 else -1
                if j == row or k == row or not _meets(rows, row, j, k, trial):
                    continue
                fits = True
                for m in range(many):
                    r = held[m]
                    value = rows[r, 0] * trial[0] + rows[r, 1] * trial[1] + rows[r, 2] * trial[2] - rows[r, 3]
                    fits = fits and value >= -1e-12
                norm = trial[0] ** 2 + trial[1] ** 2 + trial[2] ** 2
                if fits and norm < best:
                    best, keep_j, keep_k = norm, j, k
                    y[0], y[1], y[2] = trial[0], trial[1], trial[2]
        if keep_j == -2:
            return False
        held[0], many = row, 1
        if keep_j >= 0:
            held[many] = keep_j
            many += 1
        if keep_k >= 0:
            held[many] = keep_k
            many += 1
    return False


@lean_kernel
def least_beyond_planes(scratch, count, x, y, z, size):
    """Writes to `scratch.found` the point beyond all planes (n.p >= d) with the least weighted squared distance from them.

    The planes and weights are the first `count` of `scratch`; (x, y, z) is the start, `size` a length [m] for
    scaling. False if there is no such point.
    """
    planes, weights, rows, found = scratch.planes, scratch.weights, scratch.rows, scratch.found
    a00, a01, a02, a11, a12, a22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    for r in range(count):
        n0, n1, n2, w = planes[r, 0], planes[r, 1], planes[r, 2], weights[r]
        h = (planes[r, 3] - n0 * x - n1 * y - n2 * z) / size
        a00, a01, a02 = a00 + w * n0 * n0, a01 + w * n0 * n1, a02 + w * n0 * n2
        a11, a12, a22 = a11 + w * n1 * n1, a12 + w * n1 * n2, a22 + w * n2 * n2
        b0, b1, b2 = b0 + w * n0 * h, b1 + w * n1 * h, b2 + w * n2 * h
    more = 1e-4 * (a00 + a11 + a22)
    if more <= 0.0:
        return False
    # A = L L^T; in y = L^T p - L^-1 b the squares are |y|^2.
    l00 = np.sqrt(a00 + more)
    l10, l20 = a01 / l00, a02 / l00
    l11 = np.sqrt(a11 + more - l10 * l10)
    l21 = (a12 - l20 * l10) / l11
    l22 = np.sqrt(a22 + more - l20 * l20 - l21 * l21)
    c0 = b0 / l00
    c1 = (b1 - l10 * c0) / l11
    c2 = (b2 - l20 * c0 - l21 * c1) / l22
    for r in range(count):
        n0, n1, n2 = planes[r, 0], planes[r, 1], planes[r, 2]
        g0 = n0 / l00
        g1 = (n1 - l10 * g0) / l11
        g2 = (n2 - l20 * g0 - l21 * g1) / l22
        h = (planes[r, 3] - n0 * x - n1 * y - n2 * z) / size - (g0 * c0 + g1 * c1 + g2 * c2)
        scale = 1.0 / np.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
        rows[r, 0], rows[r, 1], rows[r, 2], rows[r, 3] = g0 * scale, g1 * scale, g2 * scale, h * scale
    if not least_beyond(rows, count, found, scratch.trial, scratch.held):
        return False
    y0, y1, y2 = found[0] + c0, found[1] + c1, found[2] + c2
    p2 = y2 / l22
    p1 = (y1 - l21 * p2) / l11
    p0 = (y0 - l10 * p1 - l20 * p2) / l00
    found[0], found[1], found[2] = x + size * p0, y + size * p1, z + size * p2
    return True


@lean_kernel
def outside_distance(solid, x, y, z, limit):
    """The distance of a point from the solid; 0 inside, inf if it is `limit` or more."""
    boxes, children, triangles, stack = solid.boxes, solid.children, solid.triangles, solid.stack
    squared, near = nearest_triangle(boxes, children, triangles, x, y, z, limit * limit, stack)
    if inside(boxes, children, triangles, x, y, z, stack):
        return 0.0
    return np.sqrt(squared) if near >= 0 else np.inf


@lean_kernel  # i8, i8, HullArrays, ContractionScratch -> i8
def planes_at(a, b, hull, scratch):
    """Writes the planes and areas of all faces at an edge's corners a and b, each once; returns their number."""
    simplices, starts, count = hull.simplices, hull.starts, 0
    for side in range(2):
        v = b if side else a
        for s in range(starts[v], starts[v + 1]):
            f = hull.around[s]
            if side == 1 and (simplices[f, 0] == a or simplices[f, 1] == a or simplices[f, 2] == a):
                continue
            for c in range(4):
                scratch.planes[count, c] = hull.equations[f, c]
            scratch.weights[count] = hull.areas[f]
            count += 1
    return count


@lean_kernel  # HullArrays, f8 [m], SolidArrays, ContractionScratch -> (E,) f8, (E, 3) f8
def contractions(hull, limit, solid, scratch, costs, places):
    """Writes the contraction point (E, 3) of each edge (E, 2) of a hull, and its distance from the solid.

    The distance is inf if no contraction point lies within `limit` of the solid. around[starts[v]:starts[v + 1]]
    are the faces at vertex v.
    """
    points, edges, starts = hull.points, hull.edges, hull.starts
    planes, found = scratch.planes, scratch.found
    for e in range(edges.shape[0]):
        costs[e] = np.inf
        a, b = edges[e, 0], edges[e, 1]
        if starts[a + 1] - starts[a] + starts[b + 1] - starts[b] > planes.shape[0]:
            continue
        count = planes_at(a, b, hull, scratch)
        dx, dy, dz = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1], points[a, 2] - points[b, 2]
        x, y, z = points[b, 0] + 0.5 * dx, points[b, 1] + 0.5 * dy, points[b, 2] + 0.5 * dz
        size = np.sqrt(dx * dx + dy * dy + dz * dz)
        if not least_beyond_planes(scratch, count, x, y, z, size):
            continue
        px, py, pz = found[0], found[1], found[2]
        cost = outside_distance(solid, px, py, pz, limit)
        if not cost <= limit:
            continue
        high = 0.0
        for k in range(count):
            high = max(high, planes[k, 0] * px + planes[k, 1] * py + planes[k, 2] * pz - planes[k, 3])
        costs[e] = cost + 0.1 * high
        places[e, 0], places[e, 1], places[e, 2] = px, py, pz
