"""Widths over rotations: against a search that knows nothing of directions, and against boxes told by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kabo.geometry_server.foresight.widths import corners, excess_about, excess_at_any, turn_onto, widths

UP = np.array([0.0, 0.0, 1.0])
FLAT = np.eye(3)[:2]


def box(*size: float) -> np.ndarray:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return 0.5 * signs * np.array(size)


@pytest.mark.parametrize("seed", range(8))
def test_no_turn_about_the_axis_does_better(seed: int) -> None:
    """What is proven is beyond the room at every turn of a finer search, made with other means."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(0.02, 0.2, 3)
    rooms = rng.uniform(0.05, 0.6, 2)
    found = excess_about(points, UP, UP, FLAT, rooms)
    turned = Rotation.from_rotvec(np.linspace(0, 2 * np.pi, 7001)[:, None] * UP).as_matrix()
    spans = np.ptp(points @ turned.transpose(0, 2, 1), axis=1)[:, :2]
    least = float((spans - rooms).max(axis=1).min())
    assert found.metres == pytest.approx(least, abs=2e-3)
    assert not found.proven or least > 0.0


def test_a_beam_that_fits_neither_way_is_too_wide_although_each_width_fits_at_some_turn() -> None:
    found = excess_about(box(0.068, 0.03, 0.1), UP, UP, FLAT, np.array([0.05, 0.05]))
    assert found.proven and 0.015 < found.metres < 0.019
    assert not excess_about(box(0.068, 0.03, 0.1), UP, UP, FLAT, np.array([0.05, 0.08])).proven


def test_what_may_be_rotated_at_will_counts_with_its_least_width() -> None:
    found = excess_at_any(box(0.3, 0.2, 0.1), np.array([0.05, 0.5, 0.5]))
    assert found.proven and found.width == pytest.approx(0.1, abs=1e-3)
    assert not excess_at_any(box(0.3, 0.2, 0.1), np.array([0.11, 0.5, 0.5])).proven


@pytest.mark.parametrize("seed", range(5))
def test_a_turn_takes_one_direction_to_the_other(seed: int) -> None:
    first, second = (v / np.linalg.norm(v) for v in np.random.default_rng(seed).normal(size=(2, 3)))
    for goal in (second, first, -first):
        turn = turn_onto(first, goal)
        assert np.allclose(turn @ first, goal) and np.allclose(turn @ turn.T, np.eye(3))
        assert np.linalg.det(turn) == pytest.approx(1.0)


def test_corners_have_all_widths() -> None:
    points = np.random.default_rng(1).normal(size=(400, 3))
    directions = np.eye(3)
    assert np.allclose(widths(corners(points), directions), widths(points, directions))
