"""Two triangles cross exactly where rational clipping leaves a point that they do not share."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.triangles.kernels.crossing import faces_cross, triangles_cross
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE

FLAT = "without area"


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def clipped(polygon, normal, point):
    """The corners of the part of a polygon where normal . (x - point) <= 0 [Sutherland and Hodgman 1974]."""
    corners = []
    for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        da, db = dot(normal, minus(a, point)), dot(normal, minus(b, point))
        if da <= 0:
            corners.append(a)
        if da * db < 0:
            corners.append([x + (y - x) * da / (da - db) for x, y in zip(a, b, strict=True)])
    return corners


def oracle(first, second, shared):
    """Whether two triangles meet outside of what they share, in rational numbers; FLAT if both have no area."""
    first, second = ([[Fraction(float(x)) for x in row] for row in t] for t in (first, second))
    kept = first[:shared]
    normal = cross(minus(first[1], first[0]), minus(first[2], first[0]))
    if not any(normal):
        first, second = second, first
        normal = cross(minus(first[1], first[0]), minus(first[2], first[0]))
    if not any(normal):
        return FLAT
    common = clipped(second, normal, first[0])
    common = clipped(common, [-x for x in normal], first[0])
    for a, b in zip(first, first[1:] + first[:1], strict=True):
        common = clipped(common, cross(minus(b, a), normal), a)
    if shared < 2:
        return any(point not in kept for point in common)
    # The common part is convex: beside the edge there is a corner that is not on its line, or beyond its ends.
    edge = minus(kept[1], kept[0])
    along = [(cross(edge, minus(p, kept[0])), dot(edge, minus(p, kept[0]))) for p in common]
    return any(any(off) or not 0 <= t <= dot(edge, edge) for off, t in along)


def answer(first, second, shared):
    return triangles_cross(np.array([*first, *second], dtype=float), shared, np.full(SCRATCH_SIZE, np.nan))


@st.composite
def pairs(draw):
    """Two triangles and how many vertices they share: on a small grid, in a plane, touching, or one unit apart."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shared = draw(st.integers(0, 2))
    kind = draw(st.sampled_from(["grid", "flat grid", "any", "plane", "touching", "fan"]))
    size = draw(st.sampled_from([1e-6, 0.1, 1.0, 3e3]))
    points = rng.normal(size=(6, 3))
    if kind == "grid":
        points = rng.integers(-2, 3, size=(6, 3)).astype(float)
    if kind == "flat grid":
        points = rng.integers(-3, 4, size=(6, 3)) * [1.0, 1.0, 0.0]
    points[3 : 3 + shared] = points[:shared]
    if kind == "plane":  # rounded: nearly in one plane
        points = points[:, :2] @ rng.normal(size=(2, 3)) + rng.normal(size=3)
    if kind == "touching":  # a corner of one lies in the other, but for rounding
        a, b = rng.random(2) * rng.integers(0, 2, size=2)
        points[5] = points[0] + a * (points[1] - points[0]) + b * (1 - a) * (points[2] - points[0])
    if kind == "fan":  # long and thin, opening by small angles
        points[1:] = points[0] + [1.0, 0.0, 0.0] + 1e-7 * rng.integers(-2, 3, size=(5, 3))
    if draw(st.booleans()):
        points = points @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = points * size
    nudge = rng.integers(-1, 2, size=(6, 3)) * (rng.random((6, 3)) < 0.2) * draw(st.booleans())
    points = np.where(points == 0.0, 0.0, points + nudge * np.spacing(points))
    points[np.abs(points) < 1e-60] = 0.0
    points[3 : 3 + shared] = points[:shared]
    return points[:3], points[3:], shared


@given(pair=pairs())
def test_triangles_cross_exactly_where_they_have_a_point_in_common_that_they_do_not_share(pair):
    first, second, shared = pair
    expected = oracle(first, second, shared)
    crosses = answer(first, second, shared)
    with_area = all(np.any(np.cross(t[1] - t[0], t[2] - t[0])) for t in (first, second))
    if expected is not FLAT and (with_area or shared != 1):
        assert crosses == expected
    elif expected is True:
        assert crosses


@given(pair=pairs(), turn=st.integers(0, 2), swap=st.booleans())
def test_the_answer_does_not_depend_on_the_order_of_corners_or_triangles(pair, turn, swap):
    first, second, shared = pair
    vertices = np.concatenate([first, second])
    faces = [np.arange(3), np.array([*range(shared), *range(3 + shared, 6)])]
    expected = answer(first, second, shared)
    a, b = faces[::-1] if swap else faces
    assert faces_cross(vertices, *np.roll(a, turn), *b[::-1], np.empty((6, 3)), np.empty(SCRATCH_SIZE)) == expected


@pytest.mark.parametrize(
    ("apex", "crosses"),
    [((0.5, 1.0, 0.0), True), ((0.5, 1.0, 1e-12), False), ((0.5, -1.0, 0.0), False), ((2.0, 0.3, 0.0), True)],
)
def test_triangles_at_an_edge_cross_only_when_folded_flat(apex, crosses):
    first = [[0, 0, 0], [1, 0, 0], [0.3, 1, 0]]
    assert answer(first, [[0, 0, 0], [1, 0, 0], apex], 2) is crosses


@pytest.mark.parametrize("far", [1e-12, 1e-3, 10.0])
def test_needles_apart_are_said_to_be_apart(far):
    needle = np.array([[0.0, 0, 0], [1, 1, 1], [2, 2, 2]])
    for move in ([far, 0, 0], [far, -far, 0.0], [2.0 + far, 2.0 + far, 2.0 + far]):
        assert not answer(needle, needle + move, 0)
        assert not answer(needle, needle * [-1, 1, 1] + [-far, 0, 0], 0)
    assert answer(needle, needle + 1.0, 0)


def test_faces_with_the_same_three_vertices_cross():
    vertices = np.eye(3)
    assert faces_cross(vertices, 0, 1, 2, 2, 1, 0, np.empty((6, 3)), np.empty(SCRATCH_SIZE))
