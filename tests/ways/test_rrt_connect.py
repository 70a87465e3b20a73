"""RRT-Connect: valid paths, the same ones for the same key, and names of what was in the way."""

import numpy as np
import pytest

from kabo.kinematics import FrameFeature, keeps, projector, rows_of
from kabo.streams import stream_key
from kabo.ways import NoPath, connect
from kabo.ways.edges import MAX_CONSTRAINED_STEP
from tests.kinematics.trees import planar
from tests.ways.worlds import LEFT, LOWER, RIGHT, UPPER, Discs, wall

KEY = stream_key("connect", 1)


def path_in(world, key=KEY, samples=3000, **more):
    return connect(
        LEFT, RIGHT, world.free_segment, world.free_configurations, LOWER, UPPER, key, samples=samples, **more
    )


def test_the_straight_segment_is_taken_where_it_is_free():
    world = wall()
    path = connect(
        LEFT, LEFT + [0.5, 1.0], world.free_segment, world.free_configurations, LOWER, UPPER, KEY, samples=0
    )
    assert np.array_equal(path, [LEFT, LEFT + [0.5, 1.0]])


@pytest.mark.parametrize("number", range(5))
def test_a_gap_in_the_wall_is_found(number):
    world = wall(gap=0.5)
    path = path_in(world, stream_key("gap", number))
    assert not isinstance(path, NoPath)
    assert np.array_equal(path[0], LEFT)
    assert np.array_equal(path[-1], RIGHT)
    assert world.clearance(path) > 0
    assert np.all((path >= LOWER) & (path <= UPPER))


def test_a_closed_wall_is_named_and_the_budget_is_used_up():
    world = wall()
    found = path_in(world, samples=200)
    assert isinstance(found, NoPath)
    assert found.samples == 200
    assert sum(found.hits.values()) > 100
    assert all(0 <= number < len(world.radii) for number in found.hits)


def test_a_start_or_goal_in_contact_is_named_before_anything_is_sampled():
    world = Discs(np.array([[5.0, 5.0], RIGHT]), np.array([0.1, 0.1]))
    found = path_in(world)
    assert isinstance(found, NoPath)
    assert (dict(found.hits), found.samples) == ({1: 1}, 0)


def test_the_same_key_gives_the_same_path_and_another_key_another():
    paths = [path_in(wall(gap=0.5), stream_key("same")) for _ in range(2)]
    other = path_in(wall(gap=0.5), stream_key("other"))
    assert np.array_equal(*paths)
    assert not np.array_equal(paths[0], other)


def test_restarts_do_not_repeat_the_samples_before():
    world = wall()
    blocked = path_in(world, samples=60, restart=20)
    assert blocked.samples == 60
    assert world.segments < 400


def test_way_points_are_rounded_as_plans_store_them():
    path = path_in(wall(gap=0.5))
    assert np.array_equal(path, np.round(path, 9))


def test_the_cheap_look_saves_proofs():
    """Edges that are blocked are mostly settled by configurations, not by proofs."""
    world = wall(radius=0.12)
    path_in(world, samples=300)
    assert world.segments < world.configurations / 4


def test_a_path_under_a_constraint_keeps_it_all_along():
    """The hand of a planar arm stays at the same height to a millimetre while it passes a pole."""
    arm = planar(3, limits=3.0)
    tree = arm.tree
    hand = FrameFeature(3, "point", (0.5, 0, 0))
    rows = rows_of("height", hand, FrameFeature(0, "plane", (0, 1.0, 0), (0, 1, 0)), 0.0, 0.0)
    pull = projector(tree, rows, tree.lower, tree.upper, [True] * 3)
    start, goal = (np.round(pull(np.array(q)), 9) for q in ([0.9, -0.5, -0.8], [1.9, 0.6, 0.4]))

    def free_segment(q0, q1):
        if not keeps(tree, rows, q0, q1, 1e-3):
            return 7
        return -1

    def free_configurations(Q):
        return np.full(len(Q), -1, np.int64)

    path = connect(
        start, goal, free_segment, free_configurations, tree.lower, tree.upper, KEY, samples=2000, projection=pull
    )
    assert not isinstance(path, NoPath)
    assert len(path) > 3
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 2 * MAX_CONSTRAINED_STEP + 1e-9
    for a, b in zip(path, path[1:], strict=False):
        for t in np.linspace(0, 1, 10):
            y = arm.poses(a + t * (b - a))[3].act(np.array([0.5, 0, 0]))[1]
            assert abs(y - 1.0) <= 1e-3


def test_what_does_not_fit_is_refused():
    world = wall()
    with pytest.raises(ValueError, match="of one shape"):
        connect(LEFT, RIGHT, world.free_segment, world.free_configurations, LOWER[:1], UPPER, KEY, samples=1)
    with pytest.raises(ValueError, match="of one shape"):
        connect(LEFT, RIGHT * np.nan, world.free_segment, world.free_configurations, LOWER, UPPER, KEY, samples=1)
