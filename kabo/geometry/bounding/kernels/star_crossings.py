"""A test whether the new faces of a contraction would cross each other or the rest of the mesh.

The decision uses exact signs, without a tolerance. Existing crossings may stay, and may move to other faces, but
must not increase, neither in the number of crossing faces nor in the number of ends of their common segments. A
limit for each single face would preserve folds that two contractions remove, or let one crossing face become two.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.crossing import faces_cross
from kabo.geometry.triangles.kernels.octree import query


@lean_kernel
def _is_graph(vertices, faces, star, count, spare):
    """Whether the new faces around vertex `spare` wind around it once, seen along some direction.

    Then they do not cross each other. This is proven if every face turns towards the direction by more than
    rounding.
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
    """Whether any two of the new faces around vertex `spare` cross."""
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
def _near(net, f, k, x, y, z, tree, work):
    """Lists the faces whose boxes meet that of face f with corner k moved to x, y, z (unmoved if k < 0); their number."""
    v, a, b, c = net.vertices, net.faces[f, 0], net.faces[f, 1], net.faces[f, 2]
    ax, ay, az = (x, y, z) if k == 0 else (v[a, 0], v[a, 1], v[a, 2])
    bx, by, bz = (x, y, z) if k == 1 else (v[b, 0], v[b, 1], v[b, 2])
    cx, cy, cz = (x, y, z) if k == 2 else (v[c, 0], v[c, 1], v[c, 2])
    low_x, low_y, low_z = min(ax, bx, cx), min(ay, by, cy), min(az, bz, cz)
    high_x, high_y, high_z = max(ax, bx, cx), max(ay, by, cy), max(az, bz, cz)
    return query(tree, low_x, low_y, low_z, high_x, high_y, high_z, work.stack, work.found)


@lean_kernel
def _crossing(net, f, k, g, m, work):
    """The number of ends, other than shared vertices, of two faces' common segment, at least 1; 0 if they do not cross.

    Corner k of face f is moved to vertex `spare`, and so is corner m of face g; a negative index moves no corner.
    """
    faces, spare = net.faces, net.vertices.shape[0] - 1
    a, b, c = (
        (spare if k == 0 else faces[f, 0]),
        (spare if k == 1 else faces[f, 1]),
        (spare if k == 2 else faces[f, 2]),
    )
    d, e, h = (
        (spare if m == 0 else faces[g, 0]),
        (spare if m == 1 else faces[g, 1]),
        (spare if m == 2 else faces[g, 2]),
    )
    if not faces_cross(net.vertices, a, b, c, d, e, h, work.pair, work.exact):
        return 0
    shared = (a == d) + (a == e) + (a == h) + (b == d) + (b == e) + (b == h) + (c == d) + (c == e) + (c == h)
    return max(1, 2 - shared)


@lean_kernel
def _tally(net, star, count, new, touched, tree, work):
    """How many faces of the star, old or new, cross others, with how many ends; and the number of others in star.ring.

    Others are marked with 1 (the old star crosses them) and 2 (the new one does) above the star's own mark.
    """
    v, marks, mark, listed, crosses = net.vertices, net.face_marks, net.clock[1], star.faces, star.places
    x, y, z = v[v.shape[0] - 1, 0], v[v.shape[0] - 1, 1], v[v.shape[0] - 1, 2]
    ends = 0
    for i in range(count):
        f, k = listed[i], star.corners[i] if new else -1
        crosses[i] = 0
        if new and star.corners[i] < 0:
            continue
        for j in range(i):
            if not new or star.corners[j] >= 0:
                more = _crossing(net, f, k, listed[j], star.corners[j] if new else -1, work)
                if more > 0:
                    crosses[i], crosses[j], ends = 1, 1, ends + more
        for n in range(_near(net, f, k, x, y, z, tree, work)):
            g = work.found[n]
            more = _crossing(net, f, k, g, -1, work) if marks[g] != mark else 0
            if more == 0:
                continue
            crosses[i], ends = 1, ends + more
            if marks[g] < mark:
                if touched == star.ring.shape[0]:
                    return count, ends, -1
                star.ring[touched], marks[g], touched = g, mark, touched + 1
            marks[g] = mark + ((marks[g] - mark) | (2 if new else 1))
    many = 0
    for i in range(count):
        many += crosses[i]
    return many, ends, touched


@lean_kernel
def _crosses_elsewhere(net, f, tree, work):
    """Whether a face outside of the star crosses another one outside of it."""
    for n in range(_near(net, f, -1, 0.0, 0.0, 0.0, tree, work)):
        g = work.found[n]
        if g != f and net.face_marks[g] != net.clock[1] and _crossing(net, f, -1, g, -1, work) > 0:
            return True
    return False


@lean_kernel
def _crossings_grow(net, star, count, tree, work):
    """Whether replacing the star by the new faces increases the number of crossing faces, or of ends."""
    marks, mark = net.face_marks, net.clock[1]
    before, ends, touched = _tally(net, star, count, False, 0, tree, work)
    if before == 0 or touched < 0:
        return True
    after, ends_after, touched = _tally(net, star, count, True, touched, tree, work)
    if ends_after > ends or touched < 0:
        return True
    more = after - before
    for n in range(touched):
        g = star.ring[n]
        if marks[g] != mark + 3 and not _crosses_elsewhere(net, g, tree, work):
            more += 1 if marks[g] == mark + 2 else -1
    return more > 0


@lean_kernel
def keeps_apart(net, star, trial, tree, work):
    """Whether the contraction creates no crossing faces, or at least does not increase existing crossings.

    The new point is the last vertex.
    """
    v, faces, count, x, y, z = net.vertices, net.faces, trial.size, trial.x, trial.y, trial.z
    spare, star_mark = v.shape[0] - 1, net.clock[1]
    apart = _is_graph(v, faces, star, count, spare) or not _star_crosses_itself(v, faces, star, count, spare, work)
    for i in range(count if apart else 0):
        f, k = star.faces[i], star.corners[i]
        for n in range(_near(net, f, k, x, y, z, tree, work) if k >= 0 else 0):
            g = work.found[n]
            if net.face_marks[g] != star_mark and _crossing(net, f, k, g, -1, work) > 0:
                apart = False
                break
        if not apart:
            break
    if apart:
        return True
    grow = _crossings_grow(net, star, count, tree, work)
    net.clock[1] += 3  # the marks above the star's are used up
    return not grow
