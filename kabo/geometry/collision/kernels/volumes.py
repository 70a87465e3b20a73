"""Comparison of two swept volumes, whatever the times [K Def. 1.3]; a fixed body's swept volume is the body itself.

Unlike in `sweep`, where two bodies move in step, every interval of one motion is compared with every interval of
the other. Both answers are proven as in `sweep`; how far a hull of two poses sticks out of the volume swept
between them is bounded by their own rotations, |R0 - R1| diameter / 4, and by the angle that the joints turn.

A body is a `Swept`: its joint's poses at the nodes of N = 2^level intervals, its parts in the joint's frame and, for
each part, bounds (B, 3) over all intervals together: deviation, angle * diameter / 4, diameter / 4.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.boxes import boxes_near, place_box, place_part, unite_boxes
from kabo.geometry.collision.kernels.distance import between
from kabo.geometry.collision.kernels.separation import apart
from kabo.geometry.collision.kernels.tracks import motion
from kabo.scene.kernels.poses import forward_kinematics

APART, MEET, FINER = 0, 1, 2  # the answers; FINER: undecided without more nodes
COARSE_DEVIATION = 0.03  # [m]: hulls that deviate more are halved without a comparison
DEVIATION, TURN, QUARTER = 0, 1, 2  # columns of bounds


@lean_kernel  # Way, Chain, i8, (B,) f8, (B,) f8 -> writes (B, 3) f8
def part_bounds(way, chain, joint, radii, diameters, bounds):
    """Writes for every part of a body its three bounds over a whole segment: deviation and both shares of the spread."""
    for p in range(radii.shape[0]):
        deviation, angle, _, _ = motion(way, chain, joint, 0, radii[p])
        bounds[p, DEVIATION] = deviation
        bounds[p, TURN], bounds[p, QUARTER] = 0.25 * angle * diameters[p], 0.25 * diameters[p]


@lean_kernel  # Way, Chain -> writes `frames` (N + 1, J, 12), whose rows [:, 0] are given
def frames_on(way, chain):
    """Writes the frames of all joints at the nodes of a segment."""
    joints, factors, segment, intervals = chain.joints, chain.factors, way.segment, way.frames.shape[0] - 1
    for node in range(intervals + 1):
        for i in range(segment.shape[1]):
            segment[2, i] = segment[0, i] + (node / intervals) * (segment[1, i] - segment[0, i])
        forward_kinematics(
            segment[2], joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, way.frames[node]
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
def _placed_boxes(body, part, first, width, deviation, boxes, row):
    """Writes the boxes of a part at both ends of an interval, and to row 4 or 5 the one around all that it sweeps."""
    for end in range(2):
        place_box(body.poses, first + end * width, body.extents, part, boxes, row + end)
    unite_boxes(boxes, row, row + 1, deviation, boxes, 4 + row // 2)


@lean_kernel
def _parts_meet(first, a, second, b, limits, pool, boxes, stack, search):
    """Whether the swept volumes of parts a and b may meet; halves the interval with the larger spread."""
    whole_a, whole_b, top = first.poses.shape[0] - 1, second.poses.shape[0] - 1, 1
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, whole_a, 0, whole_b
    while top > 0:
        top -= 1
        i, wide, k, far = stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3]
        f, g = wide / whole_a, far / whole_b
        deviation_a, deviation_b = first.bounds[a, DEVIATION] * f * f, second.bounds[b, DEVIATION] * g * g
        _placed_boxes(first, a, i, wide, deviation_a, boxes, 0)
        _placed_boxes(second, b, k, far, deviation_b, boxes, 2)
        if not boxes_near(boxes, 4, boxes, 5, limits.margin):
            continue
        spread_a = _spread(first.poses, i, wide, f, first.bounds, a)
        spread_b = _spread(second.poses, k, far, g, second.bounds, b)
        small = spread_a + spread_b <= limits.slack
        if small or deviation_a + deviation_b <= COARSE_DEVIATION:
            proven, needed = False, deviation_a + deviation_b + limits.margin
            between(boxes, 4, 5, search.axis)
            # Twice: the hulls of both ends; if they are not clear, one pose of each in the middle.
            for trial in range(1 if small else 2):
                for end in range(2):
                    place_part(first.poses, i + (wide // 2 if trial else end * wide), first.hulls, a, pool, end)
                    place_part(
                        second.poses, k + (far // 2 if trial else end * far), second.hulls, b, pool, 2 + end
                    )
                if apart(pool, 0, 1, 2, 3, needed, search):
                    proven = trial == 0
                    break
                if small or trial == 1:
                    return MEET
                needed = limits.pose_margin
            if proven:
                continue
        longer = spread_a >= spread_b
        if (wide if longer else far) < 2:
            return FINER
        _halve(stack, top, i, wide, k, far, longer)
        top += 2
    return APART


@lean_kernel
def volumes_meet(first, second, limits, pool, boxes, stack, search):
    """APART, MEET or FINER: the relation of two bodies' swept volumes, and the parts that MEET.

    APART: proven farther apart than the margin minus rounding; FINER: more intervals are needed.
    """
    answer = APART
    for a in range(first.extents.shape[0]):
        for b in range(second.extents.shape[0]):
            found = _parts_meet(first, a, second, b, limits, pool, boxes, stack, search)
            if found == MEET:
                return MEET, a, b
            answer = max(answer, found)
    return answer, 0, 0
