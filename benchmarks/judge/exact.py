"""Winding numbers without rounding: the sign of a determinant is taken from floats where it is certain, else exactly."""

from fractions import Fraction

import numpy as np

DIRECTION = np.array([577.0, 333.0, 745.0]) / 1024  # of the ray; its components are exact
UNSURE = 64 * 2.0**-53  # of the sum of all products: more than any rounding of a determinant's


def winding(point, vertices, faces):
    """How often a closed mesh winds around a point; None if the point lies on it, or its ray meets an edge."""
    a, b, c = (vertices[faces[:, k]] - point for k in range(3))
    turns = [_signs(DIRECTION, p, q) for p, q in ((a, b), (b, c), (c, a))]
    possible = np.ones(len(faces), bool)
    for sign in (1, -1):  # a sure sign against the others excludes the face
        possible &= ~(np.any([t == sign for t in turns], axis=0) & np.any([t == -sign for t in turns], axis=0))
    exact = [Fraction(float(x)) for x in point]
    ray = [Fraction(float(x)) for x in DIRECTION]
    total = 0
    for face in faces[possible]:
        corners = [[Fraction(float(x)) - y for x, y in zip(vertices[k], exact, strict=True)] for k in face]
        around = [_det(ray, corners[i], corners[(i + 1) % 3]) for i in range(3)]
        if any(x > 0 for x in around) and any(x < 0 for x in around):
            continue
        volume = _det(*corners)
        if volume == 0 or 0 in around:
            return None
        side = 1 if around[0] > 0 else -1
        if (volume > 0) == (side > 0):
            total += side
    return total


def _signs(d, p, q):
    """The sign of det(d, p, q) for each row; 0 where floats cannot tell (differences are rounded once before)."""
    products = np.stack(
        [d[0] * p[:, 1] * q[:, 2], d[0] * p[:, 2] * q[:, 1], d[1] * p[:, 2] * q[:, 0]]
        + [d[1] * p[:, 0] * q[:, 2], d[2] * p[:, 0] * q[:, 1], d[2] * p[:, 1] * q[:, 0]]
    )
    value = (products * np.array([1, -1, 1, -1, 1, -1])[:, None]).sum(0)
    return np.sign(value) * (np.abs(value) > UNSURE * np.abs(products).sum(0))


def _det(a, b, c):
    return (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
