"""The star of an edge, the faces at its two ends: gathering it, testing its replacement, and contracting the edge.

A `net` has vertices (V, 3), faces (F, 3; dead ones start with -1), unit normals (F, 3; zero for faces without an area),
and for each vertex a linked list of its corners: corner 3 f + k is vertex k of face f; `first` (V,), `following` (3 F,).
A `star` is scratch: its faces (S,), and for each the place `corners` (S,) of the vertex that moves; -1 if it vanishes.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.bounding.kernels.contraction_point import cheapest_outside
from kabo.geometry.bounding.kernels.quadrics import (
    MEMORYLESS,
    TRIANGLES,
    add_plane,
    add_point,
    combine,
    cost_at,
    move_origin,
)
from kabo.geometry.triangles.kernels.orientation import orientation

MIN_DOUBLE_AREA = 1e-14  # of a new face, in squared diagonals
MIN_COORDINATE = 1e-80  # [m]: exact signs need coordinates that are 0 or larger than this
MIN_VOLUME_SHARE = 1e-9  # of a component's volume, which must remain


@lean_kernel  # (V, 3) f8, (F, 3) i8, (F, 3) f8, i8 -> nothing
def set_normal(vertices, faces, normals, f):
    """Computes the unit normal of face f; zero if its corners lie on a line."""
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    ux, uy, uz = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1], vertices[b, 2] - vertices[a, 2]
    vx, vy, vz = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1], vertices[c, 2] - vertices[a, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1.0 / length if length > 1e-150 else 0.0
    normals[f, 0], normals[f, 1], normals[f, 2] = x * scale, y * scale, z * scale


@lean_kernel
def gather_star(net, a, b, star):
    """Lists the faces at a, then the others at b; returns their number, 0 if `star` is too small for them."""
    faces, first, following = net.faces, net.first, net.following
    listed, corners = star.faces, star.corners
    count = 0
    for end in range(2):
        v, other = (a, b) if end == 0 else (b, a)
        c = first[v]
        while c >= 0:
            f = c // 3
            shared = faces[f, 0] == other or faces[f, 1] == other or faces[f, 2] == other
            if end == 0 or not shared:
                if count == listed.shape[0]:
                    return 0
                listed[count], corners[count] = f, -1 if shared else c % 3
                count += 1
            c = following[c]
    return count


@lean_kernel
def _set_planes(vertices, faces, normals, star, count, x, y, z):
    """Writes the planes of the star relative to the point x, y, z; returns how many of them bound the new point."""
    listed, planes, bounds = star.faces, star.planes, star.bounds
    many = 0
    for i in range(count):
        f = listed[i]
        v = faces[f, 0]
        nx, ny, nz = normals[f, 0], normals[f, 1], normals[f, 2]
        offset = nx * (vertices[v, 0] - x) + ny * (vertices[v, 1] - y) + nz * (vertices[v, 2] - z)
        planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3] = nx, ny, nz, offset
        if nx != 0.0 or ny != 0.0 or nz != 0.0:
            bounds[many, 0], bounds[many, 1], bounds[many, 2], bounds[many, 3] = nx, ny, nz, offset
            many += 1
    return many


@lean_kernel
def contraction_point(net, a, b, star, count, settings):
    """The cheapest point that may replace the edge a, b: its cost (inf if none), x, y, z. The star must be gathered."""
    vertices, q = net.vertices, star.quadric
    x = 0.5 * (vertices[a, 0] + vertices[b, 0])
    y = 0.5 * (vertices[a, 1] + vertices[b, 1])
    z = 0.5 * (vertices[a, 2] + vertices[b, 2])
    many = _set_planes(vertices, net.faces, net.normals, star, count, x, y, z)
    if settings.cost != MEMORYLESS:
        combine(settings.cost, net.quadrics[a], net.quadrics[b], q, settings.epsilon, star.scratch)
        move_origin(q, x - settings.x, y - settings.y, z - settings.z)
    else:
        planes, corners = star.planes, star.corners
        for r in range(10):
            q[r] = 0.0
        for i in range(count):
            weight = 2.0 if corners[i] < 0 else 1.0  # both ends count their faces
            add_plane(q, planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3], weight)
    good, dx, dy, dz = cheapest_outside(
        q, star.bounds, many, settings.regular, settings.slack, star.lower, star.turned, star.holding
    )
    if not good:
        return np.inf, x, y, z
    cost, x, y, z = max(0.0, cost_at(q, dx, dy, dz)), x + dx, y + dy, z + dz
    x, y, z = (
        x if abs(x) > MIN_COORDINATE else 0.0,
        y if abs(y) > MIN_COORDINATE else 0.0,
        z if abs(z) > MIN_COORDINATE else 0.0,
    )
    return cost, x, y, z


@lean_kernel
def keeps_topology(net, trial):
    """Whether contracting edge a-b keeps a manifold: a and b have two common neighbours, and more than two faces."""
    faces, first, following, marks, clock = net.faces, net.first, net.following, net.marks, net.clock
    a, b = trial.a, trial.b
    if trial.size < 5:
        return False
    stamp, common = clock[0] + 2, 0
    clock[0] = stamp
    c = first[a]
    while c >= 0:
        for k in range(3):
            marks[faces[c // 3, k]] = stamp
        c = following[c]
    c = first[b]
    while c >= 0:
        for k in range(3):
            v = faces[c // 3, k]
            if v != a and v != b and marks[v] == stamp:
                marks[v] = stamp + 1
                common += 1
        c = following[c]
    return common == 2


@lean_kernel
def keeps_sides(net, star, trial, exact):
    """Whether the new point, which is the last vertex, is proven not to lie behind any face of the star.

    If so, the solid only grows by tetrahedra of non-negative volume, so that winding numbers do not decrease.
    """
    vertices, faces, listed, spare = net.vertices, net.faces, star.faces, net.vertices.shape[0] - 1
    for i in range(trial.size):
        f = listed[i]
        if orientation(vertices, faces[f, 0], faces[f, 1], faces[f, 2], spare, exact) < 0:
            return False
    return True


@lean_kernel
def volume_after(net, star, trial):
    """The signed volume of the star's component after adding the tetrahedra of its faces to the new point."""
    vertices, faces, listed, x, y, z = net.vertices, net.faces, star.faces, trial.x, trial.y, trial.z
    added = 0.0
    for i in range(trial.size):
        f = listed[i]
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = vertices[a, 0] - x, vertices[a, 1] - y, vertices[a, 2] - z
        bx, by, bz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        cx, cy, cz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        added -= ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return net.volumes[net.components[faces[listed[0], 0]], 0] + added / 6.0


@lean_kernel
def keeps_orientation(net, star, trial):
    """Whether the star's component keeps the sign of its volume, so that a thin component is not turned inside out."""
    start = net.volumes[net.components[net.faces[star.faces[0], 0]], 1]
    after = volume_after(net, star, trial)
    return after >= MIN_VOLUME_SHARE * start if start > 0.0 else after <= MIN_VOLUME_SHARE * start


@lean_kernel  # (V, 3) f8, (F, 3) i8, i8, i8, f8 x 3, (P, 16) f8 -> nothing
def set_moved(vertices, faces, f, k, x, y, z, pieces):
    """Writes face f with its corner k moved to x, y, z into row 0 of pieces."""
    for j in range(3):
        v = faces[f, j]
        for r in range(3):
            pieces[0, 3 * j + r] = vertices[v, r]
    k *= 3
    pieces[0, k], pieces[0, k + 1], pieces[0, k + 2] = x, y, z


@lean_kernel
def keeps_facing(net, star, trial, settings):
    """Whether no face rotates by more than the angle with cosine `settings.facing`, and none degenerates to a line."""
    vertices, faces, normals, listed, corners = net.vertices, net.faces, net.normals, star.faces, star.corners
    x, y, z, diagonal, least = trial.x, trial.y, trial.z, settings.diagonal, settings.facing
    for i in range(trial.size):
        f, k = listed[i], corners[i]
        if k < 0:
            continue
        b, c = faces[f, (k + 1) % 3], faces[f, (k + 2) % 3]
        ux, uy, uz = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
        vx, vy, vz = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        squared = nx * nx + ny * ny + nz * nz
        if not squared > (MIN_DOUBLE_AREA * diagonal * diagonal) ** 2:
            return False
        if nx * normals[f, 0] + ny * normals[f, 1] + nz * normals[f, 2] < least * np.sqrt(squared):
            return False
    return True


@lean_kernel  # (V,) i8, (3 F,) i8, i8 x 2 -> nothing
def _unlink(first, following, v, f):
    """Removes face f from the list of vertex v."""
    c, before = first[v], -1
    while c >= 0:
        if c // 3 == f:
            if before < 0:
                first[v] = following[c]
            else:
                following[before] = following[c]
            return
        before = c
        c = following[c]


@lean_kernel
def contract(net, star, trial, settings):
    """Contracts edge a-b: moves vertex a to the new point; removes vertex b and the faces that contain both."""
    vertices, faces, normals, first, following = net.vertices, net.faces, net.normals, net.first, net.following
    listed, corners, a, b = star.faces, star.corners, trial.a, trial.b
    net.volumes[net.components[a], 0] = volume_after(net, star, trial)
    if settings.cost != MEMORYLESS:
        combine(settings.cost, net.quadrics[a], net.quadrics[b], star.quadric, settings.epsilon, star.scratch)
        for r in range(10):
            net.quadrics[a, r] = star.quadric[r]
    vertices[a, 0], vertices[a, 1], vertices[a, 2] = trial.x, trial.y, trial.z
    first[a] = first[b] = -1
    for i in range(trial.size):
        f, k = listed[i], corners[i]
        if k < 0:
            for j in range(3):
                v = faces[f, j]
                if v != a and v != b:
                    _unlink(first, following, v, f)
            faces[f, 0] = -1
            continue
        faces[f, k] = a
        following[3 * f + k] = first[a]
        first[a] = 3 * f + k
        set_normal(vertices, faces, normals, f)
    net.dead[b] = True


@lean_kernel
def _add_face(net, f, settings):
    """Adds the quadric of face f to those of its vertices."""
    vertices, faces, normals, quadrics = net.vertices, net.faces, net.normals, net.quadrics
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
    x = (vertices[a, 0] + vertices[b, 0] + vertices[c, 0]) / 3.0 - settings.x
    y = (vertices[a, 1] + vertices[b, 1] + vertices[c, 1]) / 3.0 - settings.y
    z = (vertices[a, 2] + vertices[b, 2] + vertices[c, 2]) / 3.0 - settings.z
    nx, ny, nz = normals[f, 0], normals[f, 1], normals[f, 2]
    offset = nx * x + ny * y + nz * z
    for k in range(3):
        if settings.cost == TRIANGLES:
            add_point(quadrics[faces[f, k]], x, y, z, 1.0)
        else:
            add_plane(quadrics[faces[f, k]], nx, ny, nz, offset, 1.0)


@lean_kernel
def prepare(net, settings):
    """Computes the normals, corner lists, volumes and quadrics of a net whose vertices and faces are filled in."""
    vertices, faces, normals, first, following = net.vertices, net.faces, net.normals, net.first, net.following
    for v in range(first.shape[0]):
        first[v] = -1
    for f in range(faces.shape[0]):
        set_normal(vertices, faces, normals, f)
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ax, ay, az = vertices[a, 0] - settings.x, vertices[a, 1] - settings.y, vertices[a, 2] - settings.z
        bx, by, bz = vertices[b, 0] - settings.x, vertices[b, 1] - settings.y, vertices[b, 2] - settings.z
        cx, cy, cz = vertices[c, 0] - settings.x, vertices[c, 1] - settings.y, vertices[c, 2] - settings.z
        part = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        net.volumes[net.components[a], 0] += part / 6.0
        for k in range(3):
            v = faces[f, k]
            following[3 * f + k] = first[v]
            first[v] = 3 * f + k
        if settings.cost != MEMORYLESS:
            _add_face(net, f, settings)
    for c in range(net.volumes.shape[0]):
        net.volumes[c, 1] = net.volumes[c, 0]
