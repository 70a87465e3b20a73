"""The axis and the point from which the search for a separating axis of two parts starts.

Each part is taken for an ellipsoid with the spread of its corners. Of two ellipsoids with spreads A and B, whose
centres are t apart, the axis along which they leave the greatest gap relative to their size is (A + B)^-1 t: three
of four pairs that are apart are proven so along it at once, where along t it is every second. The search's simplex
starts with the difference of the corners' means, which is a point of the difference of the parts: it saves one
round of every other search. Both are hints: a proof is the gap along an axis, however it was found.
"""

from kabo.compilation import joined_kernel


@joined_kernel  # (12,) f8, Outlines, i8, i8, Search -> writes (3,) f8, (4, 3) f8
def first_axis(pose, outlines, a, b, search):
    """Writes an axis from part b, moved by `pose`, to part a, and the simplex's first point."""
    boxes, cores, axis = outlines.parts, outlines.cores, search.axis
    m00, m01, m02 = pose[0], pose[1], pose[2]
    m10, m11, m12 = pose[3], pose[4], pose[5]
    m20, m21, m22 = pose[6], pose[7], pose[8]
    x, y, z = boxes[b, 0], boxes[b, 1], boxes[b, 2]
    tx = boxes[a, 0] - (m00 * x + m01 * y + m02 * z + pose[9])
    ty = boxes[a, 1] - (m10 * x + m11 * y + m12 * z + pose[10])
    tz = boxes[a, 2] - (m20 * x + m21 * y + m22 * z + pose[11])
    x, y, z = cores[b, 0], cores[b, 1], cores[b, 2]
    search.simplex[0, 0] = cores[a, 0] - (m00 * x + m01 * y + m02 * z + pose[9])
    search.simplex[0, 1] = cores[a, 1] - (m10 * x + m11 * y + m12 * z + pose[10])
    search.simplex[0, 2] = cores[a, 2] - (m20 * x + m21 * y + m22 * z + pose[11])
    xx, xy, xz, yy, yz, zz = cores[b, 3], cores[b, 4], cores[b, 5], cores[b, 6], cores[b, 7], cores[b, 8]
    p00, p01, p02 = m00 * xx + m01 * xy + m02 * xz, m00 * xy + m01 * yy + m02 * yz, m00 * xz + m01 * yz + m02 * zz
    p10, p11, p12 = m10 * xx + m11 * xy + m12 * xz, m10 * xy + m11 * yy + m12 * yz, m10 * xz + m11 * yz + m12 * zz
    p20, p21, p22 = m20 * xx + m21 * xy + m22 * xz, m20 * xy + m21 * yy + m22 * yz, m20 * xz + m21 * yz + m22 * zz
    xx = cores[a, 3] + (p00 * m00 + p01 * m01 + p02 * m02)
    xy = cores[a, 4] + (p00 * m10 + p01 * m11 + p02 * m12)
    xz = cores[a, 5] + (p00 * m20 + p01 * m21 + p02 * m22)
    yy = cores[a, 6] + (p10 * m10 + p11 * m11 + p12 * m12)
    yz = cores[a, 7] + (p10 * m20 + p11 * m21 + p12 * m22)
    zz = cores[a, 8] + (p20 * m20 + p21 * m21 + p22 * m22)
    # The adjugate matrix has the inverse's direction; divided by the trace's square, its size is that of t or less.
    trace = xx + yy + zz
    scale = 1.0 / (trace * trace)
    c00, c01, c02 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    c11, c12, c22 = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    axis[0] = scale * (c00 * tx + c01 * ty + c02 * tz)
    axis[1] = scale * (c01 * tx + c11 * ty + c12 * tz)
    axis[2] = scale * (c02 * tx + c12 * ty + c22 * tz)
