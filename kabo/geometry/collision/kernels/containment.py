"""Proofs that convex parts lie inside a solid: apart from its whole surface, with one vertex inside.

A part is connected, so if no triangle of the closed surface meets it, all of it is on one side. This is proven by
an axis for each near triangle; the side follows from the winding number of one vertex, which is then farther from
the surface than `margin`.
"""

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import AXIS, DISC, RADIUS
from kabo.geometry.collision.kernels.separation import apart
from kabo.geometry.triangles.kernels.solids import winding_number

TRIANGLE_COLUMNS = 8  # of a triangle's block: its corners, and copies of the first one


@lean_kernel
def _surface_apart(hulls, part, box, margin, surface, pool, search):
    """Whether a surface is proven farther than `margin` from a part, which is copied to row 0 of the pool."""
    boxes, children, triangles, stack = surface.boxes, surface.children, surface.triangles, surface.stack
    pool.sizes[0], pool.sizes[1] = hulls.sizes[part], TRIANGLE_COLUMNS
    pool.rounds[1, RADIUS], pool.rounds[1, DISC] = 0.0, 0.0
    for k in range(AXIS + 3):
        pool.rounds[0, k] = hulls.rounds[part, k]
    for r in range(3):
        for i in range(hulls.sizes[part]):
            pool.blocks[0, r, i] = hulls.blocks[part, r, i]
    top = 1
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        meet = True
        for r in range(3):
            meet = meet and boxes[n, r] - margin <= box[part, 3 + r] and box[part, r] <= boxes[n, 3 + r] + margin
        if not meet:
            continue
        if children[n, 0] >= 0:
            stack[top], stack[top + 1] = children[n, 0], children[n, 1]
            top += 2
            continue
        first = -1 - children[n, 0]
        for t in range(first, first + children[n, 1]):
            for r in range(3):
                middle = (triangles[t, 0, r] + triangles[t, 1, r] + triangles[t, 2, r]) / 3.0
                search.axis[r] = 0.5 * (box[part, r] + box[part, 3 + r]) - middle
                for i in range(TRIANGLE_COLUMNS):
                    pool.blocks[1, r, i] = triangles[t, i if i < 3 else 0, r]
            if not apart(pool, 0, 0, 1, 1, margin, search):
                return False
    return True


@lean_kernel
def first_outside(hulls, box, margin, surface, pool, search):
    """The index of the first part, with boxes (B, 6), that is not proven inside the solid, or -1 if all are."""
    for part in range(box.shape[0]):
        if not _surface_apart(hulls, part, box, margin, surface, pool, search):
            return part
        turns = winding_number(
            surface.triangles, hulls.blocks[part, 0, 0], hulls.blocks[part, 1, 0], hulls.blocks[part, 2, 0]
        )
        if not abs(turns) > 0.5:
            return part
    return -1
