"""Paden-Kahan subproblems, the building blocks of closed forms: rotations that move points to points [Paden 1986].

A vector is a tuple of three numbers. An axis is (6,): its unit direction, then a point on it. A function
whose problem may have no solution also returns how far it is from having one, so that no result is NaN.
"""

import numpy as np

from kabo.compilation import lean_kernel

SINGULAR_SLACK = 1e-7  # [m, or relative] by which a solution may be missed near a singularity
ON_AXIS_DISTANCE = 3e-10  # [m, or relative] within which a point is on an axis, so that the angle is free


@lean_kernel  # vector, vector -> f8
def dot(a, b):
    """The inner product of the vectors a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@lean_kernel  # vector, vector -> vector
def cross(a, b):
    """The vector product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_kernel  # vector, f8, vector -> vector
def plus(a, t, b):
    """The sum a + t b."""
    return a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]


@lean_kernel  # vector -> f8
def norm(a):
    """The length of the vector a."""
    return np.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@lean_kernel  # vector, f8, vector -> vector
def turned(h, angle, v):
    """A vector rotated about the unit direction h."""
    c, s, along = np.cos(angle), np.sin(angle), h[0] * v[0] + h[1] * v[1] + h[2] * v[2]
    w, k = cross(h, v), along * (1.0 - c)
    return c * v[0] + s * w[0] + k * h[0], c * v[1] + s * w[1] + k * h[1], c * v[2] + s * w[2] + k * h[2]


@lean_kernel  # (6,) f8 -> vector
def direction(axis):
    """The direction of an axis."""
    return axis[0], axis[1], axis[2]


@lean_kernel  # (6,) f8 -> vector
def origin(axis):
    """The point on an axis."""
    return axis[3], axis[4], axis[5]


@lean_kernel  # (6,) f8, f8, vector -> vector
def carried(axis, angle, point):
    """A point rotated about an axis."""
    p = origin(axis)
    return plus(p, 1.0, turned(direction(axis), angle, plus(point, -1.0, p)))


@lean_kernel  # vector, vector, vector -> f8
def angle_between(h, start, end):
    """The angle about h from one vector to another, in (-pi, pi]."""
    return np.arctan2(dot(h, cross(start, end)), dot(start, end) - dot(h, start) * dot(h, end))


@lean_kernel  # vector -> vector
def across(h):
    """A unit vector perpendicular to a unit vector."""
    if abs(h[0]) <= abs(h[1]) and abs(h[0]) <= abs(h[2]):
        w = 0.0, -h[2], h[1]
    elif abs(h[1]) <= abs(h[2]):
        w = h[2], 0.0, -h[0]
    else:
        w = -h[1], h[0], 0.0
    length = norm(w)
    return w[0] / length, w[1] / length, w[2] / length


@lean_kernel  # (6,) f8, (6,) f8 -> vector
def meeting_point(first, second):
    """The point on the first axis that is nearest to the second; the axes are not parallel."""
    a, b = direction(first), direction(second)
    between = plus(origin(second), -1.0, origin(first))
    c = dot(a, b)
    return plus(origin(first), (dot(a, between) - c * dot(b, between)) / (1.0 - c * c), a)


@lean_kernel  # f8, f8, f8 -> i8, f8, f8, f8
def cosine_angles(a, b, value):
    """The angles x with a cos x + b sin x = value: their count, two angles, and the distance from solvability (or 0).

    A count of -1 means that a and b vanish, so that every angle is a solution.
    """
    length = np.hypot(a, b)
    excess = abs(value) - length
    if length <= ON_AXIS_DISTANCE and abs(value) <= SINGULAR_SLACK:
        return -1, 0.0, 0.0, 0.0
    if excess > SINGULAR_SLACK:
        return 0, 0.0, 0.0, excess
    middle = np.arctan2(b, a)
    if excess >= 0.0:
        return 1, middle if value >= 0.0 else middle + np.pi, 0.0, 0.0
    side = np.arctan2(np.sqrt((length - value) * (length + value)), value)
    return 2, middle + side, middle - side, 0.0


@lean_kernel  # (6,) f8, vector, vector, f8 -> i8, f8, f8, f8
def angles_to_plane(axis, point, normal, value):
    """The angles t such that `point` rotated by -t about an axis has normal · (point - p) = value, with p on the axis."""
    h, v = direction(axis), plus(point, -1.0, origin(axis))
    along = dot(h, v)
    return cosine_angles(
        dot(normal, v) - along * dot(normal, h), -dot(normal, cross(h, v)), value - along * dot(normal, h)
    )


@lean_kernel  # vector x 4, f8 -> i8, f8 x 4, f8
def two_turns(h1, h2, start, end, spare):
    """The angles about h1 and h2 with turned(h1, t1, turned(h2, t2, start)) = end, for vectors of equal length.

    Returns the number of solutions, t1 and t2 of each, and the distance from solvability; a count of -1 means one
    solution in which t1 is free and set to `spare`.
    """
    c, size = dot(h1, h2), norm(start)
    s2 = 1.0 - c * c
    x, y = dot(h2, start), dot(h1, end)
    alpha, beta = (y - c * x) / s2, (x - c * y) / s2
    around_first, around_second = norm(cross(h1, end)), norm(cross(h2, start))
    if around_first <= around_second:  # the smaller difference is the more exact
        radius, part = around_first, abs(beta) * np.sqrt(s2)
    else:
        radius, part = around_second, abs(alpha) * np.sqrt(s2)
    missing = part - radius
    if missing > SINGULAR_SLACK * size:
        return 0, 0.0, 0.0, 0.0, 0.0, missing
    gamma = np.sqrt(max((radius - part) * (radius + part), 0.0) / s2)
    flat = plus((alpha * h1[0], alpha * h1[1], alpha * h1[2]), beta, h2)
    side = cross(h1, h2)
    z = plus(flat, gamma, side)
    if around_first <= ON_AXIS_DISTANCE * size:
        return -1, spare, angle_between(h2, start, end), 0.0, 0.0, 0.0
    t1, t2 = angle_between(h1, z, end), angle_between(h2, start, z)
    if gamma == 0.0:
        return 1, t1, t2, 0.0, 0.0, 0.0
    z = plus(flat, -gamma, side)
    return 2, t1, t2, angle_between(h1, z, end), angle_between(h2, start, z), 0.0


@lean_kernel  # vector x 4, f8 -> i8, f8 x 4, f8
def two_links(n, upper, lower, reach, spare):
    """The angles about one direction n with turned(n, a, upper + turned(n, b, lower)) = reach, components along n aside.

    Returns the number of solutions, a and b of each, and the distance from solvability [m]. A count of -1 means that
    one angle is free and set to `spare`.
    """
    u, v, w = plus(lower, -dot(n, lower), n), plus(upper, -dot(n, upper), n), plus(reach, -dot(n, reach), n)
    lu, lv, lw = norm(u), norm(v), norm(w)
    missing = max(lw - lu - lv, abs(lu - lv) - lw)
    if missing > SINGULAR_SLACK:
        return 0, 0.0, 0.0, 0.0, 0.0, missing
    if lu <= ON_AXIS_DISTANCE or lv <= ON_AXIS_DISTANCE:
        return -1, angle_between(n, plus(v, 1.0, turned(n, spare, u)), w), spare, 0.0, 0.0, 0.0
    bend = np.arccos(min(1.0, max(-1.0, (lw * lw - lu * lu - lv * lv) / (2.0 * lu * lv))))
    straight = angle_between(n, u, v)
    if lw <= ON_AXIS_DISTANCE:
        return -1, spare, straight + np.pi, 0.0, 0.0, 0.0
    b1, b2 = straight + bend, straight - bend
    a1 = angle_between(n, plus(v, 1.0, turned(n, b1, u)), w)
    if bend == 0.0 or bend == np.pi:
        return 1, a1, b1, 0.0, 0.0, 0.0
    return 2, a1, b1, angle_between(n, plus(v, 1.0, turned(n, b2, u)), w), b2, 0.0
