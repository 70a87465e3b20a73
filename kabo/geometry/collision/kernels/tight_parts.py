"""Convex parts drawn tight around what they hold of a mesh, and halved.

A polytope is its corners, each with marks: the bits of the planes on which it lies. Two corners are the ends of an edge if
they share two planes; so a plane cuts a polytope without a list of its faces.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import kernel, lean_kernel
from kabo.geometry.collision.kernels.simplex import nearest
from kabo.geometry.triangles.kernels.clipping import clip


class Room(NamedTuple):
    """Room for a cut: heights of corners above the plane, and the new corners."""

    heights: Array  # (64,)
    corners: Array  # (64, 3)
    marks: Integers  # (64, WORDS)


WORDS, BITS = 3, 62  # of marks: so many planes a polytope may have been cut by
MOST_CORNERS = 64
ON_PLANE = 1e-10  # [m] a corner so near a plane lies on it
SAME = 1e-9  # [m] corners so near each other are one
SEARCH_STEPS = 32
LOSS = 0.02  # of a distance, to which it is known
# Columns of `excess`: how far each corner sticks out, along which direction, to where.
EXCESS, NORMAL, OFFSET = 0, 1, 4


@lean_kernel
def _joined(marks, i, k):
    """Whether two corners share at least two planes."""
    count = 0
    for w in range(WORDS):
        both = marks[i, w] & marks[k, w]
        while both != 0 and count < 2:
            both &= both - 1
            count += 1
    return count >= 2


@kernel
def cut(corners, marks, excess, count, plane, bit, room):
    """Cuts a polytope of `count` corners at n·x <= d; returns how many it has then, -1 if these are too many.

    Nothing is written if these are too many. New corners have an excess of infinity: it is not known.
    """
    kept, made = 0, 0
    heights, fresh, fresh_marks = room.heights, room.corners, room.marks
    for i in range(count):
        heights[i] = plane[0] * corners[i, 0] + plane[1] * corners[i, 1] + plane[2] * corners[i, 2] - plane[3]
        kept += 1 if heights[i] <= ON_PLANE else 0
    if kept == count:
        return count
    for i in range(count):
        if heights[i] <= ON_PLANE:
            continue
        for k in range(count):
            if heights[k] >= -ON_PLANE or not _joined(marks, i, k):
                continue
            share = heights[k] / (heights[k] - heights[i])
            x = corners[k, 0] + share * (corners[i, 0] - corners[k, 0])
            y = corners[k, 1] + share * (corners[i, 1] - corners[k, 1])
            z = corners[k, 2] + share * (corners[i, 2] - corners[k, 2])
            at = 0
            while at < made and abs(fresh[at, 0] - x) + abs(fresh[at, 1] - y) + abs(fresh[at, 2] - z) > SAME:
                at += 1
            if kept + at >= MOST_CORNERS:
                return -1
            for w in range(WORDS):
                both = marks[i, w] & marks[k, w]
                fresh_marks[at, w] = both if at == made else fresh_marks[at, w] | both
            if at == made:
                fresh[made, 0], fresh[made, 1], fresh[made, 2] = x, y, z
                made += 1
    word, flag = bit // BITS, np.int64(1) << (bit % BITS)
    kept = 0
    for i in range(count):
        if heights[i] <= ON_PLANE:
            corners[kept], marks[kept], excess[kept] = corners[i], marks[i], excess[i]
            if heights[i] >= -ON_PLANE:
                marks[kept, word] |= flag
            kept += 1
    for i in range(made):
        corners[kept], marks[kept] = fresh[i], fresh_marks[i]
        marks[kept, word] |= flag
        excess[kept, EXCESS] = np.inf
        kept += 1
    return kept


@lean_kernel
def _stick_out(points, corner, own, simplex):
    """Writes how far a corner sticks out of the hull of points (3, N), in which direction, and how far they reach."""
    x, y, z = corner[0] - points[0, 0], corner[1] - points[1, 0], corner[2] - points[2, 0]
    size, best = 0, -np.inf
    for _ in range(SEARCH_STEPS):
        norm = np.sqrt(x * x + y * y + z * z)
        if not norm > 1e-9:
            break
        ux, uy, uz = x / norm, y / norm, z / norm
        most, at = -np.inf, 0
        for i in range(points.shape[1]):
            height = points[0, i] * ux + points[1, i] * uy + points[2, i] * uz
            if height > most:
                most, at = height, i
        out = corner[0] * ux + corner[1] * uy + corner[2] * uz - most
        if out > best:
            best, own[NORMAL], own[NORMAL + 1], own[NORMAL + 2], own[OFFSET] = out, ux, uy, uz, most
        if norm - best <= LOSS * norm:
            break
        for r in range(3):
            simplex[size, r] = corner[r] - points[r, at]
        size, x, y, z = nearest(simplex, size + 1)
        if size == 4:
            break
    own[EXCESS] = best


@kernel
def tighten(points, corners, marks, excess, count, bit, limits, plane, room, simplex):
    """Cuts off corners that stick out of points (3, N), the worst ones first; returns how many corners there are then.

    `limits` are what may stick out, and the distance of cuts from the points [m]; `bit` is the first free one.
    """
    for i in range(count):
        excess[i, EXCESS] = np.inf
    while bit < WORDS * BITS:
        worst = 0
        for i in range(count):
            if excess[i, EXCESS] == np.inf:
                _stick_out(points, corners[i], excess[i], simplex)
            if excess[i, EXCESS] > excess[worst, EXCESS]:
                worst = i
        if not excess[worst, EXCESS] > limits[0]:
            break
        for r in range(3):
            plane[r] = excess[worst, NORMAL + r]
        plane[3] = excess[worst, OFFSET] + limits[1]
        left = cut(corners, marks, excess, count, plane, bit, room)
        if (
            left < 0
            or left == count
            and corners[worst, 0] * plane[0] + corners[worst, 1] * plane[1] + corners[worst, 2] * plane[2]
            > plane[3] + ON_PLANE
        ):
            excess[worst, EXCESS] = -np.inf
            continue
        if left < count:  # there is room again
            for i in range(left):
                excess[i, EXCESS] = np.inf if excess[i, EXCESS] == -np.inf else excess[i, EXCESS]
        count, bit = left, bit + 1
    return count


@kernel  # (T, 3, 3) f8, (4,) f8, f8, (2, 4, 3) f8, (2 T, 3, 3) f8 -> i8
def halve(triangles, plane, slack, polygons, found):
    """Writes what of triangles is where n·x <= d, and up to `slack` beyond; returns how many triangles that is."""
    count, x, y, z, d = 0, plane[0], plane[1], plane[2], plane[3]
    for t in range(triangles.shape[0]):
        low, high = np.inf, -np.inf
        for i in range(3):
            height = triangles[t, i, 0] * x + triangles[t, i, 1] * y + triangles[t, i, 2] * z + d
            low, high = min(low, height), max(high, height)
        if low > slack:
            continue
        if high <= slack:
            found[count] = triangles[t]
            count += 1
            continue
        polygons[0, :3] = triangles[t]
        size = clip(polygons, 0, 3, plane, slack)
        for i in range(1, size - 1):
            found[count, 0], found[count, 1], found[count, 2] = polygons[1, 0], polygons[1, i], polygons[1, i + 1]
            count += 1
    return count


@lean_kernel  # (T, 3, 3) f8, (3,) f8, (4, 3) f8 -> f8
def distance_to(triangles, point, simplex):
    """The distance of a point from triangles [m]."""
    least = np.inf
    for t in range(triangles.shape[0]):
        far = 0.0
        for r in range(3):
            a, b, c = triangles[t, 0, r], triangles[t, 1, r], triangles[t, 2, r]
            beyond = max(min(a, b, c) - point[r], point[r] - max(a, b, c))
            far += beyond * beyond if beyond > 0.0 else 0.0
            simplex[0, r], simplex[1, r], simplex[2, r] = a - point[r], b - point[r], c - point[r]
        if far < least:
            _, x, y, z = nearest(simplex, 3)
            least = min(least, x * x + y * y + z * z)
    return np.sqrt(least)
