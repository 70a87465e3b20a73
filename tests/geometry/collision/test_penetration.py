"""Penetration depths of shapes whose depth is known, and signed distances of bodies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from kabo.geometry import Enclosure, FixedGroup, penetration, signed_distance
from tests.geometry.worlds import box, move
from tests.support.strategies import healthy_part, rational_placements


def placed(points, pose):
    return points @ pose[:9].reshape(3, 3).T + pose[9:]


@settings(max_examples=60)
@given(
    halves=st.tuples(*[st.floats(0.01, 2.0)] * 6),
    shift=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    pose=rational_placements(),
)
def test_the_depth_of_two_boxes_is_the_least_overlap_of_their_sides(halves, shift, pose):
    first, second = box(halves[:3]), box(halves[3:]) + shift
    overlaps = np.add(halves[:3], halves[3:]) - np.abs(shift)
    found = penetration(placed(first, pose), placed(second, pose))
    true = max(0.0, float(overlaps.min()))
    assert found.lower <= true + 1e-12
    assert found.upper >= true - 1e-12
    assert found.upper - found.lower < 1e-9


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_shorter_way_out_exists_and_the_upper_bound_is_one(seed):
    rng = np.random.default_rng(seed)
    first, second = healthy_part(rng, 1.0), healthy_part(rng, 1.0) + rng.uniform(-0.5, 0.5, 3)
    found = penetration(first, second)
    ways = rng.normal(size=(4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    overlap = (first @ ways.T).max(axis=0) - (second @ ways.T).min(axis=0)
    assert found.lower <= overlap.min() + 1e-12
    assert found.upper - found.lower < 1e-9
    if found.lower > 0:
        planes = ConvexHull((first[:, None] - second[None]).reshape(-1, 3)).equations
        assert found.lower == pytest.approx(-planes[:, 3].max(), abs=1e-9)


@pytest.mark.parametrize("flat", [np.zeros((1, 3)), box([0.5, 0.0, 0.0]), box([0.5, 0.5, 0.0])])
def test_flat_sets_do_not_overlap_and_are_apart_or_touch(flat):
    assert penetration(flat, flat).lower == 0.0
    assert penetration(flat, flat).upper < 1e-12
    assert penetration(flat, flat + [0, 0, 1.0]).upper < 1e-12
    inside = penetration(flat, box([1.0, 1.0, 0.2]))
    assert inside.lower <= 0.2 <= inside.upper + 1e-12
    assert inside.upper - inside.lower < 1e-9


@pytest.mark.parametrize("bad", [np.zeros((0, 3)), np.zeros((3, 2)), np.full((4, 3), np.nan)])
def test_sets_that_are_none_are_refused(bad):
    with pytest.raises(ValueError, match="convex set"):
        penetration(bad, box([1.0] * 3))


def body(points, pose=(0.0, 0.0, 0.0), deviation=0.0, mesh=True):
    points = np.asarray(points, float)
    hull = ConvexHull(points)
    arrays = (points, hull.simplices.astype(np.int64)) if mesh else None
    return FixedGroup(move(*pose), Enclosure((points,), deviation), arrays)


def test_signed_distances_are_minus_the_depth_where_bodies_overlap():
    cube = body(box([0.5] * 3))
    apart = signed_distance(cube, body(box([0.5] * 3), (0, 0, 1.25)))
    assert apart.lower <= 0.25 <= apart.upper
    into = signed_distance(cube, body(box([0.5] * 3), (0, 0, 0.9)))
    assert into.lower == pytest.approx(-0.1, abs=1e-9)
    assert into.upper >= -0.1 - 1e-9
    small = body(box([0.01] * 3))
    deep = signed_distance(cube, small)
    assert deep.lower == pytest.approx(-0.51, abs=1e-9)
    assert deep.upper <= -0.48, "a vertex of the small cube lies deep in the large one"
    loose = signed_distance(body(box([0.5] * 3), deviation=0.01, mesh=False), body(box([0.5] * 3), (0, 0, 0.9)))
    assert loose.upper == pytest.approx(0.01, abs=1e-6)
