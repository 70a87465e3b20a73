"""Triangles clipped by a convex part: what of a mesh is inside [Sutherland and Hodgman 1974]."""

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
