"""The configuration check: forward kinematics, boxes of groups, oriented boxes of parts, then separating axes.

Kernels take the fields of `Chain`, `Bodies` and `Scratch` (kabo.geometry.collision.view_arrays) one by one; Python
passes them in one flat array [kabo.geometry.collision.kernels.layout]. A kernel allocates nothing.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.layout import GROUPS_PER_WORD, MARGIN, OFFSET, numbers_of, whole_numbers_of
from kabo.geometry.collision.kernels.oriented_boxes import faces_near, relative
from kabo.geometry.collision.kernels.separation import posed_apart
from kabo.scene.kernels.poses import forward_kinematics

JOINT, PARTS, PAIRS = 0, 1, 2  # rows of `groups`
PARTNER, NUMBER = 0, 1  # rows of `pairs`
CHECKS, POSITIVE = 4, 6  # places of `counters`


@lean_kernel  # (n,) f8, (n,) f8 -> bool
def usable(q, bound):
    """Whether every value of q is finite and its absolute value within its bound; a NaN would invalidate proofs."""
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


@lean_kernel  # (6, 32 W) f8, i8, i8, f8 -> i8
def _near_groups(rows, g, word, margin):
    """The groups among 32 whose boxes are near group g's, a bit for each, in one vectorised pass."""
    x0, y0, z0 = rows[0, g] - margin, rows[1, g] - margin, rows[2, g] - margin
    x1, y1, z1 = rows[3, g] + margin, rows[4, g] + margin, rows[5, g] + margin
    near = np.int64(0)
    for i in range(GROUPS_PER_WORD):
        h = GROUPS_PER_WORD * word + i
        x = (x0 <= rows[3, h]) & (x1 >= rows[0, h])
        y = (y0 <= rows[4, h]) & (y1 >= rows[1, h])
        z = (z0 <= rows[5, h]) & (z1 >= rows[2, h])
        near |= np.int64(x & y & z) << i
    return near


@lean_kernel  # i8 -> i8
def _place_of(bit):
    """The position of a number's only bit, from its exponent as a floating-point number."""
    return (np.float64(bit).view(np.int64) >> 52) - 1023


@lean_kernel  # (3, G+1) i8, (2, P) i8, i8, i8 -> i8
def _number_of(groups, pairs, g, h):
    """The caller's index of the first pair of two groups."""
    p = groups[PAIRS, g]
    while pairs[PARTNER, p] != h:
        p += 1
    return pairs[NUMBER, p]


@lean_kernel
def _all_parts_apart(
    pose, groups, g, h, sizes, offset, margin, part_extents, group_extents, listed, blocks, axis, simplex, counters
):  # fmt: skip
    """Whether all parts of group g are proven apart from all parts of group h, both in the frame of g's joint."""
    count = 0
    for b in range(groups[PARTS, h], groups[PARTS, h + 1]):
        if faces_near(pose, group_extents, g, part_extents, b, margin):
            listed[count] = b
            count += 1
    if count == 0:
        return True
    for a in range(groups[PARTS, g], groups[PARTS, g + 1]):
        if not faces_near(pose, part_extents, a, group_extents, h, margin):
            continue
        for k in range(count):
            b = listed[k]
            if not faces_near(pose, part_extents, a, part_extents, b, margin):
                continue
            x, y, z = part_extents[b, 0], part_extents[b, 1], part_extents[b, 2]
            for r in range(3):
                axis[r] = part_extents[a, r] - (
                    pose[3 * r] * x + pose[3 * r + 1] * y + pose[3 * r + 2] * z + pose[9 + r]
                )
            if not posed_apart(blocks, a, sizes[a], b, sizes[b], pose, margin, offset, axis, simplex, counters):
                return False
    return True


@lean_kernel
def _first_hit(
    q, margin, joints, factors, placement, bound, moving, offset, groups, sizes, part_extents, group_extents, pairs,
    allowed, world_T, rows, pose, listed, blocks, axis, simplex, counters,
):  # fmt: skip
    """The first pair (in the order of groups) not proven apart, -1 if there is none, or -2 if q is invalid."""
    counters[CHECKS] += 1
    if not usable(q, bound):
        return -2
    forward_kinematics(q, joints[0], joints[1], joints[2], factors[0], factors[1], placement, world_T)
    _group_boxes(world_T, moving, groups[JOINT], group_extents, rows)
    for g in range(moving):
        for word in range(allowed.shape[1]):
            near = allowed[g, word]
            if near != 0:
                near &= _near_groups(rows, g, word, margin)
            while near != 0:
                bit = near & -near
                near ^= bit
                h = GROUPS_PER_WORD * word + _place_of(bit)
                relative(world_T, groups[JOINT, g], groups[JOINT, h], pose)
                if faces_near(pose, group_extents, g, group_extents, h, margin) and not _all_parts_apart(
                    pose, groups, g, h, sizes, offset, margin, part_extents, group_extents, listed, blocks, axis,
                    simplex, counters,
                ):  # fmt: skip
                    counters[POSITIVE] += 1
                    return _number_of(groups, pairs, g, h)
    return -1


@lean_kernel  # (n,) f8, (M,) f8 -> i8
def first_hit(q, memory):
    """The index of the first pair, by group, not proven farther apart at q than the margin minus rounding.

    The result is -1 if all pairs are proven apart, and -2 if q is invalid.
    """
    factors, placement, bound, part_extents, group_extents, world_T, rows, pose, axis, simplex, blocks = (
        numbers_of(memory)
    )
    counters, joints, groups, sizes, pairs, allowed, listed = whole_numbers_of(memory)
    return _first_hit(
        q, memory[MARGIN], joints, factors, placement, bound, allowed.shape[0], memory[OFFSET], groups, sizes,
        part_extents, group_extents, pairs, allowed, world_T, rows, pose, listed, blocks, axis, simplex, counters,
    )  # fmt: skip


@lean_kernel
def first_hits(configurations, answers, memory):
    """Writes the result of `first_hit` for each configuration (N, n) to `answers` (N,)."""
    for i in range(configurations.shape[0]):
        answers[i] = first_hit(configurations[i], memory)
