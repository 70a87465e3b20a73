"""Oriented boxes: never apart where points of both are near, apart where a face's axis says so, NaN is near."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.collision.kernels.oriented_boxes import boxes_near, faces_near, put_pose, relative
from tests.support.strategies import IDENTITY, placement_of

MARGIN = 1e-3
INTEGERS = st.tuples(*[st.integers(-3, 3)] * 4).filter(any)  # quaternions
UNIT = st.floats(-1.0, 1.0)
SIZES = st.floats(0.0, 1.0)  # plates, needles and points as well
EXTENTS = st.tuples(UNIT, UNIT, UNIT, SIZES, SIZES, SIZES).map(np.array)
SHARES = st.tuples(UNIT, UNIT, UNIT).map(np.array)
GAPS = st.sampled_from([0.0, 0.5, 0.999])


def turned(quaternion):
    return placement_of(quaternion, np.zeros(3))[:9].reshape(3, 3)


def rows_of(pose):
    return tuple((*pose[3 * r : 3 * r + 3].tolist(), float(pose[9 + r])) for r in range(3))


def near(pose, first, second):
    """The answers of all forms of the comparison, in kernels and in Python."""
    flat = np.array([[*first, 0.0, 0.0], [*second, 0.0, 0.0]])
    answers = [f(pose, flat, 0, flat, 1, MARGIN) for f in (faces_near, faces_near.py_func)]
    return answers + [f(rows_of(pose), flat.ravel(), 0, 1, MARGIN) for f in (boxes_near, boxes_near.py_func)]


@given(INTEGERS, EXTENTS, EXTENTS, SHARES, SHARES, SHARES, GAPS)
def test_boxes_with_points_within_the_margin_are_near(quaternion, first, second, at, other, direction, gap):
    R = turned(quaternion)
    away = direction / max(np.linalg.norm(direction), 1e-9)
    point = first[:3] + at * first[3:] + gap * MARGIN * away
    t = point - R @ (second[:3] + other * second[3:])
    pose = np.concatenate([R.ravel(), t])
    assert all(near(pose, first, second))


@given(INTEGERS, EXTENTS, EXTENTS, st.integers(0, 5))
def test_boxes_farther_apart_than_the_margin_along_a_face_are_not(quaternion, first, second, axis):
    R = turned(quaternion)
    u = R[:, axis - 3] if axis > 2 else np.eye(3)[axis]
    reach = np.abs(u) @ first[3:] + np.abs(R.T @ u) @ second[3:]
    t = first[:3] + (reach + 1.001 * MARGIN) * u - R @ second[:3]
    pose = np.concatenate([R.ravel(), t])
    assert not any(near(pose, first, second))


def test_a_pose_that_is_not_a_number_is_near():
    box, pose = np.array([0.0, 0, 0, 0.1, 0.1, 0.1]), np.array([*IDENTITY[:9], 9.0, 9.0, 9.0])
    assert not any(near(pose, box, box))
    pose[:] = np.nan
    assert all(near(pose, box, box))


@given(INTEGERS, INTEGERS, SHARES, SHARES, SHARES)
def test_a_relative_pose_takes_points_from_one_frame_to_the_other(first, second, t, u, point):
    frames = np.concatenate([np.column_stack([turned(q), x]).ravel() for q, x in ((first, t), (second, u))])
    in_world = turned(second) @ point + u
    for function, put in ((relative, put_pose), (relative.py_func, put_pose.py_func)):
        pose = np.empty(12)
        put(function(frames, 0, 1), pose)
        assert np.allclose(turned(first) @ (pose[:9].reshape(3, 3) @ point + pose[9:]) + t, in_world, atol=1e-12)
