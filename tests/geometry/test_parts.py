"""Enclosures and groups: what kernels may trust."""

import numpy as np
import pytest

from kabo.geometry import Enclosure, FixedGroup, MovingGroup
from kabo.geometry.parts import COLUMNS, poses_of
from tests.support.strategies import IDENTITY

TRIANGLE = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])


def test_unused_columns_repeat_the_first_vertex_and_sizes_are_multiples_of_eight():
    many = np.random.default_rng(0).normal(size=(9, 3))
    packed = Enclosure((TRIANGLE + 1.0, many), 0.0).packed
    assert packed.sizes.tolist() == [8, 16]
    assert np.array_equal(packed.blocks[0, :, :3].T, TRIANGLE + 1.0)
    assert (packed.blocks[0, :, 3:] == 1.0).all()
    assert np.array_equal(packed.blocks[1, :, :9].T, many)
    assert np.array_equal(packed.blocks[1, :, 9:], np.repeat(many[:1].T, COLUMNS - 9, axis=1))


def test_the_diameter_is_never_less_than_the_greatest_distance_of_two_vertices():
    assert 5.0 <= Enclosure((TRIANGLE,), 0.0).packed.diameters[0] <= 5.0 + 1e-9


@pytest.mark.parametrize(
    "part",
    [
        np.zeros((0, 3)),
        np.zeros((25, 3)),
        np.zeros((4, 2)),
        np.zeros(3),
        TRIANGLE.astype(np.float32),
        np.eye(3, dtype=int),
    ],
)
def test_a_part_of_wrong_shape_or_type_is_refused(part):
    with pytest.raises(ValueError, match="a convex part is"):
        Enclosure((part,), 0.0).packed  # noqa: B018


@pytest.mark.parametrize("value", [np.nan, -np.nan, np.inf, -np.inf])
def test_a_vertex_that_is_not_finite_is_refused_by_its_number(value):
    part = TRIANGLE.copy()
    part[2, 1] = value
    with pytest.raises(ValueError, match="vertex 2 of a convex part is not finite"):
        Enclosure((TRIANGLE, part), 0.0).packed  # noqa: B018


def test_poses_are_those_of_moving_groups_and_then_of_fixed_ones():
    enclosure = Enclosure((TRIANGLE,), 0.0)
    poses = poses_of([MovingGroup(1, IDENTITY + 1, enclosure)], [FixedGroup(IDENTITY, enclosure)])
    assert np.array_equal(poses, [IDENTITY + 1, IDENTITY])
    assert poses_of([], []).shape == (0, 12)


@pytest.mark.parametrize("pose", [IDENTITY * np.nan, IDENTITY + np.inf, IDENTITY[:11], np.eye(4)])
def test_a_pose_that_is_not_twelve_finite_numbers_is_refused(pose):
    with pytest.raises(ValueError):
        poses_of([], [FixedGroup(pose, Enclosure((TRIANGLE,), 0.0))])
