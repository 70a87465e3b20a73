"""Proofs that rows hold throughout a joint-linear segment, by bisection with a second-order bound.

The value of a row is a function of one vector y (`relative`): the first's point, or direction, seen from the second's
frame. On a piece of length w of the segment, y stays within c w^2 / 8 of its chord, c >= max |y''|. As for
sweeps [docs/decisions/001-kernels.md]: along the chain from the second's frame to the first's, the second derivative by
q_i and q_j, i before j, is at most r_j (the distance of the point from axis j) if i turns, 0 if i slides.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.rows import ALIGNED, DIRECTION, FIRST, KIND, SECOND, holds_between, relative
from kabo.scene.kernels.poses import forward_kinematics

MAX_DEPTH = 24  # halvings of the segment: rows undecided on pieces of 2^-24 count as violated,
MAX_PIECES = 20000  # and so do rows that need more pieces


class Pieces(NamedTuple):
    """The scratch arrays of `first_row_not_kept`."""

    world_T: Array  # (J, 12)  # noqa: N815
    q: Array  # (n,)
    bound: Array  # (R,)
    ends: Array  # (MAX_DEPTH + 2,)
    vectors: Array  # (MAX_DEPTH + 2, R, 3)


@lean_kernel  # (J,) i8, i8, i8 -> i8
def common_ancestor(parent, a, b):
    """The nearest common ancestor of joints a and b; parents have lower indices than their children."""
    while a != b:
        if a > b:
            a = parent[a]
        else:
            b = parent[b]
    return a


@lean_kernel  # i8, KinematicTree, (n,) f8 x 2 -> f8, f8
def change_and_reach(j, tree, q0, q1):
    """The total motion of joint j on the segment, and the greatest distance of its origin from its parent's origin [m]."""
    source, ratio, shift, placement = tree.source, tree.ratio, tree.shift, tree.placement
    start, end = ratio[j] * q0[source[j]], ratio[j] * q1[source[j]]
    x, y, z = placement[j, 9], placement[j, 10], placement[j, 11]
    reach = np.sqrt(x * x + y * y + z * z)
    if tree.kind[j] != 0:
        reach += max(abs(start + shift[j]), abs(end + shift[j]))
    return abs(end - start), reach


@lean_kernel  # (W,) f8, KinematicTree, (n,) f8 x 2 -> f8
def curvature(row, tree, q0, q1):
    """The bound c of |y''| over the whole segment, where y is a point [m], or a direction for kinds from DIRECTION on."""
    parent, kind = tree.parent, tree.kind
    a, b = int(row[FIRST]), int(row[SECOND])
    if row[KIND] == ALIGNED:  # the direction of the second, seen from the first
        a, b = b, a
    top = common_ancestor(parent, a, b)
    position = row[KIND] < DIRECTION
    # a's branch, from the point upwards: each pair of joints counts once, with r of the one nearer to the point.
    distance = 1.0
    if position:
        distance = np.sqrt(row[2] * row[2] + row[3] * row[3] + row[4] * row[4])
    total, weighted = 0.0, 0.0  # weighted: the sum over joints nearer to the point of 2 r |dq|
    j = a
    while j != top:
        change, reach = change_and_reach(j, tree, q0, q1)
        if kind[j] == 0:
            total += change * (distance * change + weighted)
            weighted += 2.0 * distance * change
        elif position:
            weighted += 2.0 * change
        distance += reach if position else 0.0
        j = parent[j]
    # b's branch, seen from b: its joints come first in the chain, so the lengths beyond them are known only now.
    length = distance
    j = b
    while j != top:
        change, reach = change_and_reach(j, tree, q0, q1)
        length += reach if position else 0.0
        j = parent[j]
    rest, angles = length, 0.0  # how far the point can be from joint j; the turns of the joints before it
    j = b
    while j != top:
        change, reach = change_and_reach(j, tree, q0, q1)
        if kind[j] == 0:
            total += rest * change * (change + 2.0 * angles) + change * weighted
            angles += change
        elif position:
            total += 2.0 * change * angles
        rest -= reach if position else 0.0
        j = parent[j]
    return total


@lean_kernel  # (n,) f8 x 2, f8, (R, W) f8, KinematicTree, (n,) f8, (J, 12) f8, (R, 3) f8 -> writes q, world_T, vectors
def look(q0, q1, share, rows, tree, q, world_T, vectors):
    """Writes the vector that `relative` computes for every row, at the fraction `share` of the segment."""
    for j in range(q.shape[0]):
        q[j] = q0[j] if share == 0.0 else q1[j] if share == 1.0 else q0[j] + share * (q1[j] - q0[j])
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
    for i in range(rows.shape[0]):
        relative(rows[i], world_T, vectors[i])


@kernel  # i8, i8, i8 -> Pieces
def pieces_of(rows, joints, size):
    """Allocates the scratch arrays of `first_row_not_kept` for the given numbers of rows, joints and values of q."""
    world_T = np.zeros((joints, 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    vectors = np.empty((MAX_DEPTH + 2, rows, 3))
    return Pieces(world_T, np.empty(size), np.empty(rows), np.zeros(MAX_DEPTH + 2), vectors)


@lean_kernel  # (R, W) f8, (R,) f8, (n,) f8 x 2, KinematicTree, Pieces -> i8
def first_row_not_kept(rows, tolerances, q0, q1, tree, pieces):
    """-1 if all rows are proven to hold within tolerance along the segment, else the index of an unproven row."""
    count = rows.shape[0]
    world_T, q, bound, ends, vectors = pieces
    for i in range(count):
        bound[i] = curvature(rows[i], tree, q0, q1) / 8.0
    # vectors[0] belongs to the left end of what is left to prove, above it lie right ends, the nearest on top.
    ends[0] = 0.0
    look(q0, q1, 0.0, rows, tree, q, world_T, vectors[0])
    look(q0, q1, 1.0, rows, tree, q, world_T, vectors[1])
    ends[1], top, doubtful = 1.0, 1, -1
    for _ in range(MAX_PIECES):
        if top == 0:
            return -1
        width = ends[top] - ends[0]
        doubtful = -1
        for i in range(count):
            # First the whole piece; if that is doubtful, its right end: one pose that violates a row ends it all.
            for deviation in (bound[i] * width * width, 0.0):
                left = 0 if deviation > 0.0 else top
                if holds_between(rows[i], vectors[left, i], vectors[top, i], deviation, tolerances[i]):
                    break
                doubtful = i
                if deviation == 0.0:
                    return i
        if doubtful < 0:
            ends[0] = ends[top]
            for i in range(count):
                for k in range(3):
                    vectors[0, i, k] = vectors[top, i, k]
            top -= 1
            continue
        if width <= 0.5**MAX_DEPTH:
            return doubtful
        top += 1
        ends[top], ends[top - 1] = ends[0] + 0.5 * width, ends[top - 1]
        look(q0, q1, ends[top], rows, tree, q, world_T, vectors[top])
    return doubtful
