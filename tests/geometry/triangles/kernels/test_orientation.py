"""Orientation signs are exact: compared with rational arithmetic where rounding misleads."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE, likely_orientation, orientation


def exact_sign(points):
    """The oracle: the sign of (b - a) x (c - a) . (d - a) in rational numbers."""
    a, *others = [[Fraction(float(x)) for x in row] for row in points]
    u, v, w = [[x - y for x, y in zip(row, a, strict=True)] for row in others]
    volume = sum(u[i] * (v[(i + 1) % 3] * w[(i + 2) % 3] - v[(i + 2) % 3] * w[(i + 1) % 3]) for i in range(3))
    return (volume > 0) - (volume < 0)


def sign(points):
    return orientation(np.array(points, dtype=float), 0, 1, 2, 3, np.full(SCRATCH_SIZE, np.nan))


def likely(points):
    return likely_orientation(np.array(points, dtype=float), 0, 1, 2, 3)


def nudged(points, nudges):
    """The points with some coordinates moved to the next double, up or down; 0 stays 0."""
    up = np.nextafter(points, np.inf)
    down = np.nextafter(points, -np.inf)
    moved = np.where(nudges > 0, up, np.where(nudges < 0, down, points))
    return np.where(points == 0.0, 0.0, moved)


@st.composite
def nearly_coplanar(draw):
    """Four points on a grid, in a rounded plane, or of mixed sizes; some coordinates one unit in the last place off."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    size = 10.0 ** draw(st.integers(-12, 6))
    kind = draw(st.sampled_from(["grid", "plane", "far plane", "line", "mixed"]))
    if kind == "grid":
        points = rng.integers(-3, 4, size=(4, 3)) * size
    elif kind == "mixed":
        points = rng.normal(size=(4, 3)) * 10.0 ** rng.integers(-12, 7, size=(4, 3))
    else:
        points = rng.normal(size=(4, 3)) * size + (
            1000.0 * size * rng.normal(size=3) if kind == "far plane" else 0.0
        )
        s, t = rng.normal(size=2)
        points[3] = points[0] + s * (points[1] - points[0])
        if kind != "line":
            points[3] += t * (points[2] - points[0])
    nudges = rng.integers(-1, 2, size=(4, 3)) * (rng.random((4, 3)) < draw(st.sampled_from([0.0, 0.1, 0.5])))
    return nudged(points, nudges)


@given(points=nearly_coplanar())
def test_signs_are_exact(points):
    expected = exact_sign(points)
    assert sign(points) == expected
    assert likely(points) in (expected, 0)


@given(points=nearly_coplanar(), order=st.permutations(range(4)))
def test_an_odd_permutation_turns_the_sign(points, order):
    parity = round(float(np.linalg.det(np.eye(4)[list(order)])))
    assert sign(points[list(order)]) == parity * sign(points)


def test_in_front_is_where_the_normal_points():
    triangle = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert [sign([*triangle, [5, 7, z]]) for z in (0.25, 0.0, -1e-70)] == [1, 0, -1]


def test_the_filter_is_unsure_where_rounding_decides_and_the_exact_sign_is_not():
    rng = np.random.default_rng(0)
    answers = []
    for _ in range(300):
        points = rng.normal(size=(4, 3))
        points[3] = points[0] + 0.3 * (points[1] - points[0]) + 0.6 * (points[2] - points[0])
        answers.append((likely(points), sign(points), exact_sign(points)))
    unsure = [a for a in answers if a[0] == 0]
    assert len(unsure) > 100
    assert {a[1] for a in unsure} >= {-1, 1}
    assert all(a[1] == a[2] for a in answers)


@pytest.mark.parametrize("size", [1e-75, 1.0, 1e75])
def test_extreme_sizes_neither_underflow_nor_overflow(size):
    points = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1 / 3, 1 / 3, 1 / 3]]) * size
    for _ in range(4):
        assert sign(points) == exact_sign(points)
        points[3, 0] = np.nextafter(points[3, 0], np.inf)


def test_the_compiled_kernel_and_its_python_original_agree():
    rng = np.random.default_rng(1)
    for _ in range(20):
        points = np.round(rng.normal(size=(4, 3)), 1)
        assert orientation.py_func(points, 0, 1, 2, 3, np.zeros(SCRATCH_SIZE)) == sign(points)
