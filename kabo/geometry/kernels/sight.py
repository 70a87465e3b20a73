"""Lines of sight inside a solid: whether the straight line between two of its points stays near it."""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.kernels.protrusion import nearest_triangle
from kabo.geometry.kernels.solids import inside


@lean_kernel  # (N, 3) f8, f8 [m], tree, (64,) i8 -> (N, N) i8
def blocked_pairs(points, limit, boxes, children, triangles, stack, blocked):
    """Which pairs of points cannot see each other: their line leaves the solid by more than `limit` somewhere.

    It walks in steps that the distance to the surface allows, at least a quarter of the limit: a guide, no proof.
    """
    for i in range(points.shape[0]):
        blocked[i, i] = 0
        for j in range(i):
            dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            length = np.sqrt(dx * dx + dy * dy + dz * dz)
            at, seen = limit, 0
            while at < length - limit:
                s = at / length
                x, y, z = points[i, 0] + s * dx, points[i, 1] + s * dy, points[i, 2] + s * dz
                squared, _ = nearest_triangle(boxes, children, triangles, x, y, z, np.inf, stack)
                distance = np.sqrt(squared)
                if inside(boxes, children, triangles, x, y, z, stack):
                    at += distance + limit
                elif distance > limit:
                    seen = 1
                    break
                else:
                    at += max(limit - distance, 0.25 * limit)
            blocked[i, j], blocked[j, i] = seen, seen
