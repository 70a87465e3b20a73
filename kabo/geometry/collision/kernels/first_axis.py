"""The axis and the point from which the search for a separating axis of two parts starts.

Each part is taken for an ellipsoid with the spread of its corners. Of two ellipsoids with spreads A and B, whose
centres are t apart, the axis along which they leave the greatest gap relative to their size is (A + B)^-1 t: three
of four pairs that are apart are proven so along it at once, where along t it is every second. The search's simplex
starts with the difference of the corners' means, which is a point of the difference of the parts: it saves one
round of every other search. Both are hints: a proof is the gap along an axis, however it was found.
"""

from kabo.compilation import inner, joined_kernel


@joined_kernel  # (12,) f8, Outlines, i8, i8, Search -> writes (3,) f8, (4, 3) f8
def first_axis(pose, outlines, a, b, search):
    """Writes an axis from part b, moved by `pose`, to part a, and the simplex's first point."""
    boxes, cores, axis = outlines.parts, outlines.cores, search.axis
    first, second, third = (pose[0], pose[1], pose[2]), (pose[3], pose[4], pose[5]), (pose[6], pose[7], pose[8])
    middle = boxes[b, 0], boxes[b, 1], boxes[b, 2]
    t = (
        boxes[a, 0] - (inner(first, middle) + pose[9]),
        boxes[a, 1] - (inner(second, middle) + pose[10]),
        boxes[a, 2] - (inner(third, middle) + pose[11]),
    )
    mean = cores[b, 0], cores[b, 1], cores[b, 2]
    search.simplex[0, 0] = cores[a, 0] - (inner(first, mean) + pose[9])
    search.simplex[0, 1] = cores[a, 1] - (inner(second, mean) + pose[10])
    search.simplex[0, 2] = cores[a, 2] - (inner(third, mean) + pose[11])
    x = cores[b, 3], cores[b, 4], cores[b, 5]
    y = cores[b, 4], cores[b, 6], cores[b, 7]
    z = cores[b, 5], cores[b, 7], cores[b, 8]
    turned = inner(first, x), inner(first, y), inner(first, z)
    xx = cores[a, 3] + inner(turned, first)
    xy = cores[a, 4] + inner(turned, second)
    xz = cores[a, 5] + inner(turned, third)
    turned = inner(second, x), inner(second, y), inner(second, z)
    yy = cores[a, 6] + inner(turned, second)
    yz = cores[a, 7] + inner(turned, third)
    zz = cores[a, 8] + inner((inner(third, x), inner(third, y), inner(third, z)), third)
    # The adjugate matrix has the inverse's direction; divided by the trace's square, its size is that of t or less.
    trace = xx + yy + zz
    scale = 1.0 / (trace * trace)
    c00, c01, c02 = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    c11, c12, c22 = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    axis[0] = scale * inner((c00, c01, c02), t)
    axis[1] = scale * inner((c01, c11, c12), t)
    axis[2] = scale * inner((c02, c12, c22), t)
