"""Comparison of two swept volumes, whatever the times [K Def. 1.3]; a fixed body's swept volume is the body itself.

Unlike in `sweep`, where two bodies move in step, every interval of one motion is compared with every interval of
the other. Both answers are proven as in `sweep`; how far a hull of two poses sticks out of the volume swept
between them is bounded by their own rotations, |R0 - R1| diameter / 4, and by the angle that the joints turn.

A body is given by its joint's poses (N + 1, 12) at the nodes of N = 2^level intervals, its parts (blocks, sizes,
extents, all in the joint's frame) and, for each part, bounds (B, 3) over all intervals together: deviation, angle *
diameter / 4, diameter / 4.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.boxes import boxes_near, place_block, place_box, unite_boxes
from kabo.geometry.collision.kernels.separation import apart
from kabo.geometry.collision.kernels.tracks import motion
from kabo.scene.kernels.poses import forward_kinematics

APART, MEET, FINER = 0, 1, 2  # the answers; FINER: undecided without more nodes
COARSE_DEVIATION = 0.03  # [m]: hulls that deviate more are halved without a comparison
DEVIATION, TURN, QUARTER = 0, 1, 2  # columns of bounds


@lean_kernel  # (3, n) f8, (3, J) i8, (2, J) f8, (J,) f8, (J,) f8, i8, (B,) f8, (B,) f8 -> writes (B, 3) f8
def part_bounds(segment, joints, factors, lengths, turned, joint, radii, diameters, bounds):
    """Writes for every part of a body its three bounds over a whole segment: deviation and both shares of the spread."""
    for p in range(radii.shape[0]):
        deviation, angle, _ = motion(segment, joints, factors, lengths, turned, joint, 0, radii[p])
        bounds[p, DEVIATION] = deviation
        bounds[p, TURN], bounds[p, QUARTER] = 0.25 * angle * diameters[p], 0.25 * diameters[p]


@lean_kernel  # (3, n) f8, (3, J) i8, (2, J) f8, (J, 12) f8 -> writes (N + 1, J, 12) f8, whose rows [:, 0] are given
def frames_on(segment, joints, factors, placement, frames):
    """Writes the frames of all joints at the nodes of a segment."""
    intervals = frames.shape[0] - 1
    for node in range(intervals + 1):
        for i in range(segment.shape[1]):
            segment[2, i] = segment[0, i] + (node / intervals) * (segment[1, i] - segment[0, i])
        forward_kinematics(
            segment[2], joints[0], joints[1], joints[2], factors[0], factors[1], placement, frames[node]
        )


@lean_kernel  # (.., 12) f8, i8, i8, f8, f8 -> f8
def hull_spread(poses, first, second, turn, quarter):
    """A bound of how far the hull of two poses sticks out of the chords of its part's points."""
    square = 0.0
    for k in range(9):
        square += (poses[first, k] - poses[second, k]) ** 2
    return min(turn, np.sqrt(0.5 * square) * (1.0 + 1e-9) * quarter + 1e-12)


@lean_kernel  # (N + 1, 12) f8, i8, i8, f8, (B, 3) f8, i8 -> f8
def _spread(poses, first, width, share, bounds, part):
    """A bound of how far the grown hull of a part over an interval, `share` of all, sticks out of the swept volume."""
    deviation = bounds[part, DEVIATION] * share * share
    spread = hull_spread(poses, first, first + width, bounds[part, TURN] * share, bounds[part, QUARTER])
    return 2.0 * deviation + spread


@lean_kernel  # (.., 4) i8, i8 x 5, bool
def _halve(stack, top, i, wide, k, far, longer):
    """Puts both halves of one body's interval on the stack, with the other's: of the first body's if `longer`."""
    for half in range(2):
        row = top + half
        stack[row, 0], stack[row, 1] = i, wide
        stack[row, 2], stack[row, 3] = k, far
        if longer:
            stack[row, 0], stack[row, 1] = i + (1 - half) * (wide // 2), wide // 2
        else:
            stack[row, 2], stack[row, 3] = k + (1 - half) * (far // 2), far // 2


@lean_kernel
def _parts_meet(
    a, b, poses_a, blocks_a, sizes_a, extents_a, bounds_a, poses_b, blocks_b, sizes_b, extents_b, bounds_b, slack,
    pose_margin, margin, offset, pool, boxes, stack, axis, simplex, counters,
):  # fmt: skip
    """Whether the swept volumes of parts a and b may meet; halves the interval with the larger spread."""
    whole_a, whole_b, top = poses_a.shape[0] - 1, poses_b.shape[0] - 1, 1
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, whole_a, 0, whole_b
    while top > 0:
        top -= 1
        i, wide, k, far = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        f, g = wide / whole_a, far / whole_b
        deviation_a, deviation_b = bounds_a[a, DEVIATION] * f * f, bounds_b[b, DEVIATION] * g * g
        for end in range(2):
            place_box(poses_a, i + end * wide, extents_a, a, boxes, end)
            place_box(poses_b, k + end * far, extents_b, b, boxes, 2 + end)
        unite_boxes(boxes, 0, 1, deviation_a, boxes, 4)
        unite_boxes(boxes, 2, 3, deviation_b, boxes, 5)
        if not boxes_near(boxes, 4, boxes, 5, margin):
            continue
        spread_a = _spread(poses_a, i, wide, f, bounds_a, a)
        spread_b = _spread(poses_b, k, far, g, bounds_b, b)
        small = spread_a + spread_b <= slack
        if small or deviation_a + deviation_b <= COARSE_DEVIATION:
            proven, needed = False, deviation_a + deviation_b + margin
            for r in range(3):
                axis[r] = boxes[4, r] + boxes[4, 3 + r] - boxes[5, r] - boxes[5, 3 + r]
            # Twice: the hulls of both ends; if they are not clear, one pose of each in the middle.
            for trial in range(1 if small else 2):
                for end in range(2):
                    place_block(
                        poses_a, i + (wide // 2 if trial else end * wide), blocks_a, a, pool, end, sizes_a[a]
                    )
                    place_block(
                        poses_b, k + (far // 2 if trial else end * far), blocks_b, b, pool, 2 + end, sizes_b[b]
                    )
                if apart(pool, 0, 1, sizes_a[a], 2, 3, sizes_b[b], needed, offset, axis, simplex, counters):
                    proven = trial == 0
                    break
                if small or trial == 1:
                    return MEET
                needed = pose_margin
            if proven:
                continue
        longer = spread_a >= spread_b
        if (wide if longer else far) < 2:
            return FINER
        _halve(stack, top, i, wide, k, far, longer)
        top += 2
    return APART


@lean_kernel
def volumes_meet(
    poses_a, blocks_a, sizes_a, extents_a, bounds_a, poses_b, blocks_b, sizes_b, extents_b, bounds_b, slack,
    pose_margin, margin, offset, pool, boxes, stack, axis, simplex, counters,
):  # fmt: skip
    """APART, MEET or FINER: the relation of two bodies' swept volumes, as far as the given intervals show.

    APART: proven farther apart than `margin` minus rounding; FINER: more intervals are needed. `slack`: the part
    of epsilon that remains for the spread of hulls. `pose_margin`: a distance of parts at a pose up to which they
    MEET.
    """
    answer = APART
    for a in range(sizes_a.shape[0]):
        for b in range(sizes_b.shape[0]):
            found = _parts_meet(
                a, b, poses_a, blocks_a, sizes_a, extents_a, bounds_a, poses_b, blocks_b, sizes_b, extents_b, bounds_b,
                slack, pose_margin, margin, offset, pool, boxes, stack, axis, simplex, counters,
            )  # fmt: skip
            if found == MEET:
                return MEET
            answer = max(answer, found)
    return answer
