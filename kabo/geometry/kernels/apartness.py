"""Whether the faces that a contraction would make cross each other or the rest of the mesh.

Decided by exact signs, so without a tolerance; crossings that the mesh has already may stay, but not become more.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.kernels.crossing import faces_cross
from kabo.geometry.kernels.octree import query


@lean_kernel
def _more_cross(vertices, faces, star, count, other, spare, work):
    """Whether more new faces, whose moving corner is vertex `spare`, cross face `other` than faces of the star do now."""
    d, e, h, pair, exact = faces[other, 0], faces[other, 1], faces[other, 2], work.pair, work.exact
    listed, corners = star.faces, star.corners
    more = 0
    for i in range(count):
        f, k = listed[i], corners[i]
        more -= faces_cross(vertices, faces[f, 0], faces[f, 1], faces[f, 2], d, e, h, pair, exact)
        if k >= 0:
            b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
            more += faces_cross(vertices, spare, b, c, d, e, h, pair, exact)
    return more > 0


@lean_kernel
def _is_graph(vertices, faces, star, count, spare):
    """Whether the new faces, whose moving corner is vertex `spare`, go around it once as seen along some direction.

    Then they do not cross. Proven if every face turns towards the direction by more than rounding.
    """
    listed, corners, planes = star.faces, star.corners, star.planes
    x, y, z = vertices[spare, 0], vertices[spare, 1], vertices[spare, 2]
    dx, dy, dz = 0.0, 0.0, 0.0
    for i in range(count):
        f, k = listed[i], corners[i]
        if k < 0:
            continue
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        ux, uy, uz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        vx, vy, vz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        scale = 1.0 / np.sqrt((ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz))
        planes[i, 0], planes[i, 1], planes[i, 2] = nx * scale, ny * scale, nz * scale
        dx, dy, dz = dx + nx * scale, dy + ny * scale, dz + nz * scale
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    if not length > 1e-6:
        return False
    dx, dy, dz = dx / length, dy / length, dz / length
    # Any direction across will do, one that meshes do not favour is met by no corner. From above the faces turn
    # counter-clockwise, and are counted where they pass it.
    ex, ey, ez = 0.7321 * dz - 0.5403 * dy, 0.5403 * dx - 0.4142 * dz, 0.4142 * dy - 0.7321 * dx
    turns = 0
    for i in range(count):
        f, k = listed[i], corners[i]
        if k < 0:
            continue
        if not planes[i, 0] * dx + planes[i, 1] * dy + planes[i, 2] * dz > 1e-9:
            return False
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        bx, by, bz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        side_b, length_of_b = ex * bx + ey * by + ez * bz, abs(bx) + abs(by) + abs(bz)
        side_c = ex * (vertices[c, 0] - x) + ey * (vertices[c, 1] - y) + ez * (vertices[c, 2] - z)
        if abs(side_b) <= 1e-12 * length_of_b:  # on which side is not sure
            return False
        if side_b < 0.0 and side_c >= 0.0:
            turns += 1
    return turns == 1


@lean_kernel
def _star_crosses_itself(vertices, faces, star, count, spare, work):
    """Whether two new faces, whose moving corner is vertex `spare`, cross."""
    listed, corners, pair, exact = star.faces, star.corners, work.pair, work.exact
    for i in range(count):
        f, k = listed[i], corners[i]
        if k < 0:
            continue
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        for j in range(i):
            g, m = listed[j], corners[j]
            if m >= 0:
                d, e = faces[g, (m + 1) % 3], faces[g, (m + 2) % 3]
                if faces_cross(vertices, spare, b, c, spare, d, e, pair, exact):
                    return True
    return False


@lean_kernel
def keeps_apart(net, star, count, x, y, z, tree, work):
    """Whether the new faces cross no other face more often than the old star did, nor each other."""
    v, faces, face_marks, star_mark = net.vertices, net.faces, net.face_marks, net.clock[1]
    listed, corners, found, stack, pair, exact = (
        star.faces,
        star.corners,
        work.found,
        work.stack,
        work.pair,
        work.exact,
    )
    spare = v.shape[0] - 1
    v[spare, 0], v[spare, 1], v[spare, 2] = x, y, z
    if not _is_graph(v, faces, star, count, spare) and _star_crosses_itself(v, faces, star, count, spare, work):
        return False
    for i in range(count):
        f, k = listed[i], corners[i]
        if k < 0:
            continue
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        low_x, high_x = min(x, v[b, 0], v[c, 0]), max(x, v[b, 0], v[c, 0])
        low_y, high_y = min(y, v[b, 1], v[c, 1]), max(y, v[b, 1], v[c, 1])
        low_z, high_z = min(z, v[b, 2], v[c, 2]), max(z, v[b, 2], v[c, 2])
        for j in range(query(tree, low_x, low_y, low_z, high_x, high_y, high_z, stack, found)):
            g = found[j]
            if face_marks[g] == star_mark:
                continue
            crosses = faces_cross(v, spare, b, c, faces[g, 0], faces[g, 1], faces[g, 2], pair, exact)
            if crosses and _more_cross(v, faces, star, count, g, spare, work):
                return False
    return True
