"""Distance to a triangle mesh through a box tree, and winding numbers."""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.triangle_tree import to_box_squared, to_triangle_squared


@lean_kernel  # (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, f8 x 3, f8, (64,) i8 -> f8
def surface_distance(boxes, children, triangles, x, y, z, enough, stack):
    """The distance of a point to the mesh; the search stops at the first distance of at most `enough`.

    A leaf n has children (-1 - first triangle, count).
    """
    best, top = np.inf, 1
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        if to_box_squared(boxes, n, x, y, z) >= best:
            continue
        if children[n, 0] < 0:
            first = -1 - children[n, 0]
            for t in range(first, first + children[n, 1]):
                best = min(best, to_triangle_squared(x, y, z, triangles, t))
            if enough > 0.0 and best <= enough * enough:
                break
        else:
            near, far = children[n, 0], children[n, 1]
            if to_box_squared(boxes, far, x, y, z) < to_box_squared(boxes, near, x, y, z):
                near, far = far, near
            stack[top], stack[top + 1] = far, near
            top += 2
    return np.sqrt(best)


@lean_kernel  # (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, f8 x 3, f8 squared, (64,) i8 -> (f8, i8)
def nearest_triangle(boxes, children, triangles, x, y, z, best, stack):
    """The squared distance to the mesh and the nearest triangle's index; (`best`, -1) if it is not below `best`."""
    found, top = -1, 1
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        if to_box_squared(boxes, n, x, y, z) >= best:
            continue
        if children[n, 0] < 0:
            first = -1 - children[n, 0]
            for t in range(first, first + children[n, 1]):
                distance = to_triangle_squared(x, y, z, triangles, t)
                if distance < best:
                    best, found = distance, t
        else:
            near, far = children[n, 0], children[n, 1]
            if to_box_squared(boxes, far, x, y, z) < to_box_squared(boxes, near, x, y, z):
                near, far = far, near
            stack[top], stack[top + 1] = far, near
            top += 2
    return best, found


@lean_kernel  # (T, 3, 3) f8, f8 x 3 -> f8
def winding_number(triangles, px, py, pz):
    """The winding number of the mesh around a point: the sum of solid angles over 4 pi [van Oosterom 1983]."""
    total = 0.0
    for t in range(triangles.shape[0]):
        ax, ay, az = triangles[t, 0, 0] - px, triangles[t, 0, 1] - py, triangles[t, 0, 2] - pz
        bx, by, bz = triangles[t, 1, 0] - px, triangles[t, 1, 1] - py, triangles[t, 1, 2] - pz
        cx, cy, cz = triangles[t, 2, 0] - px, triangles[t, 2, 1] - py, triangles[t, 2, 2] - pz
        a, b = np.sqrt(ax * ax + ay * ay + az * az), np.sqrt(bx * bx + by * by + bz * bz)
        c = np.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
        total += np.arctan2(volume, a * b * c + ab * c + bc * a + ca * b)
    return total / (2.0 * np.pi)


@lean_kernel  # (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, f8 x 3, (64,) i8 -> bool
def inside(boxes, children, triangles, px, py, pz, stack):
    """Whether the mesh winds around a point that is not on it: signed crossings of a slanted ray upwards.

    If the ray passes too close to an edge, the solid angles decide.
    """
    slant_x, slant_y = 0.06283, 0.04817  # generic, so that the edges of boxes and cylinders are not met
    turns, top = 0, 1
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        up = boxes[n, 5] - pz  # the ray's box below this height contains all that it may meet
        if up < 0.0 or boxes[n, 3] < px or boxes[n, 0] > px + slant_x * up:
            continue
        if boxes[n, 4] < py or boxes[n, 1] > py + slant_y * up:
            continue
        if children[n, 0] >= 0:
            stack[top], stack[top + 1] = children[n, 0], children[n, 1]
            top += 2
            continue
        first = -1 - children[n, 0]
        for t in range(first, first + children[n, 1]):
            sign, size, far = 0, 0.0, 0.0
            for c in range(3):
                d = (c + 1) % 3
                # Sheared so that the ray is the z axis: corners relative to the point.
                az, bz = triangles[t, c, 2] - pz, triangles[t, d, 2] - pz
                ax, ay = triangles[t, c, 0] - px - slant_x * az, triangles[t, c, 1] - py - slant_y * az
                bx, by = triangles[t, d, 0] - px - slant_x * bz, triangles[t, d, 1] - py - slant_y * bz
                area = ax * by - ay * bx
                size = max(size, max(abs(ax), max(abs(ay), max(abs(bx), abs(by)))))
                if abs(area) <= 1e-12 * size * size:
                    return abs(winding_number(triangles, px, py, pz)) > 0.5
                sign += 1 if area > 0.0 else -1
                far += area * (triangles[t, (c + 2) % 3, 2] - pz)
            if sign == 3 and far > 0.0:
                turns += 1
            elif sign == -3 and far < 0.0:
                turns -= 1
    return turns != 0


@lean_kernel  # (N, 3) f8, (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, (64,) i8 -> (N,) f8
def surface_distances(points, boxes, children, triangles, stack, distances):
    """Writes the result of `surface_distance` for many points."""
    for i in range(points.shape[0]):
        distances[i] = surface_distance(
            boxes, children, triangles, points[i, 0], points[i, 1], points[i, 2], 0.0, stack
        )


@lean_kernel  # (N, 3) f8, (N, 6) f8, (N, 2) i8, (T, 3, 3) f8, (64,) i8 -> (N,) bool
def insides(points, boxes, children, triangles, stack, answers):
    """Writes the result of `inside` for many points."""
    for i in range(points.shape[0]):
        answers[i] = inside(boxes, children, triangles, points[i, 0], points[i, 1], points[i, 2], stack)
