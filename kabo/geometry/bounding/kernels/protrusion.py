"""Proofs of how far a convex part sticks out of a solid, by tetrahedra that are each within a limit of one triangle.

The distance to one triangle is convex, so over a tetrahedron it is greatest at a corner. So a part can be proven
even if it reaches the limit exactly, and a large tetrahedron over a large triangle needs one test only.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.bounding.kernels.depth_octree import ALL_NEAR, MIDDLE_FAR, settled
from kabo.geometry.bounding.kernels.inner_tetrahedra import FAR, FOUND, NONE, anchor, tetrahedron_inside
from kabo.geometry.bounding.kernels.union_depth import deepest_squared, in_convex_group
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle
from kabo.geometry.triangles.kernels.triangle_tree import to_triangle_squared

SMALL_TETRAHEDRON_SHARE = 0.1  # of the limit: in smaller ones the corners are tested, too


@lean_kernel  # (C, 26) f8, i8 -> f8 x 4
def _ball(cells, top):
    """The centre of a tetrahedron, and the squared radius of the ball around it that contains the corners."""
    x = 0.25 * (cells[top, 0] + cells[top, 3] + cells[top, 6] + cells[top, 9])
    y = 0.25 * (cells[top, 1] + cells[top, 4] + cells[top, 7] + cells[top, 10])
    z = 0.25 * (cells[top, 2] + cells[top, 5] + cells[top, 8] + cells[top, 11])
    radius = 0.0
    for c in range(4):
        px, py, pz = cells[top, 3 * c] - x, cells[top, 3 * c + 1] - y, cells[top, 3 * c + 2] - z
        radius = max(radius, px * px + py * py + pz * pz)
    return x, y, z, radius


@lean_kernel  # (C, 26) f8, i8, (T, …) f8, i8, f8 -> i8
def _far_corner(cells, top, triangles, triangle, enough):
    """The first corner of a tetrahedron with a squared distance to a triangle of more than `enough`, or -1."""
    for c in range(4):
        px, py, pz = cells[top, 3 * c], cells[top, 3 * c + 1], cells[top, 3 * c + 2]
        if to_triangle_squared(px, py, pz, triangles, triangle) > enough:
            return c
    return -1


@lean_kernel  # (C, 26) f8, i8, i8, f8, SolidArrays -> bool
def _is_beyond(cells, top, corner, enough, solid):
    """Whether a corner is outside, at a squared distance from the solid above `enough`; then it is written to row 0."""
    x, y, z = cells[top, 3 * corner], cells[top, 3 * corner + 1], cells[top, 3 * corner + 2]
    _, near = nearest_triangle(solid.boxes, solid.children, solid.triangles, x, y, z, enough, solid.stack)
    if near >= 0 or inside(solid.boxes, solid.children, solid.triangles, x, y, z, solid.stack):
        return False
    cells[0, 0], cells[0, 1], cells[0, 2] = x, y, z
    return True


@lean_kernel  # (C, 26) f8, i8 -> i8 x 2
def _longest_edge(cells, top):
    """The two corners of a tetrahedron's longest edge."""
    longest, i, j = -1.0, 0, 1
    for a in range(4):
        for b in range(a + 1, 4):
            length = (
                (cells[top, 3 * a] - cells[top, 3 * b]) ** 2
                + (cells[top, 3 * a + 1] - cells[top, 3 * b + 1]) ** 2
                + (cells[top, 3 * a + 2] - cells[top, 3 * b + 2]) ** 2
            )
            if length > longest:
                longest, i, j = length, a, b
    return i, j


@lean_kernel  # (C, W) f8, i8, i8, i8, i8
def _halve(cells, top, i, j, corners):
    """Replaces a cell by its halves, in its row and the next, cut at an edge's midpoint, which has no anchor yet."""
    first = 3 * corners + 2
    for r in range(cells.shape[1]):
        cells[top + 1, r] = cells[top, r]
    for r in range(3):
        middle = 0.5 * (cells[top, 3 * i + r] + cells[top, 3 * j + r])
        cells[top, 3 * i + r], cells[top + 1, 3 * j + r] = middle, middle
        cells[top, first + 3 * i + r], cells[top + 1, first + 3 * j + r] = np.inf, np.inf


@lean_kernel  # (C, W) f8, i8, i8, f8, SolidArrays, Piece -> i8
def _held(cells, top, corners, limit, solid, piece):
    """FOUND if the anchors of a cell's corners prove it near, FAR if a corner is far, which goes to row 0, else NONE."""
    first, known = 3 * corners + 2, True
    for c in range(4):
        own = min(c, corners - 1)  # the last one of a triangle counts twice
        at = first + 3 * own
        if np.isinf(cells[top, at]):
            word = anchor(cells[top, 3 * own : 3 * own + 3], limit, piece.middle, solid, cells[top, at : at + 3])
            if word == FAR:
                for r in range(3):
                    cells[0, r] = cells[top, 3 * own + r]
                return FAR
            if word == NONE:
                cells[top, at] = np.nan
        known = known and not np.isnan(cells[top, at])
        for r in range(3):
            piece.anchors[c, r] = cells[top, at + r]
    return FOUND if known and tetrahedron_inside(piece.anchors, piece.planes, solid) else NONE


@lean_kernel  # (C, 26) f8, i8, f8, SolidArrays, i8, Piece -> i8
def reaches_beyond(cells, top, limit, solid, most, piece):
    """0 if the tetrahedra cells[:top] are proven within `limit` of the solid, 1 if they are not, 2 if undecided.

    A row is four corners, 1 if the tetrahedron is known to be outside, a triangle that may be near, and an anchor for
    each corner: NaN if it has none, inf if it was not asked for yet. A tetrahedron is proven if the octree shows that
    the ball around it is near, if its corners are within the limit of one triangle, if the tetrahedron of the anchors is
    inside the solid, or if its centre is inside and no corner is farther from it than the surface plus the limit.
    Others are halved across their longest edge. A point that is farther than the limit is written to the first three
    columns of row 0.
    """
    triangles = solid.triangles
    enough, small = limit * limit, (SMALL_TETRAHEDRON_SHARE * limit) ** 2
    for _ in range(most):
        if top == 0:
            return 0
        top -= 1
        x, y, z, radius = _ball(cells, top)
        word = settled(x, y, z, np.sqrt(radius), limit, solid)
        if word == ALL_NEAR:
            continue
        if word == MIDDLE_FAR:
            cells[0, 0], cells[0, 1], cells[0, 2] = x, y, z
            return 1
        known = int(cells[top, 13])
        squared = to_triangle_squared(x, y, z, triangles, known)
        squared, t = nearest_triangle(solid.boxes, solid.children, triangles, x, y, z, squared, solid.stack)
        t = t if t >= 0 else known
        cells[top, 13] = t
        far = _far_corner(cells, top, triangles, t, enough)
        if far < 0 or in_convex_group(cells, top, 4, limit, solid):
            continue
        word = _held(cells, top, 4, limit, solid, piece)
        if word == FOUND:
            continue
        if word == FAR:
            return 1
        # The middle of a small one may stay near for ever, however near the corner that is not.
        if radius < small and _is_beyond(cells, top, far, enough, solid):
            return 1
        distance, radius = np.sqrt(squared), np.sqrt(radius)
        if cells[top, 12] == 0.0:
            if inside(solid.boxes, solid.children, solid.triangles, x, y, z, solid.stack):
                if radius <= np.sqrt(deepest_squared(x, y, z, squared, solid)) + limit:
                    continue
            elif distance > min(limit, radius):
                cells[top, 12] = 1.0
        if cells[top, 12] == 1.0 and distance > limit:
            cells[0, 0], cells[0, 1], cells[0, 2] = x, y, z
            return 1
        if top + 2 > cells.shape[0] or radius < 1e-6 * limit:
            return 2
        i, j = _longest_edge(cells, top)
        _halve(cells, top, i, j, 4)
        top += 2
    return 2


@lean_kernel  # (C, 20) f8, i8 -> f8 x 4, i8
def _circle(cells, top):
    """The centre of a triangle, the radius of a ball there that holds the corners, and where its longest edge begins."""
    x = (cells[top, 0] + cells[top, 3] + cells[top, 6]) / 3.0
    y = (cells[top, 1] + cells[top, 4] + cells[top, 7]) / 3.0
    z = (cells[top, 2] + cells[top, 5] + cells[top, 8]) / 3.0
    radius, longest, at = 0.0, -1.0, 0
    for c in range(3):
        d = (c + 1) % 3
        px, py, pz = cells[top, 3 * c], cells[top, 3 * c + 1], cells[top, 3 * c + 2]
        radius = max(radius, (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2)
        length = (cells[top, 3 * d] - px) ** 2 + (cells[top, 3 * d + 1] - py) ** 2
        length += (cells[top, 3 * d + 2] - pz) ** 2
        if length > longest:
            longest, at = length, c
    return x, y, z, np.sqrt(radius), at


@lean_kernel  # (C, 20) f8, i8, f8, SolidArrays, i8, Piece -> i8
def faces_reach_beyond(cells, top, limit, solid, most, piece):
    """0 if the triangles cells[:top] are proven within `limit` of the solid, 1 if they are not, 2 if undecided.

    A row is three corners, then what follows the corners in `reaches_beyond`; as there, a point that is farther than
    the limit is written to the first three columns of row 0.
    """
    triangles, enough = solid.triangles, limit * limit
    for _ in range(most):
        if top == 0:
            return 0
        top -= 1
        x, y, z, radius, at = _circle(cells, top)
        word = settled(x, y, z, radius, limit, solid)
        if word == ALL_NEAR:
            continue
        if word == MIDDLE_FAR:
            cells[0, 0], cells[0, 1], cells[0, 2] = x, y, z
            return 1
        known, within = int(cells[top, 10]), True
        squared = to_triangle_squared(x, y, z, triangles, known)
        squared, t = nearest_triangle(solid.boxes, solid.children, triangles, x, y, z, squared, solid.stack)
        t = t if t >= 0 else known
        cells[top, 10] = t
        for c in range(3):
            px, py, pz = cells[top, 3 * c], cells[top, 3 * c + 1], cells[top, 3 * c + 2]
            within = within and to_triangle_squared(px, py, pz, triangles, t) <= enough
        if within or in_convex_group(cells, top, 3, limit, solid):
            continue
        word = _held(cells, top, 3, limit, solid, piece)
        if word == FOUND:
            continue
        if word == FAR:
            return 1
        distance = np.sqrt(squared)
        if cells[top, 9] == 0.0:
            if inside(solid.boxes, solid.children, solid.triangles, x, y, z, solid.stack):
                if radius <= np.sqrt(deepest_squared(x, y, z, squared, solid)) + limit:
                    continue
            elif distance > min(limit, radius):
                cells[top, 9] = 1.0
        if cells[top, 9] == 1.0 and distance > limit:
            cells[0, 0], cells[0, 1], cells[0, 2] = x, y, z
            return 1
        if top + 2 > cells.shape[0] or radius < 1e-3 * limit:
            return 2
        _halve(cells, top, at, (at + 1) % 3, 3)
        top += 2
    return 2
