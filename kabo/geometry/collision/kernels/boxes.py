"""World vertices and axis-aligned boxes of parts and groups under a pose of 12 numbers."""

import numpy as np

from kabo.compilation import leaf_kernel, lean_kernel, reduction_kernel

BOX_SLACK = 1e-12  # [m] added to boxes against rounding


@reduction_kernel  # (J, 12) f8, i8, (B, 3, K) f8, i8, (D, 3, K) f8, i8, i8
def place_block(poses, pose, blocks, source, placed, target, count):
    """Writes the vertices of block `source`, moved by a pose, to block `target` of `placed`."""
    for r in range(3):
        a, b, c, t = poses[pose, 3 * r], poses[pose, 3 * r + 1], poses[pose, 3 * r + 2], poses[pose, 9 + r]
        for i in range(count):
            x, y, z = blocks[source, 0, i], blocks[source, 1, i], blocks[source, 2, i]
            placed[target, r, i] = a * x + b * y + c * z + t


@lean_kernel  # (J, 12) f8, i8, (G, 6) f8 centre and half extents, i8, (S, 6) f8, i8
def place_box(poses, pose, extents, source, boxes, target):
    """Writes the axis-aligned box (lower, upper) around box `source` moved by a pose."""
    x, y, z = extents[source, 0], extents[source, 1], extents[source, 2]
    ex, ey, ez = extents[source, 3], extents[source, 4], extents[source, 5]
    for r in range(3):
        a, b, c = poses[pose, 3 * r], poses[pose, 3 * r + 1], poses[pose, 3 * r + 2]
        middle = a * x + b * y + c * z + poses[pose, 9 + r]
        half = abs(a) * ex + abs(b) * ey + abs(c) * ez + BOX_SLACK
        boxes[target, r], boxes[target, 3 + r] = middle - half, middle + half


@leaf_kernel  # (S, 6) f8, i8, (S, 6) f8, i8, f8 -> bool
def boxes_near(first, i, second, j, margin):
    """Whether two boxes (lower, upper) are at most `margin` apart along every axis."""
    return (
        (first[i, 0] - margin <= second[j, 3])
        & (second[j, 0] - margin <= first[i, 3])
        & (first[i, 1] - margin <= second[j, 4])
        & (second[j, 1] - margin <= first[i, 4])
        & (first[i, 2] - margin <= second[j, 5])
        & (second[j, 2] - margin <= first[i, 5])
    )


@lean_kernel  # (S, 6) f8, i8, i8, f8, (S, 6) f8, i8
def unite_boxes(boxes, i, j, margin, united, target):
    """Writes the box around two boxes, grown by `margin`."""
    for r in range(3):
        united[target, r] = min(boxes[i, r], boxes[j, r]) - margin
        united[target, 3 + r] = max(boxes[i, 3 + r], boxes[j, 3 + r]) + margin


@lean_kernel  # (S, 6) f8, i8
def _reset(boxes, target):
    for r in range(3):
        boxes[target, r], boxes[target, 3 + r] = np.inf, -np.inf


@lean_kernel  # (S, 6) f8, i8: lower and upper become centre and half extents
def _centre(boxes, target):
    for r in range(3):
        low, high = boxes[target, r], boxes[target, 3 + r]
        boxes[target, r], boxes[target, 3 + r] = 0.5 * (low + high), 0.5 * (high - low) + BOX_SLACK


@lean_kernel  # (B, 3, K) f8, (B,) i8, (G+1,) i8, (G, 12) f8 -> writes (.., 3, K), (B, 6), (G, 6), (G,) f8
def place_groups(packed, sizes, starts, poses, blocks, part_extents, group_extents, radii):
    """Writes the vertices of all parts in their joint's frame, the boxes of parts and groups, and the groups' radii."""
    for g in range(poses.shape[0]):
        _reset(group_extents, g)
        square = 0.0
        for p in range(starts[g], starts[g + 1]):
            place_block(poses, g, packed, p, blocks, p, sizes[p])
            _reset(part_extents, p)
            for i in range(sizes[p]):
                x, y, z = blocks[p, 0, i], blocks[p, 1, i], blocks[p, 2, i]
                square = max(square, x * x + y * y + z * z)
                for r in range(3):
                    part_extents[p, r] = min(part_extents[p, r], blocks[p, r, i])
                    part_extents[p, 3 + r] = max(part_extents[p, 3 + r], blocks[p, r, i])
            for r in range(3):
                group_extents[g, r] = min(group_extents[g, r], part_extents[p, r])
                group_extents[g, 3 + r] = max(group_extents[g, 3 + r], part_extents[p, 3 + r])
            _centre(part_extents, p)
        _centre(group_extents, g)
        radii[g] = np.sqrt(square) * (1.0 + 1e-12)
