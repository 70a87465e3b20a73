"""Solvers for the forms of closed-form inverse kinematics: rotations about an arm's axes with a given product [K A.3].

The axes (m, 6) are given with all joints at zero; the motion (12,) is the product turn_1 … turn_m of all
rotations. Frames, offsets and link lengths are arbitrary as long as the axes lie as the form demands.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import lean_kernel
from kabo.kinematics.kernels.subproblems import (
    ON_AXIS_DISTANCE,
    SINGULAR_SLACK,
    across,
    angle_between,
    angles_to_plane,
    carried,
    cosine_angles,
    cross,
    direction,
    dot,
    meeting_point,
    norm,
    origin,
    plus,
    turned,
    two_links,
    two_turns,
)

SPHERICAL, THREE_PARALLEL, FIVE = 0, 1, 2  # forms
PARALLEL, CROSSING = 0, 1  # how the three axes before a spherical wrist lie: second and third, or first and second
ON_FIRST_AXIS, ON_SECOND_AXIS, ON_THIRD_AXIS, WRIST_ALIGNED = (
    1,
    2,
    4,
    8,
)  # singularities
LEAN_TOLERANCE = 1e-5  # [rad] between axes that count as parallel; refinement corrects it


MAX_SOLUTIONS = 8  # of one pose
MIDDLE, HALF = 0, 1  # columns of `Solutions.windows`


class Solutions(NamedTuple):
    """The solutions of a form, in the order of its axes, with the windows that angles must lie in, and scratch."""

    turns: Array  # (MAX_SOLUTIONS, 6) [rad]
    free: Integers  # (MAX_SOLUTIONS,) the singularities of each solution, as bits
    windows: Array  # (6, 2) middle and half the width [rad]; an infinite half admits every angle
    found: Array  # (4, 3) scratch: angles of the first three axes
    swapped: Array  # (3, 6) scratch: these axes in the inverse order


@lean_kernel  # (6, 2) f8, i8, f8 -> bool
def admits(windows, axis, angle):
    """Whether an angle, up to whole turns, lies in the window of an axis."""
    half = windows[axis, HALF]
    if half >= np.pi:
        return True
    off = angle - windows[axis, MIDDLE]
    return abs(off - 2.0 * np.pi * np.round(off / (2.0 * np.pi))) <= half


@lean_kernel  # (12,) f8, vector -> vector
def moved_direction(T, v):
    """A direction rotated by a pose."""
    return (
        T[0] * v[0] + T[1] * v[1] + T[2] * v[2],
        T[3] * v[0] + T[4] * v[1] + T[5] * v[2],
        T[6] * v[0] + T[7] * v[1] + T[8] * v[2],
    )


@lean_kernel  # (12,) f8, vector -> vector
def moved_point(T, p):
    """A point transformed by a pose."""
    return plus((T[9], T[10], T[11]), 1.0, moved_direction(T, p))


@lean_kernel  # (6,) f8 x 3, vector, vector -> i8, i8, f8; writes (4, 3) f8
def turns_of_parallel(a, b, c, start, goal, found, spare):
    """Angles about three axes, b and c parallel, that move a point to a goal: their count, free angles, missing [m]."""
    n, sense = direction(b), 1.0 if dot(direction(b), direction(c)) > 0.0 else -1.0
    count, first, second, missing = angles_to_plane(a, goal, n, dot(n, plus(start, -1.0, origin(a))))
    total, free, short = 0, 0, missing if count == 0 else np.inf
    if count < 0:
        count, first, free = 1, spare, ON_FIRST_AXIS
    upper, lower = plus(origin(c), -1.0, origin(b)), plus(start, -1.0, origin(c))
    for k in range(count):
        t = first if k == 0 else second
        wanted = plus(carried(a, -t, goal), -1.0, origin(b))
        number, p1, q1, p2, q2, missing = two_links(n, upper, lower, wanted, spare)
        short = min(short, missing)
        if number < 0:
            number, free = 1, free | ON_SECOND_AXIS
        for i in range(number):
            found[total, 0] = t
            found[total, 1] = p1 if i == 0 else p2
            found[total, 2] = sense * (q1 if i == 0 else q2)
            total += 1
    return total, free, 0.0 if total else short


@lean_kernel  # (6,) f8 x 3, vector, vector, (4, 3) f8, f8, (6, 2) f8, i8 -> i8, i8, f8; writes found
def turns_of_crossing(a, b, c, start, goal, found, spare, windows, third):
    """Angles about three axes, a and b crossing, that move a point to a goal: their count, free angles, missing [m].

    Angles about c outside the window of axis `third` are left out.
    """
    s = meeting_point(a, b)
    h = direction(c)
    u, v, end = plus(start, -1.0, origin(c)), plus(s, -1.0, origin(c)), plus(goal, -1.0, s)
    up, vp = plus(u, -dot(h, u), h), plus(v, -dot(h, v), h)
    apart, rise = dot(end, end), dot(h, u) - dot(h, v)
    lu, lv = norm(up), norm(vp)
    # |turned(u) - v|^2 = lu^2 + lv^2 + rise^2 - 2 up·vp(t): what the third axis can do about the distance
    value = 0.5 * (lu * lu + lv * lv + rise * rise - apart)
    count, first, second, missing = cosine_angles(dot(vp, up), dot(vp, cross(h, up)), value)
    if count == 0:
        far, near = np.sqrt((lu + lv) ** 2 + rise * rise), np.sqrt((lu - lv) ** 2 + rise * rise)
        return 0, 0, max(np.sqrt(apart) - far, near - np.sqrt(apart), missing / max(lu + lv, SINGULAR_SLACK))
    total, free, short = 0, 0, np.inf
    if count < 0:
        count, first, free = 1, spare, ON_THIRD_AXIS
    for k in range(count):
        t = first if k == 0 else second
        if not admits(windows, third, t):
            continue
        begin = plus(carried(c, t, start), -1.0, s)
        number, p1, q1, p2, q2, missing = two_turns(direction(a), direction(b), begin, end, spare)
        short = min(short, missing)
        if norm(cross(direction(b), begin)) <= ON_AXIS_DISTANCE:
            free = free | ON_SECOND_AXIS
        if number < 0:
            number, free = 1, free | ON_FIRST_AXIS
        for i in range(number):
            found[total, 0] = p1 if i == 0 else p2
            found[total, 1] = q1 if i == 0 else q2
            found[total, 2] = t
            total += 1
    return total, free, 0.0 if total else short


@lean_kernel  # i8, bool, (m, 6) f8, vector, vector, f8, Solutions -> i8, i8, f8; writes solutions.found
def turns_to_point(placing, mirrored, axes, start, goal, spare, solutions):
    """The angles about the first three axes that move a point to a goal; if `mirrored`, of the inverse problem."""
    found, swapped, windows = solutions.found, solutions.swapped, solutions.windows
    if not mirrored:
        if placing == PARALLEL:
            return turns_of_parallel(axes[0], axes[1], axes[2], start, goal, found, spare)
        return turns_of_crossing(axes[0], axes[1], axes[2], start, goal, found, spare, windows, 2)
    for i in range(3):
        for k in range(3):
            swapped[i, k], swapped[i, 3 + k] = -axes[2 - i, k], axes[2 - i, 3 + k]
    if placing == PARALLEL:
        answer = turns_of_parallel(swapped[0], swapped[1], swapped[2], goal, start, found, spare)
    else:
        answer = turns_of_crossing(swapped[0], swapped[1], swapped[2], goal, start, found, spare, windows, 0)
    for i in range(answer[0]):
        found[i, 0], found[i, 2] = found[i, 2], found[i, 0]
    return answer


@lean_kernel  # (6, 6) f8, (12,) f8, i8, bool, f8, Solutions -> i8, i8, f8; writes solutions
def solve_spherical(axes, motion, placing, mirrored, spare, solutions):
    """Solves arms whose axes 4, 5 and 6 meet in a point, which only the first three axes move [K A.3, six axes]."""
    found, turns, free, windows = solutions.found, solutions.turns, solutions.free, solutions.windows
    centre = meeting_point(axes[4], axes[3])
    count, unbound, missing = turns_to_point(
        placing, mirrored, axes, centre, moved_point(motion, centre), spare, solutions
    )
    z4, z5, z6 = direction(axes[3]), direction(axes[4]), direction(axes[5])
    mark = across(z6)
    singular, total = unbound, 0
    for i in range(count):
        if not (
            admits(windows, 0, found[i, 0]) and admits(windows, 1, found[i, 1]) and admits(windows, 2, found[i, 2])
        ):
            continue
        y, m = moved_direction(motion, z6), moved_direction(motion, mark)
        for k in range(3):
            h = direction(axes[k])
            y, m = turned(h, -found[i, k], y), turned(h, -found[i, k], m)
        number, p1, q1, p2, q2, _ = two_turns(z4, z5, z6, y, spare)
        aligned = WRIST_ALIGNED if number < 0 else 0
        singular = singular | aligned
        for j in range(abs(number)):
            p, q = (p1, q1) if j == 0 else (p2, q2)
            if not (admits(windows, 3, p) and admits(windows, 4, q)):
                continue
            sixth = angle_between(z6, mark, turned(z5, -q, turned(z4, -p, m)))
            if not admits(windows, 5, sixth):
                continue
            for k in range(3):
                turns[total, k] = found[i, k]
            turns[total, 3], turns[total, 4], turns[total, 5] = p, q, sixth
            free[total] = unbound | aligned
            total += 1
    return total, singular, missing


@lean_kernel  # (m, 6) f8, (12,) f8, four f8, i8, i8, f8, Solutions -> i8, f8; writes solutions
def bend(axes, motion, angles, unbound, total, spare, solutions):
    """Writes the angles of the three parallel axes, given the sum of these three angles, and the other angles.

    `angles` are the first, the sum of the parallel ones, the fifth and the sixth.
    """
    first, whole, fifth, sixth = angles
    turns, free, windows = solutions.turns, solutions.free, solutions.windows
    n, m = direction(axes[1]), axes.shape[0]
    p = carried(axes[4], -fifth, origin(axes[3]))
    if m == 6:
        p = carried(axes[5], -sixth, p)
    p = carried(axes[0], -first, moved_point(motion, p))
    upper, lower = plus(origin(axes[2]), -1.0, origin(axes[1])), plus(origin(axes[3]), -1.0, origin(axes[2]))
    number, a1, b1, a2, b2, missing = two_links(n, upper, lower, plus(p, -1.0, origin(axes[1])), spare)
    s3 = 1.0 if dot(n, direction(axes[2])) > 0.0 else -1.0
    s4 = 1.0 if dot(n, direction(axes[3])) > 0.0 else -1.0
    for i in range(abs(number)):
        a, b = (a1, b1) if i == 0 else (a2, b2)
        fourth = s4 * (whole - a - b)
        if not (admits(windows, 1, a) and admits(windows, 2, s3 * b) and admits(windows, 3, fourth)):
            continue
        turns[total, 0], turns[total, 1], turns[total, 2] = first, a, s3 * b
        turns[total, 3], turns[total, 4] = fourth, fifth
        if m == 6:
            turns[total, 5] = sixth
        free[total] = unbound | (ON_SECOND_AXIS if number < 0 else 0)
        total += 1
    return total, missing


@lean_kernel  # (6, 6) f8, (12,) f8, f8, Solutions -> i8, i8, f8; writes solutions
def solve_three_parallel(axes, motion, spare, solutions):
    """Solves arms whose axes 2, 3 and 4 are parallel while 5 and 6 meet [Hawkins 2013]."""
    windows = solutions.windows
    n, z5, z6 = direction(axes[1]), direction(axes[4]), direction(axes[5])
    centre, mark = meeting_point(axes[4], axes[5]), across(z6)
    count, first, second, missing = angles_to_plane(
        axes[0], moved_point(motion, centre), n, dot(n, plus(centre, -1.0, origin(axes[0])))
    )
    unbound, singular, total, short = 0, 0, 0, missing if count == 0 else np.inf
    if count < 0:
        count, first, unbound = 1, spare, ON_FIRST_AXIS
    for k in range(count):
        t = first if k == 0 else second
        if not admits(windows, 0, t):
            continue
        h = direction(axes[0])
        y, m = turned(h, -t, moved_direction(motion, z6)), turned(h, -t, moved_direction(motion, mark))
        number, p1, q1, p2, q2, _ = two_turns(n, z5, z6, y, spare)
        aligned = WRIST_ALIGNED if number < 0 else 0
        singular = singular | unbound | aligned
        for j in range(abs(number)):
            p, q = (p1, q1) if j == 0 else (p2, q2)
            if not admits(windows, 4, q):
                continue
            sixth = angle_between(z6, mark, turned(z5, -q, turned(n, -p, m)))
            if not admits(windows, 5, sixth):
                continue
            angles = t, p, q, sixth
            total, missing = bend(axes, motion, angles, unbound | aligned, total, spare, solutions)
            short = min(short, missing)
    return total, singular, 0.0 if total else short


@lean_kernel  # (5, 6) f8, (12,) f8, f8, Solutions -> i8, i8, f8, f8; writes solutions
def solve_five(axes, motion, spare, solutions):
    """Solves arms of five axes, 2, 3 and 4 parallel [K A.3, five axes]; also returns the tilt that is out of reach [rad].

    Five axes reach every point with any pitch and roll, but the direction of the last axis is restricted by the
    first axis.
    """
    n, z5 = direction(axes[1]), direction(axes[4])
    point, mark, y0 = origin(axes[4]), across(direction(axes[4])), moved_direction(motion, direction(axes[4]))
    base, h = origin(axes[0]), direction(axes[0])
    count, first, second, missing = angles_to_plane(
        axes[0], moved_point(motion, point), n, dot(n, plus(point, -1.0, base))
    )
    unbound, total, tilt, short = 0, 0, np.inf, missing if count == 0 else np.inf
    if count < 0:  # the point lies on the first axis: only the direction tells
        count, first, second, missing = angles_to_plane(axes[0], plus(base, 1.0, y0), n, dot(n, z5))
        tilt, short = missing if count == 0 else tilt, 0.0 if count == 0 else short
        if count < 0:
            count, first, unbound = 1, spare, ON_FIRST_AXIS
    for k in range(count):
        t = first if k == 0 else second
        y = turned(h, -t, y0)
        lean = abs(dot(n, y) - dot(n, z5))
        if lean > LEAN_TOLERANCE:
            tilt = min(tilt, lean)
        else:
            whole = angle_between(n, z5, y)
            m = turned(n, -whole, turned(h, -t, moved_direction(motion, mark)))
            fifth = angle_between(z5, mark, m)
            if not (admits(solutions.windows, 0, t) and admits(solutions.windows, 4, fifth)):
                continue
            total, missing = bend(axes, motion, (t, whole, fifth, 0.0), unbound, total, spare, solutions)
            short, tilt = min(short, missing), lean if total else tilt
    return total, unbound, 0.0 if total or short == np.inf else short, 0.0 if tilt == np.inf else tilt
