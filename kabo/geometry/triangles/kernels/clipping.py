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


@kernel  # (V, 3) f8, (T, 3) i8, (P, 4) f8, (6,) f8, f8, (2, P + 4, 3) f8, (N, 3) f8 -> i8
def clipped_triangles(vertices, faces, planes, box, slack, polygons, found):
    """The corners of what of each triangle is within `slack` of a convex part, one after the other in `found`.

    Args:
        vertices, faces: the triangles.
        planes: of the part: n·x + d <= 0, of length 1.
        box: around the part, lower and upper corner.
        slack: [m].
        polygons: room to work in.
        found: room for the corners.

    Returns the number of corners; -1 if there is no room for all of them.
    """
    count = 0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        apart = False
        for k in range(3):
            x, y, z = vertices[a, k], vertices[b, k], vertices[c, k]
            apart = apart or min(x, y, z) > box[3 + k] + slack or max(x, y, z) < box[k] - slack
        if apart:
            continue
        own, size = 0, 3
        polygons[0, 0], polygons[0, 1], polygons[0, 2] = vertices[a], vertices[b], vertices[c]
        for p in range(len(planes)):
            left = clip(polygons, own, size, planes[p], slack)
            if left >= 0:
                own, size = 1 - own, left
                if size == 0:
                    break
        if count + size > len(found):
            return -1
        found[count : count + size] = polygons[own, :size]
        count += size
    return count
