"""The separation kernels: compiled code and its Python original say the same, and axes prove what is said."""

import numpy as np
import pytest

from kabo.geometry.collision.kernels import separation, simplex
from kabo.geometry.collision.kernels.bundles import Hulls
from kabo.geometry.collision.view_arrays import search_for
from kabo.geometry.parts import Enclosure
from tests.support.strategies import KINDS, placement_of, touching

OFFSET = 64.0  # at least twice every |vertex|
PLACEMENT = placement_of((1, 2, 2, 0), np.zeros(3))


def asked(function, pair, gap, margin):
    """The answer for a pair at a gap, and the axis that is left."""
    parts = pair.upper + [0.0, 0.0, gap], pair.lower
    search = searching()
    free = function(hulls_of(parts), 0, 0, 1, 1, margin, search)
    return bool(free), search.axis, parts, search.counters


def hulls_of(parts, roundings=()):
    """Parts as rows for kernels."""
    packed = Enclosure(parts, 0.0, roundings).packed
    return Hulls(packed.blocks, packed.sizes, packed.rounds)


def searching(offset=OFFSET):
    """A search from any axis."""
    search = search_for(offset)
    search.axis[:] = 0.3, -0.2, 0.5
    return search


@pytest.mark.parametrize("kind", KINDS)
def test_compiled_and_original_agree_and_the_axis_proves_it(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    for other in KINDS:
        pair = touching(kind, other, PLACEMENT, rng)
        for gap in (0.0, 1e-4, 0.999e-3, 1.001e-3, 0.1):
            free, axis, (upper, lower), counters = asked(separation.apart, pair, gap, 1e-3)
            assert free == asked(separation.apart.py_func, pair, gap, 1e-3)[0]
            assert free == (gap > 1e-3)
            assert counters[0] == 1
            if free:
                assert (upper @ axis).min() - (lower @ axis).max() > 1e-3 - separation.rounding.py_func(OFFSET)


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_moved_by_a_pose_is_as_far_as_one_that_lies_there(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    for other in KINDS:
        pair, R = touching(kind, other, PLACEMENT, rng), PLACEMENT[:9].reshape(3, 3)
        for gap in (-1e-4, 0.0, 1e-4, 0.999e-3, 1.001e-3, 0.1):
            free, _, (upper, lower), _ = asked(separation.apart, pair, gap, 1e-3)
            pose = np.concatenate([R.ravel(), [0.3, -2.0, 1.0]])  # of the lower part's frame in the upper's
            posed = hulls_of((upper, np.ascontiguousarray((lower - pose[9:]) @ R))), 0, 1, pose
            for function in (separation.posed_apart, separation.posed_apart.py_func):
                search = searching()
                axis = search.axis
                assert function(*posed, 1e-3, 0.0, 0, search) == free
                assert search.counters[0] == 1
                if free:
                    assert (upper @ axis).min() - (lower @ axis).max() > 1e-3 - separation.rounding.py_func(OFFSET)
            pose[9] = np.nan
            assert not separation.posed_apart(*posed, 1e-3, 0.0, 0, search)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_compiled_and_original_agree_on_the_nearest_point_of_a_simplex(count):
    rng = np.random.default_rng(count)
    for _ in range(50):
        corners = rng.normal(size=(4, 3)) + rng.normal(size=3)
        twin = corners.copy()
        found, *point = simplex.nearest(corners, count)
        carried, *other = simplex.nearest.py_func(twin, count)
        assert found == carried
        assert np.allclose(point, other, atol=1e-12)
        assert np.array_equal(corners[:found], twin[:found])
        weights = rng.dirichlet(np.ones(count), 200)
        assert (
            np.linalg.norm(point) <= np.linalg.norm(weights @ twin[:count], axis=1).min() + 1e-9 or found < count
        )


@pytest.mark.parametrize("place", [(0, 0), (1, 2)])
def test_a_vertex_that_is_not_a_number_never_becomes_apart(place):
    pair = touching("box", "box", PLACEMENT, np.random.default_rng(0))
    hulls = hulls_of((pair.upper + [0, 0, 0.5], pair.lower))
    hulls.blocks[:, place[1], :] = np.nan
    assert not separation.apart(hulls, 0, 0, 1, 1, 1e-3, searching())
