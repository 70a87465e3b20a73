"""Tetrahedra inside a solid, whose corners are near those of a piece of a part: they prove all of the piece at once.

A point of a tetrahedron is a mean of its corners. If each of these is within a limit of some point, its anchor, then the
mean is within the limit of the same mean of the anchors. So it is enough that the tetrahedron of the anchors is inside
the solid: that one anchor is, and no triangle of the solid meets the tetrahedron. Any choice of anchors is sound; good
ones lie somewhat below the surface, so that chords between them do not leave the solid.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle

FAR, NONE, FOUND = -1, 0, 1
DEEPEST_SHARE = 0.9  # of the room that the limit leaves: how far anchors are pushed inwards at first
PUSHES = 4  # each a third of the one before
GOOD_SHARE = 0.3  # of the depth that a push could reach, with which it is content
ROUNDING_SHARE = 1e-12  # of the greatest coordinate: triangles nearer than this count as meeting a tetrahedron
ON_SURFACE_SHARE = 1e-6  # of the limit: nearer to the surface no direction leads away from it
ANCHOR_SLACK = 1e-9  # of the limit: margin for rounding


@lean_kernel  # f8 x 3, (T, 3, 3) f8, i8, (3,) f8
def _nearest_point(x, y, z, triangles, t, found):
    """Writes a point of a triangle that is nearest to a point, but for rounding [Ericson 2005, 5.1.5]."""
    ax, ay, az = triangles[t, 0, 0], triangles[t, 0, 1], triangles[t, 0, 2]
    ux, uy, uz = triangles[t, 1, 0] - ax, triangles[t, 1, 1] - ay, triangles[t, 1, 2] - az
    vx, vy, vz = triangles[t, 2, 0] - ax, triangles[t, 2, 1] - ay, triangles[t, 2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    uu, vv, uv = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz
    up, vp = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    area = uu * vv - uv * uv
    s, t1 = -1.0, -1.0
    if area > 0.0:
        s, t1 = (vv * up - uv * vp) / area, (uu * vp - uv * up) / area
    if s < 0.0 or t1 < 0.0 or s + t1 > 1.0:  # on a side
        best = np.inf
        along = min(max(up / uu, 0.0), 1.0) if uu > 0.0 else 0.0
        for side in range(3):
            first, second = along, 0.0
            if side == 1:
                along = min(max(vp / vv, 0.0), 1.0) if vv > 0.0 else 0.0
                first, second = 0.0, along
            elif side == 2:
                length = uu + vv - 2.0 * uv
                along = min(max((vp - uv - up + uu) / length, 0.0), 1.0) if length > 0.0 else 0.0
                first, second = 1.0 - along, along
            dx = px - first * ux - second * vx
            dy = py - first * uy - second * vy
            dz = pz - first * uz - second * vz
            if dx * dx + dy * dy + dz * dz < best:
                best, s, t1 = dx * dx + dy * dy + dz * dz, first, second
    found[0], found[1], found[2] = ax + s * ux + t1 * vx, ay + s * uy + t1 * vy, az + s * uz + t1 * vz


@lean_kernel  # f8 x 3, (T, 3, 3) f8, i8 -> bool
def _is_behind(x, y, z, triangles, t):
    """Whether a point lies behind the plane of a triangle, which faces outwards."""
    ax, ay, az = triangles[t, 0, 0], triangles[t, 0, 1], triangles[t, 0, 2]
    ux, uy, uz = triangles[t, 1, 0] - ax, triangles[t, 1, 1] - ay, triangles[t, 1, 2] - az
    vx, vy, vz = triangles[t, 2, 0] - ax, triangles[t, 2, 1] - ay, triangles[t, 2, 2] - az
    height = (x - ax) * (uy * vz - uz * vy) + (y - ay) * (uz * vx - ux * vz) + (z - az) * (ux * vy - uy * vx)
    return height < 0.0


@lean_kernel  # (3,) f8, f8 x 5, SolidArrays, (3,) f8 -> f8
def _push(at, ux, uy, uz, best, most, solid, found):
    """Writes a point moved by u if it seems inside and deeper than `best`; returns the greater depth, `most` or less."""
    x, y, z = at[0] + ux, at[1] + uy, at[2] + uz
    boxes, children, triangles = solid.boxes, solid.children, solid.triangles
    squared, t = nearest_triangle(boxes, children, triangles, x, y, z, most * most, solid.stack)
    if squared <= best * best or t < 0 or not _is_behind(x, y, z, triangles, t):
        return best
    found[0], found[1], found[2] = x, y, z
    return np.sqrt(squared)


@lean_kernel  # (3,) f8, f8 [m], (3,) f8, SolidArrays, (3,) f8 -> i8
def anchor(at, limit, middle, solid, found):
    """Writes an anchor: a point within `limit` of a point that seems to be inside, below the surface if there is room.

    FOUND; NONE if no such point was found; FAR if the point is not within the limit of the solid. The point is moved
    through the nearest point of the surface, or away from it if inside, or else towards a middle (3,).
    """
    boxes, children, triangles, stack = solid.boxes, solid.children, solid.triangles, solid.stack
    x, y, z, enough = at[0], at[1], at[2], limit * limit
    squared, t = nearest_triangle(boxes, children, triangles, x, y, z, enough, stack)
    found[0], found[1], found[2] = x, y, z
    if t < 0:  # nothing of the surface is near
        return FOUND if inside(boxes, children, triangles, x, y, z, stack) else FAR
    distance, within = np.sqrt(squared), _is_behind(x, y, z, triangles, t)
    _nearest_point(x, y, z, triangles, t, found)
    ux, uy, uz = found[0] - x, found[1] - y, found[2] - z
    length = np.sqrt(ux * ux + uy * uy + uz * uz)
    scale = 0.0 if not length > ON_SURFACE_SHARE * limit else -1.0 / length if within else 1.0 / length
    ux, uy, uz = scale * ux, scale * uy, scale * uz
    vx, vy, vz = middle[0] - x, middle[1] - y, middle[2] - z
    away = np.sqrt(vx * vx + vy * vy + vz * vz)
    if within:
        found[0], found[1], found[2] = x, y, z
    best, begun = (distance, 0.0) if within else (0.0, length)
    room, share = limit * (1.0 - ANCHOR_SLACK) - distance, DEEPEST_SHARE
    for _ in range(PUSHES):
        step = begun + share * room
        most = 1.001 * (step + distance)
        wanted = GOOD_SHARE * (share * room + best)
        if scale != 0.0:
            best = _push(at, step * ux, step * uy, step * uz, best, most, solid, found)
        if best <= wanted and away > 0.0:
            step = min(step, away) / away
            best = _push(at, step * vx, step * vy, step * vz, best, most, solid, found)
        if best > wanted:
            break
        share /= 3.0
    return FOUND if best > 0.0 else NONE


@lean_kernel  # (P, 3) f8, f8 [m], (3,) f8, SolidArrays, (P, 3) f8 -> i8
def anchors_of(points, limit, middle, solid, found):
    """Writes an anchor for each point, NaN where there is none; the first point that is far from the solid, or -1."""
    for i in range(points.shape[0]):
        word = anchor(points[i], limit, middle, solid, found[i])
        if word == FAR:
            return i
        if word == NONE:
            found[i, 0] = np.nan
    return -1


@lean_kernel  # (4, 3) f8, (4, 4) f8
def _write_planes(corners, planes):
    """Writes the planes of a tetrahedron's sides, n·x <= d with |n| = 1; zeros for a side without area."""
    for k in range(4):
        a, b, c = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
        ux, uy, uz = corners[b, 0] - corners[a, 0], corners[b, 1] - corners[a, 1], corners[b, 2] - corners[a, 2]
        vx, vy, vz = corners[c, 0] - corners[a, 0], corners[c, 1] - corners[a, 1], corners[c, 2] - corners[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        opposite = nx * (corners[k, 0] - corners[a, 0]) + ny * (corners[k, 1] - corners[a, 1])
        opposite += nz * (corners[k, 2] - corners[a, 2])
        scale = 0.0 if not length > 0.0 else -1.0 / length if opposite > 0.0 else 1.0 / length
        nx, ny, nz, highest = nx * scale, ny * scale, nz * scale, -np.inf
        for r in range(4):
            highest = max(highest, nx * corners[r, 0] + ny * corners[r, 1] + nz * corners[r, 2])
        planes[k, 0], planes[k, 1], planes[k, 2], planes[k, 3] = nx, ny, nz, highest


@lean_kernel  # f8 x 3, (4, 3) f8, (T, 3, 3) f8, i8, f8 -> bool
def _separates(x, y, z, corners, triangles, t, slack):
    """Whether a tetrahedron and a triangle are apart along an axis."""
    least, most = np.inf, -np.inf
    for k in range(4):
        height = x * corners[k, 0] + y * corners[k, 1] + z * corners[k, 2]
        least, most = min(least, height), max(most, height)
    low, high = np.inf, -np.inf
    for c in range(3):
        height = x * triangles[t, c, 0] + y * triangles[t, c, 1] + z * triangles[t, c, 2]
        low, high = min(low, height), max(high, height)
    gap = slack * (abs(x) + abs(y) + abs(z))
    return low - most > gap or least - high > gap


@lean_kernel  # (4, 3) f8, (4, 4) f8, (T, 3, 3) f8, i8, f8 -> bool
def _apart(corners, planes, triangles, t, slack):
    """Whether a tetrahedron and a triangle are proven not to meet."""
    for k in range(4):
        low = np.inf
        for c in range(3):
            height = planes[k, 0] * triangles[t, c, 0] + planes[k, 1] * triangles[t, c, 1]
            low = min(low, height + planes[k, 2] * triangles[t, c, 2])
        if low - planes[k, 3] > slack:
            return True
    ux, uy, uz = (
        triangles[t, 1, 0] - triangles[t, 0, 0],
        triangles[t, 1, 1] - triangles[t, 0, 1],
        triangles[t, 1, 2] - triangles[t, 0, 2],
    )
    vx, vy, vz = (
        triangles[t, 2, 0] - triangles[t, 0, 0],
        triangles[t, 2, 1] - triangles[t, 0, 1],
        triangles[t, 2, 2] - triangles[t, 0, 2],
    )
    if _separates(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, corners, triangles, t, slack):
        return True
    for c in range(3):
        d = (c + 1) % 3
        ux, uy, uz = (
            triangles[t, d, 0] - triangles[t, c, 0],
            triangles[t, d, 1] - triangles[t, c, 1],
            triangles[t, d, 2] - triangles[t, c, 2],
        )
        for i in range(3):
            for j in range(i + 1, 4):
                vx, vy, vz = (
                    corners[j, 0] - corners[i, 0],
                    corners[j, 1] - corners[i, 1],
                    corners[j, 2] - corners[i, 2],
                )
                if _separates(
                    uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx, corners, triangles, t, slack
                ):
                    return True
    return False


@lean_kernel  # (4, 3) f8, (4, 4) f8, (N, 6) f8, i8, f8 -> bool
def _misses_box(corners, planes, boxes, n, slack):
    """Whether a tetrahedron is apart from a node's box along an axis, or behind one of its own planes."""
    for r in range(3):
        least = min(min(corners[0, r], corners[1, r]), min(corners[2, r], corners[3, r]))
        most = max(max(corners[0, r], corners[1, r]), max(corners[2, r], corners[3, r]))
        if least - boxes[n, 3 + r] > slack or boxes[n, r] - most > slack:
            return True
    for k in range(4):
        low = 0.0
        for r in range(3):
            normal = planes[k, r]
            low += normal * (boxes[n, r] if normal > 0.0 else boxes[n, 3 + r])
        if low - planes[k, 3] > slack:
            return True
    return False


@lean_kernel  # (4, 3) f8, (4, 4) f8, (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, (64,) i8 -> bool
def _is_inside(corners, planes, boxes, children, triangles, stack):
    """Whether a tetrahedron is proven to be inside a solid."""
    slack, top = 0.0, 1
    for r in range(6):
        slack = max(slack, ROUNDING_SHARE * abs(boxes[0, r]))
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        if _misses_box(corners, planes, boxes, n, slack):
            continue
        if children[n, 0] >= 0:
            stack[top], stack[top + 1] = children[n, 0], children[n, 1]
            top += 2
            continue
        first = -1 - children[n, 0]
        for t in range(first, first + children[n, 1]):
            if not _apart(corners, planes, triangles, t, slack):
                return False
    return inside(boxes, children, triangles, corners[0, 0], corners[0, 1], corners[0, 2], stack)


@lean_kernel  # (4, 3) f8, (4, 4) f8, SolidArrays -> bool
def tetrahedron_inside(corners, planes, solid):
    """Whether a tetrahedron is proven to be inside a solid, or inside one group of its components."""
    _write_planes(corners, planes)
    groups, boxes = solid.groups, solid.group_boxes
    if groups.shape[0] == 0:
        return _is_inside(corners, planes, solid.boxes, solid.children, solid.triangles, solid.stack)
    for g in range(groups.shape[0]):
        n, outside = groups[g, 0], False
        for k in range(4):
            for r in range(3):
                outside = outside or corners[k, r] < boxes[n, r] or corners[k, r] > boxes[n, 3 + r]
        if outside:
            continue
        triangles = solid.group_triangles[groups[g, 1] : groups[g, 2]]
        if _is_inside(corners, planes, boxes[n:], solid.group_children[n:], triangles, solid.stack):
            return True
    return False
