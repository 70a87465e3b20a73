"""Footprints on floors, against points drawn on the way."""

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.scene.drives import Drive, edges_of, hull_of_points, polygon_corners

EPSILON = 0.01
numbers = st.floats(-1.0, 1.0)
points = st.lists(st.tuples(numbers, numbers), min_size=3, max_size=9)
poses = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-4, 4))


def drive(floor: list[tuple[float, float]], footprint: list[tuple[float, float]]) -> Drive | None:
    """A drive of a floor and a footprint; None if the floor has hardly an area."""
    corners = hull_of_points(3.0 * np.array(floor))
    if len(corners) < 3 or np.ptp(corners, axis=0).min() < 0.1:
        return None
    normals, offsets = edges_of(corners)
    return Drive("floor", 3, ("base",), np.eye(4), normals, offsets, hull_of_points(0.4 * np.array(footprint)))


def deepest(made: Drive, pose: np.ndarray) -> float:
    """How far the outermost corner is out of the floor, corner by corner."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    placed = made.footprint @ np.array([[c, s], [-s, c]]) + pose[:2]
    return max(float(n @ p - o) for p in placed for n, o in zip(made.normals, made.offsets, strict=True))


@given(floor=points, footprint=points, pose=poses)
def test_a_footprint_is_as_far_out_as_its_outermost_corner(floor, footprint, pose):
    made = drive(floor, footprint)
    if made is not None:
        assert made.outside(np.array([pose]))[0] == pytest.approx(deepest(made, np.array(pose)), abs=1e-9)


@given(floor=points, footprint=points, start=poses, goal=poses)
def test_a_way_is_never_farther_out_than_told_and_hardly_less(floor, footprint, start, goal):
    made = drive(floor, footprint)
    if made is None:
        return
    a, b = np.array(start), np.array(goal)
    told = made.outside_along(a, b, EPSILON)
    shares = np.linspace(0.0, 1.0, 400)[:, None]
    worst = float(made.outside((1.0 - shares) * a + shares * b).max())
    event("inside" if told <= 0 else "outside")
    assert worst <= told + 1e-12
    assert told <= worst + EPSILON / 20 + 2e-3  # between the points drawn it may be farther out


@given(floor=points, footprint=points, pose=poses)
def test_where_the_base_fits_its_axis_is_within_the_limits_and_no_point_is_said_to_be_farther(
    floor, footprint, pose
):
    made = drive(floor, footprint)
    if made is None or made.outside(np.array([pose]))[0] > 0.0:
        return
    event("fits")
    low, high = made.box()
    place = np.array(pose[:2])
    assert np.all(low - 1e-7 <= place) and np.all(place <= high + 1e-7)
    target = np.array([[1.7, -0.3, 0.2]])
    assert made.missing(target)[0] <= np.linalg.norm(target[0, :2] - place) + 1e-9


def test_a_polygon_is_the_hull_of_the_corners_of_its_edges():
    corners = hull_of_points(np.array([[0, 0], [2, 0], [2, 1], [1, 3], [0, 1], [1, 1], [1, 0]], float))
    assert len(corners) == 5
    found = polygon_corners(*edges_of(corners))
    assert sorted(map(tuple, found.round(9))) == sorted(map(tuple, corners.round(9)))
