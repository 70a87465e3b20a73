"""The configuration check: forward kinematics, boxes of groups, boxes of parts, then separating axes.

The arguments are the fields of `Chain`, `Bodies` and `Scratch` (kabo.geometry.arrays says what they are), one by one,
because unpacking tuples costs more than a check. A kernel allocates nothing.
"""

from kabo.compilation import lean_kernel
from kabo.geometry.kernels.boxes import boxes_near, place_block, place_box
from kabo.geometry.kernels.separation import apart
from kabo.scene.kernels.poses import forward_kinematics

JOINT, PARTS, PAIRS = 0, 1, 2  # rows of `groups`
PARTNER, NUMBER = 0, 1  # rows of `pairs`


@lean_kernel  # (n,) f8, (n,) f8 -> bool
def usable(q, bound):
    """Whether every value is finite and within its bound: a NaN must not reach a proof."""
    good = q.shape[0] == bound.shape[0]
    for i in range(bound.shape[0]):
        good = good and abs(q[i]) <= bound[i]
    return good


@lean_kernel  # (J, 12) f8, i8, (G,) i8, (G, 6) f8 -> writes (6, padded groups) f8
def _group_boxes(world_T, moving, joint, group_extents, rows):
    """Writes the world boxes of all moving groups as columns of `rows`."""
    for g in range(moving):
        j = joint[g]
        x, y, z = group_extents[g, 0], group_extents[g, 1], group_extents[g, 2]
        ex, ey, ez = group_extents[g, 3], group_extents[g, 4], group_extents[g, 5]
        for r in range(3):
            a, b, c = world_T[j, 3 * r], world_T[j, 3 * r + 1], world_T[j, 3 * r + 2]
            middle = a * x + b * y + c * z + world_T[j, 9 + r]
            half = abs(a) * ex + abs(b) * ey + abs(c) * ez + 1e-12
            rows[r, g], rows[3 + r, g] = middle - half, middle + half


@lean_kernel  # (6, padded groups) f8, i8, f8 -> writes (padded groups,) bool
def _near_groups(rows, g, margin, near):
    """Marks the groups whose boxes are near group g's: one vectorised pass over all."""
    x0, y0, z0 = rows[0, g] - margin, rows[1, g] - margin, rows[2, g] - margin
    x1, y1, z1 = rows[3, g] + margin, rows[4, g] + margin, rows[5, g] + margin
    for h in range(near.shape[0]):
        x = (x0 <= rows[3, h]) & (x1 >= rows[0, h])
        y = (y0 <= rows[4, h]) & (y1 >= rows[1, h])
        z = (z0 <= rows[5, h]) & (z1 >= rows[2, h])
        near[h] = x & y & z


@lean_kernel
def _part_boxes(world_T, groups, g, part_extents, part_boxes, placed):
    """Writes the world boxes of the parts of a group; their vertices are not placed yet."""
    for p in range(groups[PARTS, g], groups[PARTS, g + 1]):
        place_box(world_T, groups[JOINT, g], part_extents, p, part_boxes, p)
        placed[p] = 0


@lean_kernel
def _world_block(world_T, j, blocks, p, size, placed):
    """The block with the part's vertices in the world, made on first use; fixed parts lie there already."""
    if j == 0:
        return p
    target = placed.shape[0] + p
    if placed[p] == 0:
        placed[p] = 1
        place_block(world_T, j, blocks, p, blocks, target, size)
    return target


@lean_kernel
def _all_parts_apart(
    world_T, groups, g, h, sizes, offset, margin, part_boxes, placed, blocks, axis, simplex, counters
):  # fmt: skip
    """Whether all parts of group g are proven apart from all parts of group h."""
    for a in range(groups[PARTS, g], groups[PARTS, g + 1]):
        for b in range(groups[PARTS, h], groups[PARTS, h + 1]):
            if boxes_near(part_boxes, a, part_boxes, b, margin):
                u = _world_block(world_T, groups[JOINT, g], blocks, a, sizes[a], placed)
                v = _world_block(world_T, groups[JOINT, h], blocks, b, sizes[b], placed)
                for r in range(3):
                    axis[r] = part_boxes[a, r] + part_boxes[a, 3 + r] - part_boxes[b, r] - part_boxes[b, 3 + r]
                if not apart(blocks, u, u, sizes[a], v, v, sizes[b], margin, offset, axis, simplex, counters):
                    return False
    return True


@lean_kernel
def first_hit(
    q, margin, joints, factors, placement, bound, moving, offset, groups, sizes, part_extents, group_extents, pairs,
    world_T, rows, near, boxed, placed, part_boxes, blocks, axis, simplex, counters,
):  # fmt: skip
    """The first pair (in the order of groups) not proven farther apart than `margin` minus rounding.

    -1 if all are proven apart, -2 if q is not usable.
    """
    if not usable(q, bound):
        return -2
    forward_kinematics(q, joints[0], joints[1], joints[2], factors[0], factors[1], placement, world_T)
    _group_boxes(world_T, moving, groups[JOINT], group_extents, rows)
    for g in range(moving):
        boxed[g] = 0
    for g in range(moving):
        if groups[PAIRS, g] < groups[PAIRS, g + 1]:
            _near_groups(rows, g, margin, near)
        for p in range(groups[PAIRS, g], groups[PAIRS, g + 1]):
            h = pairs[PARTNER, p]
            if not near[h]:
                continue
            for member in (g, h):
                if boxed[member] == 0 and member < moving:
                    boxed[member] = 1
                    _part_boxes(world_T, groups, member, part_extents, part_boxes, placed)
            if not _all_parts_apart(
                world_T, groups, g, h, sizes, offset, margin, part_boxes, placed, blocks, axis, simplex, counters
            ):
                return pairs[NUMBER, p]
    return -1


@lean_kernel
def first_hits(
    configurations, answers, margin, joints, factors, placement, bound, moving, offset, groups, sizes, part_extents,
    group_extents, pairs, world_T, rows, near, boxed, placed, part_boxes, blocks, axis, simplex, counters,
):  # fmt: skip
    """`first_hit` of many configurations (N, n), written to `answers` (N,)."""
    for i in range(configurations.shape[0]):
        answers[i] = first_hit(
            configurations[i], margin, joints, factors, placement, bound, moving, offset, groups, sizes, part_extents,
            group_extents, pairs, world_T, rows, near, boxed, placed, part_boxes, blocks, axis, simplex, counters,
        )  # fmt: skip
