"""An octree of signed distances from a solid, refined on demand: classifies balls and points as near or far.

A node holds the distance of its centre from the surface, negative inside: there it is the depth below the surface of
one group of components, whichever is deepest, since faces inside other components are no surface. The distance
changes by no more than the distance to another point, so the bounds for points around the centre are as certain as
the distance itself.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.bounding.kernels.union_depth import deepest_squared
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle

FINEST_NODE_SHARE = 0.1  # of the limit: half the side of the smallest nodes
ROUNDING_SHARE = 1e-9  # of the limit: margin for rounding
ALL_NEAR, MIDDLE_FAR, UNDECIDED = 1, 2, 0
CHILD_DISTANCE = 0.8660255  # of half the side of a node, from its centre to a child's


@lean_kernel  # f8 x 3, f8, f8 [m], SolidArrays -> f8
def _depth(x, y, z, known, away, solid):
    """The distance of a point to the surface, negative inside, and there of the group that it is deepest in.

    `known` is that of another point, `away` from this one.
    """
    most = (abs(known) + away) * (1.0 + 1e-9)
    squared, _ = nearest_triangle(solid.boxes, solid.children, solid.triangles, x, y, z, most * most, solid.stack)
    within = known < 0.0
    if not abs(known) > away * (1.0 + 1e-9):  # the surface may lie between
        within = inside(solid.boxes, solid.children, solid.triangles, x, y, z, solid.stack)
    return -np.sqrt(deepest_squared(x, y, z, squared, solid)) if within else np.sqrt(squared)


@lean_kernel  # f8 x 5 [m], SolidArrays -> i8
def settled(x, y, z, ball, limit, solid):
    """ALL_NEAR if all of a ball is near the solid, MIDDLE_FAR if the ball's centre is far, else UNDECIDED.

    `frame` holds the root's centre, half its side, and the number of nodes. A depth of NaN is not computed yet.
    The eight children of node i are consecutive from `firsts[i]` on; `firsts[i]` is 0 if it has no children.
    """
    frame, depths, firsts = solid.frame, solid.depths, solid.firsts
    cx, cy, cz, half = frame[0], frame[1], frame[2], frame[3]
    if max(abs(x - cx), max(abs(y - cy), abs(z - cz))) > half:
        return UNDECIDED
    n, slack, known, between = 0, ROUNDING_SHARE * limit, 0.0, np.inf
    while True:
        if np.isnan(depths[n]):
            depths[n] = _depth(cx, cy, cz, known, between, solid)
        away = np.sqrt((x - cx) ** 2 + (y - cy) ** 2 + (z - cz) ** 2)
        if depths[n] + away + ball <= limit - slack:
            return ALL_NEAR
        if depths[n] - away > limit + slack:
            return MIDDLE_FAR
        known, between = depths[n], CHILD_DISTANCE * half
        half *= 0.5
        if half < FINEST_NODE_SHARE * limit or depths[n] - away + ball > limit:  # no smaller node could say more
            return UNDECIDED
        if firsts[n] == 0:
            end = int(frame[4])
            if end + 8 > depths.shape[0]:
                return UNDECIDED
            firsts[n], frame[4] = end, end + 8.0
        n = firsts[n]
        if x > cx:
            n, cx = n + 1, cx + half
        else:
            cx -= half
        if y > cy:
            n, cy = n + 2, cy + half
        else:
            cy -= half
        if z > cz:
            n, cz = n + 4, cz + half
        else:
            cz -= half


@lean_kernel  # f8 x 3, f8 [m], SolidArrays -> bool
def is_far(x, y, z, limit, solid):
    """Whether a point is neither inside the solid nor within `limit` of it."""
    known = settled(x, y, z, 0.0, limit, solid)
    if known != UNDECIDED:
        return known == MIDDLE_FAR
    _, near = nearest_triangle(solid.boxes, solid.children, solid.triangles, x, y, z, limit * limit, solid.stack)
    return near < 0 and not inside(solid.boxes, solid.children, solid.triangles, x, y, z, solid.stack)


@lean_kernel  # (N, 3) f8, f8 [m], SolidArrays -> i8
def first_far(points, limit, solid):
    """The first point that is neither inside the solid nor within `limit` of it; -1 if there is none."""
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if is_far(x, y, z, limit, solid):
            return i
    return -1


@lean_kernel  # (P, 3) f8, (F, 3) i4, (S, 4) f8, i8, (F,) f8, (3,) f8, f8 [m], SolidArrays -> bool
def hull_is_far(points, faces, even, looks, sums, at, limit, solid):
    """Whether a sampled point of a hull is farther than `limit` from the solid; writes this point to `at`.

    Before the call `at` holds an interior point. even (S, 4): numbers from 0 to 1, which choose a face by its
    area, a point in it, and, for all but the first `looks` samples, how far the point is moved towards the
    interior one.
    """
    total, mx, my, mz = 0.0, at[0], at[1], at[2]
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy, uz = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1], points[b, 2] - points[a, 2]
        vx, vy, vz = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        px, py, pz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        total += np.sqrt(px * px + py * py + pz * pz)
        sums[f] = total
    for s in range(even.shape[0]):
        low, high, wanted = 0, faces.shape[0] - 1, even[s, 0] * total
        while low < high:
            middle = (low + high) // 2
            if sums[middle] < wanted:
                low = middle + 1
            else:
                high = middle
        a, b, c = faces[low, 0], faces[low, 1], faces[low, 2]
        root = np.sqrt(even[s, 1])
        u, v, w = 1.0 - root, root * (1.0 - even[s, 2]), root * even[s, 2]
        for r in range(3):
            at[r] = u * points[a, r] + v * points[b, r] + w * points[c, r]
        if s >= looks:
            share = even[s, 3] ** (1.0 / 3.0)
            at[0], at[1], at[2] = mx + share * (at[0] - mx), my + share * (at[1] - my), mz + share * (at[2] - mz)
        if is_far(at[0], at[1], at[2], limit, solid):
            return True
    return False


@lean_kernel  # (P, 3) f8, (Q, 3) f8, (S, 4) f8, f8 [m], SolidArrays -> bool
def between_is_far(one, other, even, limit, solid):
    """Whether a sampled point of the segments between two sets of points is farther than `limit` from the solid."""
    for s in range(even.shape[0]):
        i, j, t = int(even[s, 0] * one.shape[0]), int(even[s, 1] * other.shape[0]), even[s, 2]
        x = one[i, 0] + t * (other[j, 0] - one[i, 0])
        y = one[i, 1] + t * (other[j, 1] - one[i, 1])
        z = one[i, 2] + t * (other[j, 2] - one[i, 2])
        if is_far(x, y, z, limit, solid):
            return True
    return False


@lean_kernel  # (P, 3) f8, (F, 3) i4, i8, i8, (3,) f8, f8 [m], SolidArrays -> bool
def star_is_far(points, faces, a, b, place, limit, solid):
    """Whether contracting edge a-b of a hull to `place` would create faces farther than `limit` from the solid.

    Two points of each new edge are tested, and the centre of each new face.
    """
    for f in range(faces.shape[0]):
        held = 0
        for c in range(3):
            held += 1 if faces[f, c] in (a, b) else 0
        if held == 0:
            continue
        mx, my, mz = place[0], place[1], place[2]
        for c in range(3):
            last = faces[f, c]
            if last in (a, b):
                continue
            px, py, pz = points[last, 0], points[last, 1], points[last, 2]
            mx, my, mz = mx + px, my + py, mz + pz
            for part in range(2):
                share = 0.5 + 0.25 * part
                x = px + share * (place[0] - px)
                y = py + share * (place[1] - py)
                z = pz + share * (place[2] - pz)
                if is_far(x, y, z, limit, solid):
                    return True
        mx, my, mz = mx / 3.0, my / 3.0, mz / 3.0
        if held == 1 and is_far(mx, my, mz, limit, solid):
            return True
    return False
