"""Enclosures and groups: what kernels may trust."""

import numpy as np
import pytest

from kabo.geometry import Enclosure, FixedGroup, MovingGroup
from kabo.geometry.parts import COLUMNS, poses_of, stacked
from kabo.meshes import Rounding
from tests.support.strategies import IDENTITY

TRIANGLE = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])


def test_unused_columns_repeat_the_first_vertex_and_sizes_are_multiples_of_eight():
    many = np.random.default_rng(0).normal(size=(9, 3))
    packed = Enclosure((TRIANGLE + 1.0, many), 0.0).packed
    assert packed.sizes.tolist() == [8, 16]
    assert np.array_equal(packed.blocks[0, :, :3].T, TRIANGLE + 1.0)
    assert (packed.blocks[0, :, 3:] == 1.0).all()
    assert np.array_equal(packed.blocks[1, :, :9].T, many)
    assert np.array_equal(packed.blocks[1, :, 9:], np.repeat(many[:1].T, 7, axis=1))


def test_blocks_are_as_wide_as_the_part_with_the_most_corners_of_all_enclosures():
    many = np.random.default_rng(0).normal(size=(COLUMNS, 3))
    few, wide = Enclosure((TRIANGLE,), 0.0).packed, Enclosure((many,), 0.0).packed
    assert (few.blocks.shape, wide.blocks.shape) == ((1, 3, 8), (1, 3, 64))
    both = stacked([few, wide])
    assert both.sizes.tolist() == [8, 64]
    assert np.array_equal(both.blocks[1], wide.blocks[0])
    assert (both.blocks[0, :, 3:] == 0.0).all()


def test_the_diameter_counts_the_disc_but_not_the_ball_which_does_not_turn():
    needle, across = np.array([[0.0, 0, 0], [0, 0, 4.0]]), (0.0, 0.0, 1.0)
    roundings = Rounding(0.5), Rounding(disc=1.5, axis=across), Rounding(0.5, 1.5, across)
    diameters = Enclosure((needle,) * 3, 0.0, roundings).packed.diameters
    assert np.allclose(diameters, [4.0, 5.0, 5.0], atol=1e-9)
    assert (diameters >= [4.0, 5.0, 5.0]).all()


@pytest.mark.parametrize(
    "rounding", [Rounding(-1.0), Rounding(np.nan), Rounding(disc=np.inf), Rounding(0.1, 0.1, (0.0, 0.0, 1.1))]
)
def test_a_rounding_that_is_none_is_refused(rounding):
    with pytest.raises(ValueError, match="radii|length 1"):
        Enclosure((TRIANGLE,), 0.0, (rounding,))


@pytest.mark.parametrize(
    "tree",
    [
        {"children": ((1, 2), (0, 0), (0, 0))},  # all are roots
        {"children": ((1, 1), (2, 1), (1, 1)), "roots": 1},  # a circle
        {"children": ((1, 1), (0, 0), (0, 0)), "roots": 1},  # one belongs to none
        {"children": ((1, 2), (0, 0)), "roots": 1},
        {"roots": 1},
        {"roots": 4},
        {"deviations": (0.1,)},
        {"deviations": (0.1, np.nan, 0.1)},
        {"roundings": (Rounding(),)},
    ],
)
def test_parts_that_are_no_tree_are_refused(tree):
    with pytest.raises(ValueError):
        Enclosure((TRIANGLE,) * 3, 0.0, **tree)


def test_a_tree_tells_the_children_the_roots_and_the_deviations_of_its_parts():
    made = Enclosure((TRIANGLE,) * 3, 0.1, deviations=(0.3, 0.1, 0.0), children=((1, 2), (0, 0), (0, 0)), roots=1)
    assert (made.root_parts, made.children_of(0), made.children_of(1)) == (range(1), range(1, 3), range(0))
    assert [made.deviation_of(i) for i in range(3)] == [0.3, 0.1, 0.0]
    flat = Enclosure((TRIANGLE,), 0.1)
    assert (flat.root_parts, list(flat.children_of(0)), flat.deviation_of(0)) == (range(1), [], 0.1)


def test_the_diameter_is_never_less_than_the_greatest_distance_of_two_vertices():
    assert 5.0 <= Enclosure((TRIANGLE,), 0.0).packed.diameters[0] <= 5.0 + 1e-9


@pytest.mark.parametrize(
    "part",
    [
        np.zeros((0, 3)),
        np.zeros((65, 3)),
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


def test_poses_are_those_of_the_groups_in_their_order():
    enclosure = Enclosure((TRIANGLE,), 0.0)
    poses = poses_of([MovingGroup(1, IDENTITY + 1, enclosure), FixedGroup(IDENTITY, enclosure)])
    assert np.array_equal(poses, [IDENTITY + 1, IDENTITY])
    assert poses_of([]).shape == (0, 12)


@pytest.mark.parametrize("pose", [IDENTITY * np.nan, IDENTITY + np.inf, IDENTITY[:11], np.eye(4)])
def test_a_pose_that_is_not_twelve_finite_numbers_is_refused(pose):
    with pytest.raises(ValueError):
        poses_of([FixedGroup(pose, Enclosure((TRIANGLE,), 0.0))])
