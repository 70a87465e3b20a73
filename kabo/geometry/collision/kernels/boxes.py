"""World vertices and axis-aligned boxes of parts and groups under a pose of 12 numbers."""

import numpy as np

from kabo.compilation import leaf_kernel, lean_kernel
from kabo.geometry.collision.kernels.bundles import AXIS, BALL_OF_BOX, DISC, DISC_OF_BOX, PARTS, RADIUS, ROOTS_END

BOX_SLACK = 1e-12  # [m] added to boxes against rounding


@lean_kernel  # (J, 12) f8, i8, Hulls, i8, Hulls, i8
def place_part(poses, pose, hulls, source, placed, target):
    """Writes part `source`, moved by a pose, to row `target` of `placed`."""
    count = hulls.sizes[source]
    for r in range(3):
        a, b, c, t = poses[pose, 3 * r], poses[pose, 3 * r + 1], poses[pose, 3 * r + 2], poses[pose, 9 + r]
        for i in range(count):
            x, y, z = hulls.blocks[source, 0, i], hulls.blocks[source, 1, i], hulls.blocks[source, 2, i]
            placed.blocks[target, r, i] = a * x + b * y + c * z + t
    placed.sizes[target] = count
    place_rounding(poses, pose, hulls.rounds, source, placed.rounds, target)


@lean_kernel  # (J, 12) f8, i8, (B, 5) f8, i8, (D, 5) f8, i8
def place_rounding(poses, pose, rounds, source, placed, target):
    """Writes a part's rounding, whose axis turns with the pose."""
    placed[target, RADIUS], placed[target, DISC] = rounds[source, RADIUS], rounds[source, DISC]
    if rounds[source, DISC] > 0.0:
        x, y, z = rounds[source, AXIS], rounds[source, AXIS + 1], rounds[source, AXIS + 2]
        for r in range(3):
            placed[target, AXIS + r] = (
                poses[pose, 3 * r] * x + poses[pose, 3 * r + 1] * y + poses[pose, 3 * r + 2] * z
            )


@lean_kernel  # (B, 5) f8, i8, i8 -> f8
def rounding_along(rounds, row, axis):
    """How far a part's ball and disc reach along a coordinate axis."""
    if not rounds[row, DISC] > 0.0:
        return rounds[row, RADIUS]
    y, z = rounds[row, AXIS + (axis + 1) % 3], rounds[row, AXIS + (axis + 2) % 3]
    return rounds[row, RADIUS] + rounds[row, DISC] * np.sqrt(y * y + z * z)


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


@lean_kernel  # (B, 9) f8, (B,) i8, (G, 12) f8, i8, i8 -> writes (B, 9) f8
def place_cores(source, owner, poses, first, end, cores):
    """Writes the cores of parts `first` to `end` - 1 at the poses of their groups: means are moved, spreads are turned."""
    for p in range(first, end):
        g, spread = owner[p], source[p]
        for r in range(3):
            a, b, c = poses[g, 3 * r], poses[g, 3 * r + 1], poses[g, 3 * r + 2]
            cores[p, r] = a * spread[0] + b * spread[1] + c * spread[2] + poses[g, 9 + r]
            x = a * spread[3] + b * spread[4] + c * spread[5]
            y = a * spread[4] + b * spread[6] + c * spread[7]
            z = a * spread[5] + b * spread[7] + c * spread[8]
            for s in range(r, 3):  # of rows 0, 1, 2 the places 3, 6 and 8 are the first
                at = (3, 5, 6)[r] + s
                cores[p, at] = x * poses[g, 3 * s] + y * poses[g, 3 * s + 1] + z * poses[g, 3 * s + 2]


@lean_kernel  # Hulls, (4, G+1) i8, (G, 12) f8 -> writes Hulls, Extents, (G, 2) f8
def place_groups(packed, groups, poses, hulls, extents, radii):
    """Writes all parts in their joint's frame, the boxes of parts and groups, and how far groups reach from its origin.

    `radii`: of the corners with their discs; with the balls as well. Groups are as large as their roots.
    """
    for g in range(poses.shape[0]):
        _reset(extents.groups, g)
        radii[g, 0], radii[g, 1] = 0.0, 0.0
        for p in range(groups[PARTS, g], groups[PARTS, g + 1]):
            place_part(poses, g, packed, p, hulls, p)
            _reset(extents.parts, p)
            square = 0.0
            for i in range(hulls.sizes[p]):
                x, y, z = hulls.blocks[p, 0, i], hulls.blocks[p, 1, i], hulls.blocks[p, 2, i]
                square = max(square, x * x + y * y + z * z)
                for r in range(3):
                    extents.parts[p, r] = min(extents.parts[p, r], hulls.blocks[p, r, i])
                    extents.parts[p, 3 + r] = max(extents.parts[p, 3 + r], hulls.blocks[p, r, i])
            for r in range(3):
                extents.parts[p, r] -= rounding_along(hulls.rounds, p, r)
                extents.parts[p, 3 + r] += rounding_along(hulls.rounds, p, r)
            extents.parts[p, BALL_OF_BOX], extents.parts[p, DISC_OF_BOX] = (
                hulls.rounds[p, RADIUS],
                hulls.rounds[p, DISC],
            )
            if p < groups[ROOTS_END, g]:
                for r in range(3):
                    extents.groups[g, r] = min(extents.groups[g, r], extents.parts[p, r])
                    extents.groups[g, 3 + r] = max(extents.groups[g, 3 + r], extents.parts[p, 3 + r])
                reach = np.sqrt(square) * (1.0 + 1e-12) + hulls.rounds[p, DISC]
                radii[g, 0] = max(radii[g, 0], reach)
                radii[g, 1] = max(radii[g, 1], reach + hulls.rounds[p, RADIUS])
            _centre(extents.parts, p)
        _centre(extents.groups, g)


@leaf_kernel  # (2, G) f8, i8, i8 -> f8
def kept_between(kept, g, h):
    """What two groups keep from each other beyond the margin [m]: nothing if they are of the same hand."""
    same = (kept[1, g] == kept[1, h]) & (kept[1, g] > 0.0)
    return 0.0 if same else kept[0, g] + kept[0, h]
