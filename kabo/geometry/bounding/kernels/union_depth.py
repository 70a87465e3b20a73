"""How deep a point lies in a solid whose components overlap: as deep as in one group of them, whatever faces lie inside.

To be within a limit of a convex group is decided by corners alone, since the distance to it is a convex function. From
a nearly convex one no point is farther than from its hull by more than the group's error.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle
from kabo.geometry.triangles.kernels.triangle_tree import to_box_squared

CONVEXITY_MARGIN = 1e-8  # of a convex group's planes: several times what its vertices may lie in front of them


@lean_kernel  # f8 x 4, SolidArrays -> f8
def deepest_squared(x, y, z, squared, solid):
    """The greatest squared distance of a point below the surface of a group that it lies in; at least `squared`."""
    groups, boxes = solid.groups, solid.group_boxes
    for g in range(groups.shape[0]):
        n = groups[g, 0]
        room = min(x - boxes[n, 0], boxes[n, 3] - x)
        room = min(room, min(y - boxes[n, 1], boxes[n, 4] - y))
        room = min(room, min(z - boxes[n, 2], boxes[n, 5] - z))
        if room <= 0.0 or room * room <= squared:
            continue
        own, children = boxes[n:], solid.group_children[n:]
        triangles = solid.group_triangles[groups[g, 1] : groups[g, 2]]
        if inside(own, children, triangles, x, y, z, solid.stack):
            depth, _ = nearest_triangle(own, children, triangles, x, y, z, np.inf, solid.stack)
            squared = max(squared, max(np.sqrt(depth) - CONVEXITY_MARGIN, 0.0) ** 2)
    return squared


@lean_kernel  # (C, W) f8, i8, i8, f8, SolidArrays -> bool
def in_convex_group(cells, top, corners, limit, solid):
    """Whether the corners of a cell, the first columns of its row, prove it within `limit` of one nearly convex group."""
    groups, boxes = solid.groups, solid.group_boxes
    for g in range(groups.shape[0]):
        room = limit - CONVEXITY_MARGIN - solid.group_errors[g]
        if not room > 0.0:
            continue
        n, within, enough = groups[g, 0], True, room * room
        for c in range(corners):
            x, y, z = cells[top, 3 * c], cells[top, 3 * c + 1], cells[top, 3 * c + 2]
            within = within and to_box_squared(boxes, n, x, y, z) <= enough
        if not within:
            continue
        own, children = boxes[n:], solid.group_children[n:]
        triangles = solid.group_triangles[groups[g, 1] : groups[g, 2]]
        for c in range(corners):
            x, y, z = cells[top, 3 * c], cells[top, 3 * c + 1], cells[top, 3 * c + 2]
            _, near = nearest_triangle(own, children, triangles, x, y, z, enough, solid.stack)
            if near < 0 and not inside(own, children, triangles, x, y, z, solid.stack):
                within = False
                break
        if within:
            return True
    return False
