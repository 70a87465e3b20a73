"""The first axis of a search: across plates rather than between centres; hints change no answer."""

import numpy as np
import pytest

from kabo.geometry.collision.kernels.bundles import EXTENT_COLUMNS, Outlines
from kabo.geometry.collision.kernels.first_axis import first_axis
from kabo.geometry.collision.kernels.separation import posed_apart
from kabo.geometry.collision.placed_bodies import cores_of
from kabo.geometry.collision.view_arrays import search_for
from kabo.meshes import Rounding
from tests.geometry.collision.kernels.test_separation import OFFSET, PLACEMENT, hulls_of
from tests.support.strategies import IDENTITY, KINDS, touching

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
PLATE = CORNERS * [0.5, 0.5, 0.01]


def outlined(hulls):
    """Boxes around corners, and the spread of these."""
    boxes = np.zeros((len(hulls.sizes), EXTENT_COLUMNS))
    for box, block, size in zip(boxes, hulls.blocks, hulls.sizes, strict=True):
        low, high = block[:, :size].min(axis=1), block[:, :size].max(axis=1)
        box[:3], box[3:6] = (low + high) / 2, (high - low) / 2
    return Outlines(boxes, boxes, cores_of(hulls))


def axis_of(hulls, pose, function=first_axis):
    search = search_for(OFFSET)
    function(pose, outlined(hulls), 0, 1, search)
    return search.axis / np.linalg.norm(search.axis), search


def test_plates_side_by_side_are_told_apart_across_them():
    pose = np.array([*IDENTITY[:9], 0.8, 0.0, -0.03])
    for function in (first_axis, first_axis.py_func):
        axis, _ = axis_of(hulls_of((PLATE, PLATE)), pose, function)
        assert axis[2] > 0.99


def test_balls_and_discs_count_as_spread():
    needle = np.array([[0.0, 0.0, -0.01], [0.0, 0.0, 0.01]])
    pose = np.array([*IDENTITY[:9], 0.8, 0.0, -0.03])
    flat = Rounding(disc=0.5, axis=(0.0, 0.0, 1.0))
    assert axis_of(hulls_of((needle, needle), (flat, flat)), pose)[0][2] > 0.99
    ball = Rounding(radius=0.5)
    axis, _ = axis_of(hulls_of((np.zeros((1, 3)), np.zeros((1, 3))), (ball, ball)), pose)
    assert np.allclose(axis, -pose[9:] / np.linalg.norm(pose[9:]))


@pytest.mark.parametrize("kind", KINDS)
def test_searches_that_start_from_it_say_the_same_in_fewer_rounds(kind):
    rng, rounds = np.random.default_rng(KINDS.index(kind)), np.zeros(2)
    for other in KINDS:
        pair, R = touching(kind, other, PLACEMENT, rng), PLACEMENT[:9].reshape(3, 3)
        for gap in (-0.02, -1e-4, 1e-4, 0.999e-3, 1.001e-3, 0.01, 0.1):
            upper, lower = pair.upper + [0.0, 0.0, gap], pair.lower
            pose = np.concatenate([R.ravel(), [0.3, -2.0, 1.0]])
            hulls = hulls_of((upper, np.ascontiguousarray((lower - pose[9:]) @ R)))
            plain = search_for(OFFSET)
            plain.axis[:] = upper.mean(axis=0) - lower.mean(axis=0)
            free = posed_apart(hulls, 0, 1, pose, 1e-3, 0.0, 0, plain)
            _, search = axis_of(hulls, pose)
            assert posed_apart(hulls, 0, 1, pose, 1e-3, 0.0, 1, search) == free
            rounds += plain.counters[1], search.counters[1]
    assert rounds[1] < 1.05 * rounds[0]


def test_the_simplex_starts_within_the_difference_of_the_parts():
    pose = np.array([*IDENTITY[:9], 0.8, 0.0, -0.03])
    hulls = hulls_of((PLATE[:5], PLATE))  # unused columns repeat the first corner, and do not count
    _, search = axis_of(hulls, pose)
    assert np.allclose(search.simplex[0], PLATE[:5].mean(axis=0) - pose[9:], atol=1e-15)
