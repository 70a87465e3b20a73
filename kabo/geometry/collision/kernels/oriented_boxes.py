"""Comparison of oriented boxes: boxes of parts and groups in their joint's frame, along the axes of both frames.

A pair of bodies is compared in the frame of the first: boxes that rotate with their bodies are tighter than boxes
along the world's axes, and only pairs that need it are transformed. The edges' nine cross products [Gottschalk
1996] would exclude a tenth more pairs, and cost more than a search for an axis.
"""

from kabo.compilation import (
    absolute,
    all_four,
    any_greater,
    four,
    fused,
    inner,
    joined_kernel,
    minus,
    plus,
    put_four,
    sums,
    times,
)


@joined_kernel  # (J * 12,) f8, i8, i8 -> 3 x 4 f8
def relative(frames, first, second):
    """The rows of first_T_second, the pose of joint `second` in the frame of joint `first`, from those of `frames_of`."""
    at, of = 12 * first, 12 * second
    x = minus(four(frames, of), (0.0, 0.0, 0.0, frames[at + 3]))
    y = minus(four(frames, of + 4), (0.0, 0.0, 0.0, frames[at + 7]))
    z = minus(four(frames, of + 8), (0.0, 0.0, 0.0, frames[at + 11]))
    return _row(frames, at, x, y, z), _row(frames, at + 1, x, y, z), _row(frames, at + 2, x, y, z)


@joined_kernel  # (J * 12,) f8, i8, 4 f8 x 3 -> 4 f8
def _row(frames, at, x, y, z):
    part = fused(all_four(frames[at + 4]), y, times(all_four(frames[at + 8]), z))
    return fused(all_four(frames[at]), x, part)


@joined_kernel  # 3 x 4 f8 -> writes (12,) f8
def put_pose(rows, pose):
    """Writes a pose of three rows as nine numbers of the rotation and three of the origin."""
    put_four(pose, 0, rows[0])
    put_four(pose, 3, rows[1])
    put_four(pose, 6, rows[2])
    pose[9], pose[10], pose[11] = rows[0][3], rows[1][3], rows[2][3]


@joined_kernel  # 3 x 4 f8 first_T_second, (S * 8,) f8 centre and half extents, i8, i8 -> 4 f8, 4 f8, 4 f8
def _along_first(rows, boxes, a, b):
    """Along the axes of the first of two boxes: the distance of the centres, and the half extents of the second."""
    x, y, z = rows
    centre, half = four(boxes, 8 * b), four(boxes, 8 * b + 3)
    centre, half = (centre[0], centre[1], centre[2], 1.0), (half[0], half[1], half[2], 0.0)
    distance = minus(sums(times(x, centre), times(y, centre), times(z, centre)), four(boxes, 8 * a))
    return distance, sums(times(absolute(x), half), times(absolute(y), half), times(absolute(z), half)), half


@joined_kernel  # 3 x 4 f8, (S * 8,) f8, i8, i8, f8 [m] -> bool
def boxes_near(rows, boxes, a, b, margin):
    """As `faces_near`, of boxes in one flat array."""
    x, y, z = rows
    distance, reach, half = _along_first(rows, boxes, a, b)
    own = four(boxes, 8 * a + 3)
    if any_greater(minus(absolute(distance), reach), plus(own, all_four(margin))):
        return False
    dx, dy, dz = all_four(distance[0]), all_four(distance[1]), all_four(distance[2])
    distance = absolute(fused(x, dx, fused(y, dy, times(z, dz))))
    ax, ay, az = absolute(x), absolute(y), absolute(z)
    reach = fused(ax, all_four(own[0]), fused(ay, all_four(own[1]), times(az, all_four(own[2]))))
    return not any_greater(minus(distance, reach), plus(half, all_four(margin)))


@joined_kernel  # (12,) f8 first_T_second, (S, 6) f8 centre and half extents, i8, (S, 6) f8, i8, f8 [m] -> bool
def faces_near(pose, first, a, second, b, margin):
    """Whether no axis of either box proves two oriented boxes farther apart than `margin`; True if a number is NaN."""
    middle, half = (second[b, 0], second[b, 1], second[b, 2]), (second[b, 3], second[b, 4], second[b, 5])
    x, y, z = (pose[0], pose[1], pose[2]), (pose[3], pose[4], pose[5]), (pose[6], pose[7], pose[8])
    dx = inner(x, middle) + pose[9] - first[a, 0]
    dy = inner(y, middle) + pose[10] - first[a, 1]
    dz = inner(z, middle) + pose[11] - first[a, 2]
    apart = abs(dx) - inner((abs(x[0]), abs(x[1]), abs(x[2])), half) > first[a, 3] + margin
    apart |= abs(dy) - inner((abs(y[0]), abs(y[1]), abs(y[2])), half) > first[a, 4] + margin
    apart |= abs(dz) - inner((abs(z[0]), abs(z[1]), abs(z[2])), half) > first[a, 5] + margin
    between, own = (dx, dy, dz), (first[a, 3], first[a, 4], first[a, 5])
    for k in range(3):
        apart |= (
            abs(inner((x[k], y[k], z[k]), between)) - inner((abs(x[k]), abs(y[k]), abs(z[k])), own)
            > half[k] + margin
        )
    return not apart
