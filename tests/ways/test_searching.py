"""The search for ways: valid paths, the same ones for the same key, names of what was in the way, shortcuts."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from kabo.errors import CutOff
from kabo.geometry import Budget, CollisionView, Enclosure, FixedGroup, MovingGroup
from kabo.kinematics import FrameFeature, KeptRows, projector, rows_of
from kabo.streams import stream_key
from kabo.ways import FreeSpace, NoPath, find_way, shortened
from kabo.ways.searching import MAX_CONSTRAINED_STEP
from tests.geometry.worlds import box, move, three_joints
from tests.kinematics.trees import planar
from tests.ways.worlds import LEFT, LOWER, RIGHT, UPPER, Discs, length, wall

KEY = stream_key("connect", 1)
DETOUR = np.array([LEFT, [-1.5, 1.9], [-0.2, 1.3], [0.2, 1.2], [1.2, 1.9], [1.9, 0.5], RIGHT])


def path_in(world, key=KEY, samples=3000, **more):
    return find_way(LEFT, RIGHT, world.space(), LOWER, UPPER, key, samples=samples, **more)


def test_the_straight_segment_is_taken_where_it_is_free():
    path = find_way(LEFT, LEFT + [0.5, 1.0], wall().space(), LOWER, UPPER, KEY, samples=0)
    assert np.array_equal(path, [LEFT, LEFT + [0.5, 1.0]])


@pytest.mark.parametrize("number", range(5))
@pytest.mark.parametrize("attempts", [0, 40])
def test_a_gap_in_the_wall_is_found(number, attempts):
    world = wall(gap=0.5)
    path = path_in(world, stream_key("gap", number), attempts=attempts)
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


@pytest.mark.parametrize("number", range(3))
def test_a_pocket_that_opens_towards_the_bounds_is_left(number):
    """Samples between the bounds lie on the other side of it: with these alone 1600 samples do not do."""

    def configurations(Q):
        x, y = Q[:, 0], Q[:, 1]
        inside = (x > 8) & (x < 9) & (y > 8) & (y < 9.2)
        around = (x > 7.7) & (x < 9.3) & (y > 7.7) & (y < 9.2)
        return np.where(around & ~inside, 0, -1)

    def segment(a, b):
        shares = np.linspace(0, 1, max(2, int(100 * np.linalg.norm(b - a))))
        return int(configurations(a + shares[:, None] * (b - a)).max())

    space, bound = FreeSpace(configurations, segment, 1), np.full(4, 10.0)
    goal = np.array([8.5, 8.5, 0, 0])
    path = find_way(np.zeros(4), goal, space, -bound, bound, stream_key("pocket", number), samples=1000)
    assert not isinstance(path, NoPath)
    assert all(segment(a, b) < 0 for a, b in pairwise(path))


def test_the_same_key_gives_the_same_path_and_another_key_another():
    paths = [path_in(wall(gap=0.5), stream_key("same")) for _ in range(2)]
    other = path_in(wall(gap=0.5), stream_key("other"))
    assert np.array_equal(*paths)
    assert not np.array_equal(paths[0], other)


def test_restarts_do_not_repeat_the_samples_before():
    """Two halves of a budget would be blocked by the same discs equally often if they were the same samples."""
    once, twice = path_in(wall(), samples=40), path_in(wall(), samples=80, restart=40)
    assert isinstance(once, NoPath)
    assert isinstance(twice, NoPath)
    assert (once.samples, twice.samples) == (40, 80)
    assert {pair: 2 * count for pair, count in once.hits.items()} != dict(twice.hits)


def test_way_points_are_rounded_as_plans_store_them():
    path = path_in(wall(gap=0.5), attempts=40)
    assert np.array_equal(path, np.round(path, 9))


def test_the_cheap_look_saves_proofs():
    """Edges that are blocked are mostly settled by configurations, not by proofs."""
    world = wall(radius=0.12)
    path_in(world, samples=300)
    assert world.segments < world.configurations / 4


def test_many_nodes_and_many_questions_find_room():
    """A maze of small discs: trees and answers outgrow the arrays that they begin with."""
    grid = np.array([(x, y) for x in np.arange(-2, 2.1, 0.25) for y in np.arange(-2, 2.1, 0.25)])
    grid = grid[np.min([np.abs(grid - end).max(axis=1) for end in (LEFT, RIGHT)], axis=0) > 0.2]
    world = Discs(np.concatenate([grid, wall(radius=0.05).centres]), np.full(len(grid) + 101, 0.05))
    found = path_in(world, samples=1500)
    assert isinstance(found, NoPath)
    assert found.samples == 1500


def test_who_looks_at_the_clock_can_end_a_search():
    looks = []

    def look():
        looks.append(1)
        if len(looks) > 20:
            raise CutOff

    world = wall()
    space = FreeSpace(world.free_configurations, world.free_segment, len(world.radii), look=look)
    with pytest.raises(CutOff):
        find_way(LEFT, RIGHT, space, LOWER, UPPER, KEY, samples=10**6)


def kept_height():
    """A planar arm, the rows that keep its hand at a height, and two configurations where they hold."""
    arm = planar(3, limits=3.0)
    tree = arm.tree
    hand = FrameFeature(3, "point", (0.5, 0, 0))
    rows = rows_of("height", hand, FrameFeature(0, "plane", (0, 1.0, 0), (0, 1, 0)), 0.0, 0.0)
    pull = projector(tree, rows, tree.lower, tree.upper, [True] * 3)
    ends = [np.round(pull(np.array(q)), 9) for q in ([0.9, -0.5, -0.8], [1.9, 0.6, 0.4])]
    return arm, KeptRows.of(tree, rows, [True] * 3, 1e-3), *ends


def nothing_hit(Q):
    return np.full(len(Q), -1, np.int64)


def test_a_path_under_a_constraint_keeps_it_all_along():
    """The hand of a planar arm stays at the same height to a millimetre."""
    arm, kept, start, goal = kept_height()
    tree, space = arm.tree, FreeSpace(nothing_hit, lambda a, b: -1, 0, kept=kept)
    path = find_way(start, goal, space, tree.lower, tree.upper, KEY, samples=2000, attempts=20)
    assert not isinstance(path, NoPath)
    assert len(path) > 3
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() <= 2 * MAX_CONSTRAINED_STEP + 1e-9
    for a, b in zip(path, path[1:], strict=False):
        for t in np.linspace(0, 1, 10):
            y = arm.poses(a + t * (b - a))[3].act(np.array([0.5, 0, 0]))[1]
            assert abs(y - 1.0) <= 1e-3


def test_where_only_the_constraint_is_broken_it_is_counted_behind_the_pairs():
    arm, kept, start, goal = kept_height()
    space = FreeSpace(nothing_hit, lambda a, b: -1, 5, kept=kept, projects=False)
    found = find_way(start, goal, space, arm.tree.lower, arm.tree.upper, KEY, samples=30)
    assert isinstance(found, NoPath)
    assert set(found.hits) == {5}


def test_a_kernel_that_checks_itself_finds_what_it_finds_by_asking():
    """An arm between two posts, by a view's arrays and by its answers: the same way, to the bit."""
    tree = three_joints()
    links = [MovingGroup(j, move(0.15, 0, 0), Enclosure((box([0.15, 0.03, 0.03]),), 0.0)) for j in (1, 2, 3)]
    posts = [
        FixedGroup(move(*place, 0.0), Enclosure((box([0.05] * 3),), 0.0)) for place in ((0.7, 0.0), (-0.5, 0.3))
    ]
    pairs = np.array([[0, 2], *((link, post) for link in (0, 1, 2) for post in (3, 4))])
    view = CollisionView(tree, links, posts, pairs, Budget.share(0.01))
    start, goal = np.array([-0.9, 0.1, 0.2]), np.array([0.9, -0.1, -0.2])
    asked = FreeSpace(view.configurations_hit, view.segment_hit, len(pairs))
    itself = replace(asked, checks=lambda: view.kernel_checks)
    undecided = replace(itself, checks=lambda: replace(view.kernel_checks, hit_counts=False))
    ways = [
        find_way(start, goal, space, tree.lower, tree.upper, KEY, samples=2000, attempts=20)
        for space in (asked, itself, undecided)
    ]
    assert len(ways[0]) > 2
    assert np.array_equal(ways[0], ways[1])
    assert np.array_equal(ways[0], ways[2])
    assert all(view.segment_hit(a, b) < 0 for a, b in pairwise(ways[0]))


def test_what_does_not_fit_is_refused():
    space = wall().space()
    with pytest.raises(ValueError, match="of one shape"):
        find_way(LEFT, RIGHT, space, LOWER[:1], UPPER, KEY, samples=1)
    with pytest.raises(ValueError, match="of one shape"):
        find_way(LEFT, RIGHT * np.nan, space, LOWER, UPPER, KEY, samples=1)


def test_a_detour_gets_shorter_and_stays_free():
    world = wall(gap=0.5)
    assert world.clearance(DETOUR) > 0
    short = shortened(DETOUR, world.space(), KEY, 100)
    assert length(short) < 0.9 * length(DETOUR)
    assert world.clearance(short) > 0
    assert np.array_equal(short[[0, -1]], DETOUR[[0, -1]])


def test_without_obstacles_little_remains_of_a_detour():
    nothing = Discs(np.empty((0, 2)), np.empty(0))
    short = shortened(DETOUR, nothing.space(looks=False), KEY, 100)
    assert length(short) < 1.05 * np.linalg.norm(RIGHT - LEFT)


def test_way_points_that_can_be_left_out_are_before_anything_is_drawn():
    asked, nothing = [], Discs(np.empty((0, 2)), np.empty(0))

    def segment(a, b):
        asked.append((a, b))
        return -1

    short = shortened(DETOUR, FreeSpace(nothing.free_configurations, segment, 1), KEY, 1)
    assert np.array_equal(short, [LEFT, RIGHT])
    assert len(asked) == 1


@pytest.mark.parametrize("gap", [0.2, 0.5])
def test_way_points_are_left_out_only_where_the_edge_is_free(gap):
    world = wall(gap=gap)
    short = shortened(DETOUR, world.space(), KEY, 1)
    assert 2 < len(short) < len(DETOUR)
    assert world.clearance(short) > 0


def test_a_straight_path_and_no_attempts_and_a_path_that_stands_still_are_left_alone():
    space = wall(gap=0.5).space()
    assert np.array_equal(shortened(DETOUR[:2], space, KEY, 50), DETOUR[:2])
    assert np.array_equal(shortened(DETOUR, space, KEY, 0), DETOUR)
    still = np.array([LEFT, LEFT, LEFT])
    assert np.array_equal(shortened(still, space, KEY, 10), still)


def test_a_piece_that_is_not_proven_in_the_end_brings_the_path_back_that_was():
    """The proof of whatever touches a way point that stays is refused: shortcuts are found, remainders are not proven."""
    corners = {tuple(q) for q in DETOUR}
    nothing = Discs(np.empty((0, 2)), np.empty(0))

    def segment(a, b):
        return 0 if tuple(a) in corners or tuple(b) in corners else -1

    space = FreeSpace(nothing.free_configurations, segment, 1)
    assert np.array_equal(shortened(DETOUR, space, KEY, 20), DETOUR)


def test_patience_ends_after_so_many_attempts_in_vain() -> None:
    asked = []

    def blocked(q0: np.ndarray, q1: np.ndarray) -> int:
        asked.append(1)
        return 0

    path = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]])
    assert np.array_equal(shortened(path, FreeSpace(None, blocked, 1), KEY, 100, patience=5), path)
    assert 0 < len(asked) <= 5
