"""Lines of sight inside a solid: tests whether the segment between two points of a solid stays near the solid."""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.solids import inside, nearest_triangle


@lean_kernel  # (6,) f8, (N, 6) f8, i8 -> bool
def _meets_box(line, boxes, n):
    """Whether the line (start, step) passes box n between 0 and 1."""
    low, high = 0.0, 1.0
    for r in range(3):
        if line[3 + r] == 0.0:
            if line[r] < boxes[n, r] or line[r] > boxes[n, 3 + r]:
                return False
        else:
            first, last = (boxes[n, r] - line[r]) / line[3 + r], (boxes[n, 3 + r] - line[r]) / line[3 + r]
            low, high = max(low, min(first, last)), min(high, max(first, last))
    return low <= high * (1.0 + 1e-9) + 1e-9


@lean_kernel  # (6,) f8, (T, 3, 3) f8, i8 -> f8
def _crossing(line, triangles, t):
    """Where the line (start, step) crosses triangle t, as a share of the step; -1 if nowhere [Moeller 1997]."""
    dx, dy, dz = line[3], line[4], line[5]
    ax, ay, az = triangles[t, 0, 0], triangles[t, 0, 1], triangles[t, 0, 2]
    ux, uy, uz = triangles[t, 1, 0] - ax, triangles[t, 1, 1] - ay, triangles[t, 1, 2] - az
    vx, vy, vz = triangles[t, 2, 0] - ax, triangles[t, 2, 1] - ay, triangles[t, 2, 2] - az
    px, py, pz = dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx
    volume = ux * px + uy * py + uz * pz
    if volume == 0.0:
        return -1.0
    sx, sy, sz = line[0] - ax, line[1] - ay, line[2] - az
    first = (sx * px + sy * py + sz * pz) / volume
    if not -1e-9 <= first <= 1.0 + 1e-9:
        return -1.0
    qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
    second = (dx * qx + dy * qy + dz * qz) / volume
    if not (second >= -1e-9 and first + second <= 1.0 + 1e-9):
        return -1.0
    return (vx * qx + vy * qy + vz * qz) / volume


@lean_kernel  # (6,) f8, tree, (64,) i8, (M,) f8 -> i8
def _crossings(line, boxes, children, triangles, stack, at):
    """Writes where the line crosses the surface between 0 and 1, in order; returns their number, at most M - 2."""
    count, top = 0, 1
    stack[0] = 0
    while top > 0:
        top -= 1
        n = stack[top]
        if not _meets_box(line, boxes, n):
            continue
        if children[n, 0] >= 0:
            stack[top], stack[top + 1] = children[n, 0], children[n, 1]
            top += 2
            continue
        first = -1 - children[n, 0]
        for t in range(first, first + children[n, 1]):
            where = _crossing(line, triangles, t)
            if 0.0 < where < 1.0 and count < at.shape[0] - 2:
                i = count
                while i > 0 and at[i - 1] > where:
                    at[i] = at[i - 1]
                    i -= 1
                at[i] = where
                count += 1
    return count


@lean_kernel  # (6,) f8, f8 [m], f8, f8, f8 [m], tree, (64,) i8 -> bool
def _leaves(line, length, low, high, limit, boxes, children, triangles, stack):
    """Whether a piece of the line between crossings is outside, and somewhere farther from the solid than the limit."""
    middle = 0.5 * (low + high)
    x, y, z = line[0] + middle * line[3], line[1] + middle * line[4], line[2] + middle * line[5]
    if inside(boxes, children, triangles, x, y, z, stack):
        return False
    at, end = low * length + limit, high * length - limit
    while at < end:
        s = at / length
        x, y, z = line[0] + s * line[3], line[1] + s * line[4], line[2] + s * line[5]
        squared, near = nearest_triangle(boxes, children, triangles, x, y, z, limit * limit, stack)
        if near < 0:
            return True
        at += max(limit - np.sqrt(squared), 0.25 * limit)
    return False


@lean_kernel  # (3,) f8, (N, 3) f8, tree, (64,) i8, (6,) f8, (M,) f8 -> (N,) f8
def first_crossings(point, steps, boxes, children, triangles, stack, line, at, shares):
    """Writes for each step from a point the fraction at which it first meets the surface; 1 if it never does."""
    for i in range(steps.shape[0]):
        for r in range(3):
            line[r], line[3 + r] = point[r], steps[i, r]
        count = _crossings(line, boxes, children, triangles, stack, at)
        shares[i] = at[0] if count > 0 else 1.0


@lean_kernel  # (N, 3) f8, f8 [m], tree, (64,) i8, (6,) f8, (M,) f8 -> (N, N) i8
def blocked_pairs(points, limit, boxes, children, triangles, stack, line, at, blocked):
    """Writes which pairs of points are blocked, that is, joined by a segment that leaves the solid by more than `limit`.

    Only a piece between two crossings more than twice the limit apart can leave so far. Such pieces outside the
    solid are sampled in steps adapted to the distance from the surface, so the result is a heuristic, not a proof.
    """
    for i in range(points.shape[0]):
        blocked[i, i] = 0
        for j in range(i):
            squared = 0.0
            for r in range(3):
                line[r], line[3 + r] = points[i, r], points[j, r] - points[i, r]
                squared += line[3 + r] ** 2
            length, seen = np.sqrt(squared), 0
            if length > 2.0 * limit:
                count = _crossings(line, boxes, children, triangles, stack, at)
                at[count], low = 1.0, 0.0
                for k in range(count + 1):
                    if (at[k] - low) * length > 2.0 * limit and _leaves(
                        line, length, low, at[k], limit, boxes, children, triangles, stack
                    ):
                        seen = 1
                        break
                    low = at[k]
            blocked[i, j], blocked[j, i] = seen, seen
