"""Inclusion in half-spaces is one-sided at the boundary."""

import numpy as np
import pytest

from kabo.geometry import contains

CUBE = np.concatenate([np.eye(3), -np.eye(3)]), np.full(6, 0.5)  # |x|, |y|, |z| <= 0.5


@pytest.mark.parametrize("depth", [-1.0, -1e-9, 0.0, 0.5e-3])
def test_points_less_deep_than_the_margin_are_not_contained(depth):
    assert not contains(CUBE, np.array([[0.0, 0, 0], [0.5 - depth, 0, 0]]), 1e-3)


@pytest.mark.parametrize("depth", [1e-3 + 1e-12, 2e-3, 0.5])
def test_points_deeper_than_the_margin_are_contained(depth):
    assert contains(CUBE, np.array([[0.0, 0, 0], [0, depth - 0.5, 0]]), 1e-3)


def test_a_point_that_is_not_a_number_is_outside():
    assert not contains(CUBE, np.array([[0.0, np.nan, 0]]), 1e-9)


def test_no_half_space_contains_everything_and_one_point_outside_is_enough():
    assert contains((np.zeros((0, 3)), np.zeros(0)), np.ones((4, 3)), 1e-9)
    assert not contains(CUBE, np.array([[0.0, 0, 0], [0, 0, 2]]), 1e-9)
