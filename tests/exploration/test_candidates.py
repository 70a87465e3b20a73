"""Candidates lie in the unit cube: half of them anywhere, half around what is known to be valid."""

import numpy as np
import pytest

from kabo.exploration.candidates import around, folded, spread_candidates
from kabo.streams import stream_key, uniforms


@pytest.mark.parametrize("dimensions", [1, 2, 6])
@pytest.mark.parametrize("scale", [0.01, 0.12, 10.0])
def test_candidates_lie_in_the_unit_cube(dimensions, scale):
    found = spread_candidates(stream_key(dimensions), 501, np.full((3, dimensions), 0.99), scale)
    assert found.shape == (501, dimensions)
    assert found.min() >= 0.0
    assert found.max() <= 1.0


def test_half_are_uniform_and_half_are_normal_around_known_points():
    known = np.array([[0.2, 0.3], [0.7, 0.6]])
    found = spread_candidates(stream_key(3), 20_000, known, 0.02)
    anywhere, near = found[:10_000], found[10_000:]
    np.testing.assert_array_equal(anywhere, uniforms(stream_key(3), 0, 10_000, 2))
    distances = near[:, None] - known
    chosen = np.argmin(np.linalg.norm(distances, axis=2), axis=1)
    assert np.mean(chosen) == pytest.approx(0.5, abs=0.02)
    offsets = distances[np.arange(len(near)), chosen]
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=0.001)
    np.testing.assert_allclose(offsets.std(axis=0), 0.02, rtol=0.03)


def test_both_halves_are_drawn_from_different_samples_of_the_stream():
    near = around(stream_key(1), 10, 4, np.array([[0.5, 0.5]]), 0.1)
    np.testing.assert_array_equal(near, around(stream_key(1), 9, 5, np.array([[0.5, 0.5]]), 0.1)[1:])


def test_points_outside_are_mirrored_at_the_sides():
    given = np.array([-0.25, 1.25, 2.25, -1.0, 3.0, 0.4, 0.0, 1.0])
    np.testing.assert_allclose(folded(given), [0.25, 0.75, 0.25, 1.0, 1.0, 0.4, 0.0, 1.0])
