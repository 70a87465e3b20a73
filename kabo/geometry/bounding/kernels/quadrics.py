"""Quadric costs of a contraction: sums of squared distances and their approximations [K 4.3.3, Appendix A.1].

A quadric is a row of ten numbers: the symmetric matrix xx, xy, xz, yy, yz, zz, the linear terms x, y, z, and the
constant of x·A x + 2 b·x + c.
"""

import numpy as np

from kabo.compilation import lean_kernel

# Cost functions; the numbers are arguments of kernels.
PLANES, ADAPTED, TRIANGLES, DIAGONAL, MEMORYLESS = 0, 1, 2, 3, 4


@lean_kernel  # (10,) f8, f8 x 5 -> nothing
def add_plane(quadric, x, y, z, offset, weight):
    """Adds the weighted squared distance to the plane n·p = offset to a quadric [K Eq. A.5]."""
    quadric[0] += weight * x * x
    quadric[1] += weight * x * y
    quadric[2] += weight * x * z
    quadric[3] += weight * y * y
    quadric[4] += weight * y * z
    quadric[5] += weight * z * z
    quadric[6] -= weight * x * offset
    quadric[7] -= weight * y * offset
    quadric[8] -= weight * z * offset
    quadric[9] += weight * offset * offset


@lean_kernel  # (10,) f8, f8 x 4 -> nothing
def add_point(quadric, x, y, z, weight):
    """Adds the weighted squared distance to a point to a quadric [K Eq. A.3]."""
    quadric[0] += weight
    quadric[3] += weight
    quadric[5] += weight
    quadric[6] -= weight * x
    quadric[7] -= weight * y
    quadric[8] -= weight * z
    quadric[9] += weight * (x * x + y * y + z * z)


@lean_kernel  # (10,) f8, f8 x 3 -> f8
def cost_at(q, x, y, z):
    """The value of a quadric at a point."""
    square = x * (q[0] * x + 2.0 * (q[1] * y + q[2] * z)) + y * (q[3] * y + 2.0 * q[4] * z) + q[5] * z * z
    return square + 2.0 * (q[6] * x + q[7] * y + q[8] * z) + q[9]


@lean_kernel  # (10,) f8, f8 x 3 -> nothing
def move_origin(q, x, y, z):
    """Expresses the quadric relative to the point x, y, z."""
    q[9] = cost_at(q, x, y, z)
    q[6] += q[0] * x + q[1] * y + q[2] * z
    q[7] += q[1] * x + q[3] * y + q[4] * z
    q[8] += q[2] * x + q[4] * y + q[5] * z


@lean_kernel  # (10,) f8 -> f8 x 3
def minimiser(q):
    """The minimiser of the quadric; if it is not unique, approximately the one nearest to the origin."""
    r = 1e-9 * (q[0] + q[3] + q[5]) + 1e-300
    l00 = np.sqrt(q[0] + r)
    l10, l20 = q[1] / l00, q[2] / l00
    l11 = np.sqrt(max(q[3] + r - l10 * l10, r))
    l21 = (q[4] - l10 * l20) / l11
    l22 = np.sqrt(max(q[5] + r - l20 * l20 - l21 * l21, r))
    x = -q[6] / l00
    y = (-q[7] - l10 * x) / l11
    z = (-q[8] - l20 * x - l21 * y) / l22 / l22
    y = (y - l21 * z) / l11
    return (x - l10 * y - l20 * z) / l00, y, z


@lean_kernel  # (10,) f8 x 2, (3, 3) f8 -> nothing; turns the matrices of q into the frame of the rows
def _in_frame(q, frame, turned):
    for i in range(3):
        u, v, w = frame[i, 0], frame[i, 1], frame[i, 2]
        x, y, z = q[0] * u + q[1] * v + q[2] * w, q[1] * u + q[3] * v + q[4] * w, q[2] * u + q[4] * v + q[5] * w
        for j in range(3):
            turned[i, j] = frame[j, 0] * x + frame[j, 1] * y + frame[j, 2] * z
        turned[i, 3] = q[6] * u + q[7] * v + q[8] * w


@lean_kernel  # (10,) f8, (3, 4) f8, (3, 3) f8 -> nothing
def _principal_axes(q, matrix, frame):
    """The eigenvectors of the quadric as rows [Jacobi 1846]; matrix is scratch."""
    for i in range(3):
        for j in range(3):
            frame[i, j] = 1.0 if i == j else 0.0
    _in_frame(q, frame, matrix)
    for sweep in range(18):
        i, j = (0, 1) if sweep % 3 == 0 else (0, 2) if sweep % 3 == 1 else (1, 2)
        if abs(matrix[i, j]) <= 1e-15 * (abs(matrix[i, i]) + abs(matrix[j, j])):
            continue
        theta = (matrix[j, j] - matrix[i, i]) / (2.0 * matrix[i, j])
        t = (1.0 if theta >= 0.0 else -1.0) / (abs(theta) + np.sqrt(theta * theta + 1.0))
        c = 1.0 / np.sqrt(t * t + 1.0)
        s = t * c
        for r in range(3):
            u, v = frame[i, r], frame[j, r]
            frame[i, r], frame[j, r] = c * u - s * v, s * u + c * v
        _in_frame(q, frame, matrix)


@lean_kernel  # (10,) f8 x 3, f8, (10, 4) f8 -> nothing
def _diagonal(first, second, combined, exact_at, scratch):
    """Writes an upper bound of min(first, second), diagonal in the axes of their sum [K Eq. 4.6, 4.7].

    Each coefficient is the greater of the bounds for `first` and `second`. `exact_at`: the free parameter l of
    Eq. 4.7 [m]. All three quadrics have their origin at the minimiser of the sum.
    """
    frame, one, two = scratch[0:3, 0:3], scratch[3:6], scratch[6:9]
    _principal_axes(combined, one, frame)
    _in_frame(first, frame, one)
    _in_frame(second, frame, two)
    constant = max(first[9], second[9])
    for r in range(10):
        combined[r] = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        squares = max(
            np.sqrt(one[i, i] ** 2 + one[i, j] ** 2 + one[i, k] ** 2),
            np.sqrt(two[i, i] ** 2 + two[i, j] ** 2 + two[i, k] ** 2),
        )
        slope = 2.0 * max(abs(one[i, 3]), abs(two[i, 3]))
        constant += 0.5 * slope * exact_at
        add_plane(combined, frame[i, 0], frame[i, 1], frame[i, 2], 0.0, squares + 0.5 * slope / exact_at)
    combined[9] = constant


@lean_kernel
def combine(kind, first, second, combined, exact_at, scratch):
    """Writes the quadric of a contracted edge, computed from its ends' quadrics by the cost `kind` [K Eq. 4.5 ff.].

    `exact_at`: the free parameter l of Eq. 4.7 [m]. `scratch` is (13, 10) f8.
    """
    for r in range(10):
        combined[r] = first[r] + second[r]
    if kind != ADAPTED and kind != DIAGONAL:
        return
    x, y, z = minimiser(combined)
    if kind == ADAPTED:
        combined[9] = max(0.0, combined[9] - max(cost_at(first, x, y, z), cost_at(second, x, y, z)))
        return
    one, two = scratch[10], scratch[11]
    for r in range(10):
        one[r], two[r] = first[r], second[r]
    move_origin(one, x, y, z)
    move_origin(two, x, y, z)
    move_origin(combined, x, y, z)
    _diagonal(one, two, combined, exact_at, scratch[0:10, 0:4])
    move_origin(combined, -x, -y, -z)
