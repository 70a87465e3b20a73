"""The configuration check: forward kinematics, boxes of groups, oriented boxes of parts, then separating axes.

Python passes all arrays in one flat array [kabo.geometry.collision.kernels.layout]. A kernel allocates nothing.
"""

import numpy as np

from kabo.compilation import (
    absolute,
    all_four,
    brief_kernel,
    four,
    fused,
    joined_kernel,
    lean_kernel,
    minus,
    near_columns,
    plus,
    sums,
    times,
    window,
)
from kabo.geometry.collision.kernels.boxes import BOX_SLACK, kept_between, place_part
from kabo.geometry.collision.kernels.bundles import (
    BALL_OF_BOX,
    CHECKS,
    DISC_OF_BOX,
    FREE,
    JOINT,
    NUMBER,
    PAIRS,
    PARTNER,
    PARTS,
    POSITIVE,
    ROOTS_END,
    UNUSABLE,
    Chain,
    Checked,
    Hulls,
    Outlines,
    Search,
    Tree,
)
from kabo.geometry.collision.kernels.descent import FINAL, put_children
from kabo.geometry.collision.kernels.first_axis import first_axis
from kabo.geometry.collision.kernels.layout import (
    GROUPS_PER_WORD,
    MARGIN,
    OFFSET,
    numbers_of,
    whole_numbers_of,
)
from kabo.geometry.collision.kernels.oriented_boxes import boxes_near, faces_near, put_pose, relative
from kabo.geometry.collision.kernels.separation import apart, posed_apart
from kabo.geometry.collision.kernels.sines import frames_of

SHORT_SLACK = 4e-7  # of a coordinate, for rounding it and sums with it to 24 bits


@lean_kernel  # (n,) f8, (n,) f8 -> bool
def usable(q, bound):
    """Whether every value of q is finite and its absolute value within its bound; a NaN would invalidate proofs."""
    if q.shape[0] != bound.shape[0]:
        return False
    good = True
    for i in range(bound.shape[0]):
        good = good & (abs(q[i]) <= bound[i])
    return good


@joined_kernel  # (J * 12,) f8, i8, (G,) i8, (G * 8,) f8, (G,) f8 -> writes (6, padded groups) f4
def _group_boxes(frames, moving, joint, boxes, kept, rows):
    """Writes the world boxes of all moving groups as columns of `rows`, grown by what they keep from others.

    They are a little larger, since they are rounded.
    """
    for g in range(moving):
        at = 12 * joint[g]
        x, y, z = four(frames, at), four(frames, at + 4), four(frames, at + 8)
        centre, half = four(boxes, 8 * g), four(boxes, 8 * g + 3)
        centre, half = (centre[0], centre[1], centre[2], 1.0), (half[0], half[1], half[2], 0.0)
        middle = sums(times(x, centre), times(y, centre), times(z, centre))
        reach = sums(times(absolute(x), half), times(absolute(y), half), times(absolute(z), half))
        reach = fused(
            plus(absolute(middle), reach), all_four(SHORT_SLACK), plus(reach, all_four(BOX_SLACK + kept[g]))
        )
        low, high = minus(middle, reach), plus(middle, reach)
        rows[0, g], rows[1, g], rows[2, g] = np.float32(low[0]), np.float32(low[1]), np.float32(low[2])
        rows[3, g], rows[4, g], rows[5, g] = np.float32(high[0]), np.float32(high[1]), np.float32(high[2])


@lean_kernel  # (6, 32 W) f4, i8, i8, f8 -> i8
def _near_groups(rows, g, word, margin):
    """The groups among 32 whose boxes are near group g's, a bit for each, in one vectorised pass of short numbers."""
    short = np.float32(margin)
    x0, y0, z0 = rows[0, g] - short, rows[1, g] - short, rows[2, g] - short
    x1, y1, z1 = rows[3, g] + short, rows[4, g] + short, rows[5, g] + short
    return near_columns(rows, GROUPS_PER_WORD * word, (x0, y0, z0), (x1, y1, z1))


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


@joined_kernel
def _posed_apart(part_extents, hulls, a, b, pose, margin, search):
    """The result of `posed_apart` for parts of any kind; the last row of the hulls is for those with a disc."""
    if not part_extents[a, DISC_OF_BOX] + part_extents[b, DISC_OF_BOX] > 0.0:
        balls = part_extents[a, BALL_OF_BOX] + part_extents[b, BALL_OF_BOX]
        return posed_apart(hulls, a, b, pose, margin, balls, 1, search)
    row = hulls.sizes.shape[0] - 1
    place_part(window(pose, 0, (1, 12)), 0, hulls, b, hulls, row)
    return apart(hulls, a, a, row, row, margin, search)


@lean_kernel
def _descend(a, b, pose, checked, search):
    """FREE if the children of two parts are apart, as fine as need be; 0 if not; FIRST_OPEN - p if p has none yet."""
    outlines, tree, margin = checked.outlines, checked.tree, checked.margin
    top = put_children(tree, a, b, 0)
    while top > 0:
        top -= 1
        a, b = tree.stack[top, 0], tree.stack[top, 1]
        if faces_near(pose, outlines.parts, a, outlines.parts, b, margin):
            first_axis(pose, outlines, a, b, search)
            if not _posed_apart(outlines.parts, checked.hulls, a, b, pose, margin, search):
                top = put_children(tree, a, b, top)
    return FREE if top == 0 else 0 if top == FINAL else top


@joined_kernel
def _parts_hit(g, h, pose, checked, search):
    """FREE if all parts of group g are proven apart from those of h, in the frame of g's joint; else as `_descend`.

    The groups' boxes are near each other. A group's box is that of its root if it has one alone.
    """
    groups, listed, outlines, margin = checked.groups, checked.listed, checked.outlines, checked.margin
    first_a, end_a = groups[PARTS, g], groups[ROOTS_END, g]
    first_b, end_b = groups[PARTS, h], groups[ROOTS_END, h]
    several_a, several_b, near = end_a - first_a > 1, end_b - first_b > 1, 0
    for b in range(first_b, end_b):
        if not several_b or faces_near(pose, outlines.groups, g, outlines.parts, b, margin):
            listed[near] = b
            near += 1
    if near == 0:
        return FREE
    for a in range(first_a, end_a):
        if several_a and not faces_near(pose, outlines.parts, a, outlines.groups, h, margin):
            continue
        for k in range(near):
            b = listed[k]
            if several_a and several_b and not faces_near(pose, outlines.parts, a, outlines.parts, b, margin):
                continue
            first_axis(pose, outlines, a, b, search)
            if not _posed_apart(outlines.parts, checked.hulls, a, b, pose, margin, search):
                found = _descend(a, b, pose, checked, search)
                if found != FREE:
                    return found
    return FREE


@brief_kernel  # (n,) f8, (M,) f8 -> i8
def first_hit(q, memory):
    """The index of the first pair, by group, not proven farther apart at q than the margin minus rounding.

    The result is FREE if all pairs are proven apart, UNUSABLE if q is invalid, and FIRST_OPEN - p or less if part p
    must be divided to decide.
    """
    (
        factors, placement, bound, part_extents, group_extents, boxes, cores, diameters, local, world_T, frames, angles,
        rows, kept, pose, axis, simplex, points, rounds, blocks,
    ) = numbers_of(memory)  # fmt: skip
    counters, joints, groups, sizes, children, stack, pairs, allowed, listed = whole_numbers_of(memory)
    margin, moving = memory[MARGIN], allowed.shape[0]
    outlines, hulls, tree = (
        Outlines(part_extents, group_extents, cores),
        Hulls(blocks, sizes, rounds),
        Tree(children, diameters, stack),
    )
    search = Search(memory[OFFSET], axis, simplex, points, counters)
    counters[CHECKS] += 1
    if not usable(q, bound):
        return UNUSABLE
    frames_of(q, Chain(joints, factors, placement, bound), local, angles, world_T, frames)
    _group_boxes(frames, moving, groups[JOINT], boxes, kept[0], rows)
    for g in range(moving):
        for word in range(allowed.shape[1]):
            near = allowed[g, word]
            if near != 0:
                near &= _near_groups(rows, g, word, margin)
            while near != 0:
                bit = near & -near
                near ^= bit
                h = GROUPS_PER_WORD * word + _place_of(bit)
                placed = relative(frames, groups[JOINT, g], groups[JOINT, h])
                apart_by = margin + kept_between(kept, g, h)
                if boxes_near(placed, boxes, g, h, apart_by):
                    put_pose(placed, pose)
                    checked = Checked(groups, listed, outlines, hulls, tree, apart_by)
                    found = _parts_hit(g, h, pose, checked, search)
                    if found != FREE:
                        counters[POSITIVE] += 1
                        return found if found < FREE else _number_of(groups, pairs, g, h)
    return FREE


@lean_kernel  # (N, n) f8, (N,) i8, (M,) f8 -> i8
def first_hits(configurations, answers, memory):
    """Writes the result of `first_hit` for each configuration; returns how many, up to the first that is not decided."""
    for i in range(configurations.shape[0]):
        answers[i] = first_hit(configurations[i], memory)
        if answers[i] < FREE:
            return i
    return configurations.shape[0]
