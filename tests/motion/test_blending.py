"""Rounded corners."""

import numpy as np
import pytest

from kabo.motion import Blended, blended, thinned

CORNERS = np.array([[0.0, 0.0, 0.0], [0.5, 0.1, 0.0], [0.6, 0.7, -0.2], [1.4, 0.7, 0.3]])


def distance(q: np.ndarray, path: np.ndarray) -> float:
    """From a path of straight pieces."""
    found = []
    for a, b in zip(path, path[1:], strict=False):
        share = np.clip((q - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        found.append(np.linalg.norm(q - a - share * (b - a)))
    return float(min(found))


def test_a_blend_passes_by_its_corner_at_no_more_than_the_deviation() -> None:
    path = blended(CORNERS, 0.05)
    for number in (1, 2):
        assert np.linalg.norm(path.at(path.corner(number)) - CORNERS[number]) == pytest.approx(0.05, abs=1e-9)
    for s in np.linspace(0.0, path.length, 500):
        assert distance(path.at(s), CORNERS) <= 0.05


def test_the_ends_are_reached_exactly() -> None:
    path = blended(CORNERS, 0.05)
    assert np.array_equal(path.at(0.0), CORNERS[0])
    assert np.allclose(path.at(path.length), CORNERS[-1], atol=1e-12)


def test_the_direction_does_not_jump() -> None:
    path = blended(CORNERS, 0.05)
    for border in path.borders[1:-1]:
        assert np.allclose(path.at(border - 1e-9, 1), path.at(border + 1e-9, 1), atol=1e-6)


def test_the_derivatives_are_those_of_the_path() -> None:
    path, h = blended(CORNERS, 0.05), 1e-6
    for s in np.linspace(0.01, path.length - 0.01, 50):
        assert np.allclose((path.at(s + h) - path.at(s - h)) / (2 * h), path.at(s, 1), atol=1e-4)


def test_blends_reach_over_a_short_piece() -> None:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.02], [2.0, 0.02]])
    path = blended(corners, 0.05)
    assert path.trims[1] + path.trims[2] > 0.1
    assert max(distance(q, corners) for q in path.at(np.linspace(0.0, path.length, 500))) <= 0.05


def test_a_corner_without_a_share_is_gone_through() -> None:
    path = blended(CORNERS, 0.05, [1.0, 0.0, 1.0, 1.0])
    assert path.trims[1] == 0.0
    assert np.allclose(path.at(path.corner(1)), CORNERS[1], atol=1e-12)


def test_equal_neighbours_are_refused() -> None:
    with pytest.raises(ValueError, match="neighbours that differ"):
        blended([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]], 0.1)


def test_thinning_keeps_corners_and_drops_what_is_collinear() -> None:
    path = np.array([[0.0, 0.0], [0.25, 1e-5], [0.5, 0.0], [1.0, 0.0], [1.0, 0.5], [1.0, 1.0]])
    assert thinned(path, 1e-3) == [0, 3, 5]


def test_thinning_stays_within_its_tolerance() -> None:
    angles = np.linspace(0.0, 1.5, 40)
    path = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    kept = path[thinned(path, 0.01)]
    assert len(kept) < 12
    assert max(distance(q, kept) for q in path) <= 0.01


def test_a_path_along_two_corners_is_straight() -> None:
    path = Blended(CORNERS[:2], np.zeros(2))
    assert path.length == pytest.approx(float(np.linalg.norm(CORNERS[1] - CORNERS[0])))
