"""Placed bodies: cores are moved with their parts, and are kept for lists of bodies, not for what was asked before."""

import numpy as np

from kabo.geometry import Enclosure, FixedGroup
from kabo.geometry.collision.kernels.bundles import Hulls
from kabo.geometry.collision.placed_bodies import cores_of, placed_bodies
from kabo.meshes import Rounding
from kabo.scene.transforms import flat, transform


def bodies(numbers):
    """Two bodies at random poses: a hull, and one with a rounded part."""
    parts = [numbers.normal(size=(count, 3)) for count in (8, 20, 3)]
    rounded = Enclosure(tuple(parts[1:]), 0.0, (Rounding(), Rounding(0.1, 0.2, (0.0, 0.6, 0.8))))
    for enclosure in (Enclosure((parts[0],), 0.0), rounded):
        turn = numbers.normal(size=4)
        yield FixedGroup(flat(transform(numbers.normal(size=3), turn / np.linalg.norm(turn))), enclosure)


def test_cores_of_placed_parts_are_those_of_the_parts_where_they_are():
    given = tuple(bodies(np.random.default_rng(1)))
    found = placed_bodies(given, tuple(group.enclosure for group in given), 0.01)
    there = cores_of(Hulls(found.packed.blocks, found.packed.sizes, found.packed.rounds))
    np.testing.assert_allclose(found.cores, there, atol=1e-12)
    assert np.ptp(found.cores[:, :3], axis=0).max() > 0.1


def test_a_body_at_another_place_has_other_arrays():
    first, second = bodies(np.random.default_rng(2))
    _, moved = bodies(np.random.default_rng(3))
    enclosures = first.enclosure, second.enclosure
    here = placed_bodies((first, second), enclosures, 0.01)
    there = placed_bodies((first, FixedGroup(moved.world_T_group, second.enclosure)), enclosures, 0.01)
    assert not np.allclose(here.cores, there.cores)
    assert placed_bodies((first, second), enclosures, 0.01) is here
