"""Triangles clipped by a convex part: what of a mesh is inside [Sutherland and Hodgman 1974]."""

import numpy as np

from kabo.compilation import kernel


@kernel  # (2, N, 3) f8, i8, i8, (4,) f8, f8 -> i8
def clip(polygons, own, size, plane, slack):
    """Clips a convex polygon of `size` corners in `polygons[own]` at n·x + d <= slack, into the other one.

    Returns the corners of the result; -1 if nothing is cut off, and nothing was written.
    """
    nx, ny, nz, d = plane[0], plane[1], plane[2], plane[3] - slack
    given, made = polygons[own], polygons[1 - own]
    cut = False
    for i in range(size):
        cut = cut or given[i, 0] * nx + given[i, 1] * ny + given[i, 2] * nz + d > 0.0
    if not cut:
        return -1
    count, before = 0, size - 1
    height = given[before, 0] * nx + given[before, 1] * ny + given[before, 2] * nz + d
    for i in range(size):
        own_height = given[i, 0] * nx + given[i, 1] * ny + given[i, 2] * nz + d
        if (height > 0.0) != (own_height > 0.0):
            share = height / (height - own_height)
            for k in range(3):
                made[count, k] = given[before, k] + share * (given[i, k] - given[before, k])
            count += 1
        if own_height <= 0.0:
            made[count] = given[i]
            count += 1
        height, before = own_height, i
    return count


@kernel  # (V, 3) f8, (T, 3) i8, (6,) f8, (T, 3, 3) f8 -> i8
def triangles_at(vertices, faces, box, found):
    """The triangles whose boxes meet a box, given by its lower and upper corner, one after the other; returns how many."""
    count = 0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        meets = True
        for k in range(3):
            x, y, z = vertices[a, k], vertices[b, k], vertices[c, k]
            meets = meets and min(x, y, z) <= box[3 + k] and max(x, y, z) >= box[k]
        if meets:
            found[count, 0], found[count, 1], found[count, 2] = vertices[a], vertices[b], vertices[c]
            count += 1
    return count


@kernel  # (T, 3, 3) f8, (P, 4) f8, f8, (3,) f8, f8, (2, P + 4, 3) f8 -> f8
def clipped_reach(triangles, planes, slack, direction, enough, polygons):
    """How far triangles reach along a direction within `slack` of a convex part; -inf if none of them does.

    Args:
        triangles: their corners.
        planes: of the part: n·x + d <= 0, with |n| = 1.
        slack: [m].
        direction: of length 1.
        enough: a reach at which the search ends, with a reach of at least this.
        polygons: room to work in.
    """
    x, y, z = direction[0], direction[1], direction[2]
    best = -np.inf
    for t in range(len(triangles)):
        least = best
        for i in range(3):
            least = max(least, triangles[t, i, 0] * x + triangles[t, i, 1] * y + triangles[t, i, 2] * z)
        if least <= best:
            continue
        own, size = 0, 3
        polygons[0, :3] = triangles[t]
        for p in range(len(planes)):
            left = clip(polygons, own, size, planes[p], slack)
            if left >= 0:
                own, size = 1 - own, left
                if size == 0:
                    break
        for i in range(size):
            best = max(best, polygons[own, i, 0] * x + polygons[own, i, 1] * y + polygons[own, i, 2] * z)
        if best >= enough:
            break
    return best
