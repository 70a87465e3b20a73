"""Exact predicates on meshes: the same questions as the bounded ones, answered at distance zero."""

import numpy as np
import pytest
import trimesh

from kabo.geometry import (
    Budget,
    Enclosure,
    FixedGroup,
    Motion,
    MovingGroup,
    collides,
    exact_collides,
    exact_distance,
    exact_includes,
    exact_sweep_collides,
    includes,
    sweep_collides,
)
from tests.geometry.collision.test_predicates import container, cup
from tests.geometry.worlds import box, move, slide, three_joints
from tests.support.strategies import IDENTITY

BUDGET = Budget.share(0.01)


def solid(mesh, pose=IDENTITY):
    """A body with a mesh; its part is the hull."""
    arrays = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    return FixedGroup(pose, Enclosure((np.asarray(mesh.convex_hull.vertices),), 0.0), arrays)


def cube(x=0.0, y=0.0, z=0.0, half=0.1):
    return solid(trimesh.creation.box((2 * half,) * 3), move(x, y, z))


def test_exact_collisions_are_bounded_ones_and_exactly_so():
    for z in (0.0, 0.15, 0.199, 0.201, 0.2 + BUDGET.epsilon, 0.5):
        exact = exact_collides(cube(), cube(z=z))
        assert exact is (z < 0.2)
        assert not exact or collides(cube(), cube(z=z), BUDGET)
    assert exact_collides(cube(half=0.5), cube(half=0.01)), "wholly inside"
    assert exact_collides(cube(half=0.01), cube(half=0.5))


def test_exact_distances():
    assert exact_distance(cube(), cube(z=0.5)) == pytest.approx(0.3)
    assert exact_distance(cube(half=0.5), cube(half=0.01)) == 0.0


def test_exact_inclusion_in_a_container_that_is_not_convex():
    walls, prove = solid(cup()), container(cup())
    for body, true in (
        (cube(x=0.4, half=0.09), True),
        (cube(z=-0.3, half=0.15), True),
        (cube(z=0.2, half=0.09), False),
        (cube(x=0.4, half=0.11), False),
        (cube(half=2.0), False),
        (cube(x=3.0), False),
    ):
        assert exact_includes(walls, body) is true
        assert true or not includes(prove, body, BUDGET)


def test_a_hollow_of_the_container_within_the_body_is_noticed():
    outer, hollow = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((0.05,) * 3)
    hollow.invert()
    shell = solid(trimesh.util.concatenate([outer, hollow]))
    assert not exact_includes(shell, cube())
    assert exact_includes(shell, cube(x=0.3))


def arm(*waypoints):
    bar = trimesh.creation.box((0.3, 0.06, 0.06))
    mesh = np.asarray(bar.vertices), np.asarray(bar.faces, np.int64)
    bodies = [
        MovingGroup(j, move(0.15, 0, 0), Enclosure((box([0.15, 0.03, 0.03]),), 0.0), mesh) for j in (1, 2, 3)
    ]
    return Motion(three_joints(), tuple(bodies), np.array(waypoints, float))


def test_sampled_sweeps_agree_with_bounded_ones_outside_the_band():
    quarter, step = arm([0, 0, 0], [np.pi / 2, 0, 0]), 2 * BUDGET.epsilon
    for x, y in ((0.6, 0.6), (0.8, 0.3), (-0.3, 0.3), (0.95, 0.95)):
        hit = exact_sweep_collides(quarter, cube(x, y), step)
        assert hit == sweep_collides(quarter, cube(x, y), BUDGET)
    assert exact_sweep_collides(quarter, cube(0.5, 0.5, half=1.0), step), "inside all the way"
    rising = MovingGroup(1, IDENTITY, cube().enclosure, cube().mesh)
    up = Motion(slide(IDENTITY), (rising,), np.array([[0.0], [2.0]]))
    later = Motion(slide(move(0.15, 0, 2.0)), (rising,), np.array([[0.0], [2.0]]))
    aside = Motion(slide(move(0.22, 0, 0.0)), (rising,), np.array([[0.0], [2.0]]))
    assert exact_sweep_collides(up, later, step)
    assert not exact_sweep_collides(up, aside, step)


def test_bodies_without_meshes_are_refused():
    bare = FixedGroup(IDENTITY, Enclosure((box([0.1] * 3),), 0.0))
    for ask in (exact_collides, exact_includes, exact_distance):
        with pytest.raises(ValueError, match="needs the mesh"):
            ask(cube(), bare)
