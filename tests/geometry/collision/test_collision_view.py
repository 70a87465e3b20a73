"""Collision views: what they refuse, what they answer, and that nothing but the question decides."""

import dataclasses

import numpy as np
import pytest

from kabo.geometry import Budget, CollisionView, Enclosure, FixedGroup, MovingGroup
from kabo.geometry.collision.collision_view import FREE
from kabo.geometry.collision.kernels.bundles import ITERATIONS, SEARCHES
from kabo.geometry.collision.kernels.configuration_check import first_hit
from kabo.meshes import Rounding
from kabo.scene import PRISMATIC
from tests.geometry.worlds import box, move, one_joint, rng_rows, slide, three_joints
from tests.support.strategies import IDENTITY

BUDGET = Budget.share(0.01)
CUBE = Enclosure((box([0.1, 0.1, 0.1]),), 0.0)
FINE = np.array([0.3])
UNUSABLE = [[np.nan], [-np.nan], [np.inf], [-np.inf], [2.2], [], [0.3, 0.3], [[0.3]]]


def sliding_cube(fixed=((0, 0, 0.5),), enclosure=CUBE, budget=BUDGET, pairs=None):
    """A cube at z = q below (or above) cubes at fixed places."""
    pairs = [[0, 1 + i] for i in range(len(fixed))] if pairs is None else pairs
    groups = [FixedGroup(move(*place), CUBE) for place in fixed]
    return CollisionView(slide(IDENTITY), [MovingGroup(1, IDENTITY, enclosure)], groups, np.array(pairs), budget)


def chain_view():
    """Three turning joints with a box each, and two boxes in the world; all pairs that are not neighbours."""
    links = [MovingGroup(j, move(0.15, 0, 0), Enclosure((box([0.15, 0.03, 0.03]),), 0.0)) for j in (1, 2, 3)]
    fixed = [FixedGroup(move(*p), CUBE) for p in ((0.4, 0.4, 0.0), (-0.5, 0.1, 0.1))]
    pairs = np.array([[2, 4], [0, 3], [0, 2], [1, 3], [2, 3], [1, 4]])
    return CollisionView(three_joints(), links, fixed, pairs, BUDGET)


@pytest.mark.parametrize("q", UNUSABLE)
def test_a_configuration_that_is_not_usable_is_an_error_and_never_free(q):
    view = sliding_cube()
    for ask in (
        view.configuration_hit,
        lambda q: view.configurations_hit([q]),
        lambda q: view.segment_hit(q, FINE),
        lambda q: view.segment_hit(FINE, q),
    ):
        with pytest.raises(ValueError, match="configuration"):
            ask(np.array(q))


def test_one_bad_configuration_among_good_ones_is_an_error():
    with pytest.raises(ValueError, match="finite"):
        sliding_cube().configurations_hit(np.array([[0.0], [np.nan], [0.4]]))


def test_configurations_of_another_size_are_not_cut_into_rows():
    with pytest.raises(ValueError, match="configurations are"):
        chain_view().configurations_hit(np.zeros((3, 6)))
    assert chain_view().configurations_hit(np.zeros((0, 3))).tolist() == []


def test_integers_and_strided_rows_are_taken_as_numbers():
    assert sliding_cube().configuration_hit(np.array([0])) == FREE
    assert sliding_cube().configurations_hit(np.array([[0.0, 9.0], [0.4, 9.0]])[:, :1]).tolist() == [FREE, 0]


@pytest.mark.parametrize("deviation", [BUDGET.geometry * 1.001, 1.0, np.inf, np.nan])
def test_an_enclosure_that_breaks_the_budget_is_refused(deviation):
    with pytest.raises(ValueError, match="an enclosure deviates"):
        sliding_cube(enclosure=dataclasses.replace(CUBE, deviation=deviation))


@pytest.mark.parametrize("pairs", [[[0.0, 1.0]], [[0, 2]], [[1, 0]], [[-1, 1]], [[0, -1]]])
def test_pairs_that_name_nothing_or_are_no_integers_are_refused(pairs):
    with pytest.raises(ValueError, match="pair"):
        sliding_cube(pairs=pairs)


def test_vertices_poses_and_joints_are_validated():
    tree, pairs = slide(IDENTITY), np.array([[0, 0]])
    for group in (
        MovingGroup(1, IDENTITY, Enclosure((CUBE.parts[0].astype(np.float32),), 0.0)),
        MovingGroup(1, IDENTITY, Enclosure((CUBE.parts[0] * np.nan,), 0.0)),
        MovingGroup(1, IDENTITY * np.nan, CUBE),
        MovingGroup(2, IDENTITY, CUBE),
        MovingGroup(-1, IDENTITY, CUBE),
        MovingGroup(1, move(1e6, 0, 0), CUBE),
    ):
        with pytest.raises(ValueError):
            CollisionView(tree, [group], [], pairs, BUDGET)


@pytest.mark.parametrize("field, value", [("upper", np.inf), ("placement", np.nan), ("ratio", np.inf)])
def test_a_tree_without_bounds_or_with_values_that_are_not_finite_is_refused(field, value):
    tree = one_joint(IDENTITY, PRISMATIC)
    broken = tree._replace(**{field: np.full_like(getattr(tree, field), value)})
    with pytest.raises(ValueError, match="finite"):
        CollisionView(broken, [MovingGroup(1, IDENTITY, CUBE)], [], np.zeros((0, 2), np.int64), BUDGET)


def test_the_number_is_that_of_the_callers_pair():
    places = ((5, 0, 0), (0, 0, 0.5), (0, 0, -0.5))
    view = sliding_cube(places, pairs=[[0, 3], [0, 1], [0, 2]])
    assert [view.configuration_hit([z]) for z in (0.0, 0.4, -0.4)] == [FREE, 2, 0]
    assert view.segment_hit([0.0], [0.4]) == 2
    assert view.segment_hit([-0.2], [0.2]) == FREE


def test_more_bodies_than_one_word_has_bits_and_a_pair_given_twice():
    view = sliding_cube([(1, 0, 0.5 * i) for i in range(70)] + [(0, 0, 0.5)], pairs=[[0, 71], [0, 71], [0, 40]])
    assert [view.configuration_hit([z]) for z in (0.0, 0.4)] == [FREE, 0]
    places = [(0.05 * i, 5.0, 0.0) for i in range(70)]
    for last in (0, 30, 31, 32, 33, 63, 64, 69):
        places[last] = (0, 0, 0.5)
        assert sliding_cube(places).configuration_hit([0.4]) == last
        places[last] = (0.05 * last, 5.0, 0.0)


def test_compiled_and_original_check_agree():
    view, hits = chain_view(), set()
    for q in rng_rows(2, 60, 3):
        found = view.configuration_hit(q)
        assert first_hit.py_func(q, view._memory) == found
        hits.add(found)
    assert len(hits) > 2


def test_without_pairs_or_bodies_everything_is_free():
    for moving in ([], [MovingGroup(1, IDENTITY, CUBE)]):
        view = CollisionView(slide(IDENTITY), moving, [], np.zeros((0, 2), np.int64), BUDGET)
        assert view.configuration_hit([0.0]) == FREE == view.segment_hit([-1.0], [1.0])


def test_a_segment_through_a_body_is_a_hit_though_both_ends_are_free():
    view = sliding_cube()
    assert view.configurations_hit([[0.0], [1.0]]).tolist() == [FREE, FREE]
    assert view.segment_hit([0.0], [1.0]) == view.segment_hit([1.0], [0.0]) == 0


def test_a_segment_of_no_length_answers_as_its_configuration():
    view = chain_view()
    for q in rng_rows(1, 200, 3):
        assert (view.segment_hit(q, q) == FREE) >= (view.configuration_hit(q) == FREE)


def test_two_moving_bodies_are_checked_where_both_are():
    tree = three_joints()
    arms = [MovingGroup(j, move(0.15, 0, 0), CUBE) for j in (1, 3)]
    view = CollisionView(tree, arms, [], np.array([[0, 1]]), BUDGET)
    assert view.configuration_hit([0.0, 0.0, 0.0]) == FREE
    assert view.configuration_hit([0.7, 2.6, 2.6]) == 0  # folded back
    assert view.segment_hit([0.0, 0.0, 0.0], [3.0, 0.0, 0.0]) == FREE  # both turn alike
    assert view.segment_hit([0.0, 0.0, 0.0], [0.0, 2.6, 2.6]) == 0


def test_an_attached_body_moves_with_its_joint():
    bar = MovingGroup(3, move(0.5, 0, 0), Enclosure((box([0.5, 0.02, 0.02]),), 0.0))
    view = CollisionView(three_joints(), [bar], [FixedGroup(move(0, 1.4, 0), CUBE)], np.array([[0, 1]]), BUDGET)
    assert view.configuration_hit([0.0, 0.0, 0.0]) == FREE
    assert view.configuration_hit([np.pi / 2, 0.0, 0.0]) == 0
    assert view.segment_hit([0.0, 0.0, 0.0], [np.pi, 0.0, 0.0]) == 0


def test_answers_do_not_depend_on_earlier_questions():
    rows, used = rng_rows(0, 120, 3), chain_view()
    first = [used.configuration_hit(q) for q in rows]
    swept = [used.segment_hit(a, b) for a, b in zip(rows, rows[1:], strict=False)]
    assert len(set(first)) > 2
    assert len(set(swept)) > 2
    with pytest.raises(ValueError):
        used.segment_hit(rows[0], rows[0] * np.nan)
    assert [chain_view().configuration_hit(q) for q in rows[:20]] == first[:20]
    assert [chain_view().segment_hit(a, b) for a, b in zip(rows, rows[1:20], strict=False)] == swept[:19]
    backwards = [used.segment_hit(rows[i], rows[i + 1]) for i in reversed(range(len(rows) - 1))]
    assert backwards[::-1] == swept
    assert used.configurations_hit(rows).tolist() == first


@pytest.mark.parametrize("seed", range(10))
def test_segments_asked_together_are_answered_as_each_alone(seed):
    """The deviation of one segment is not that of the next, and none is left behind for later questions."""
    rows, used = rng_rows(seed, 60, 3), chain_view()
    off = np.random.default_rng(seed).choice([0.0, 0.01, 0.2], (59, 3))
    alone = [chain_view().segment_hit(*row) for row in zip(rows, rows[1:], off, strict=False)]
    plain = [chain_view().segment_hit(*row) for row in zip(rows, rows[1:], strict=False)]
    assert used.segments_hit(rows[:-1], rows[1:], off).tolist() == alone != plain
    assert used.segments_hit(rows[:-1], rows[1:], np.zeros((59, 3))).tolist() == plain
    asked = used.counters.numbers
    with pytest.raises(ValueError, match="configuration"):
        used.segments_hit(rows[:-1], np.where(np.arange(59)[:, None] == 30, np.nan, rows[1:]), off)
    assert used.counters.numbers[1] == asked[1] + 31
    assert [used.segment_hit(*row) for row in zip(rows, rows[1:], strict=False)] == plain


def drawn_view(seed):
    """Three turning joints with two random parts each, some of them round, and four bodies in the world."""
    rng = np.random.default_rng(seed)

    def drawn(size):
        points = [rng.uniform(-size, size, (int(rng.integers(4, 30)), 3)) for _ in range(2)]
        rounds = [Rounding(float(radius)) for radius in rng.choice([0.0, 0.03], 2)]
        return Enclosure(tuple(points), 0.0, tuple(rounds))

    links = [MovingGroup(j, move(0.15, 0, 0), drawn(0.12)) for j in (1, 2, 3)]
    fixed = [FixedGroup(move(*rng.uniform([-0.8, -0.8, -0.3], [0.8, 0.8, 0.3])), drawn(0.08)) for _ in range(4)]
    pairs = np.array([[0, 2], *([link, body] for link in range(3) for body in range(3, 7))])
    return CollisionView(three_joints(), links, fixed, pairs, BUDGET)


def test_axes_that_are_known_save_rounds_and_change_no_answer_or_count():
    rounds, seen = {"used": 0, "alone": 0}, set()
    for seed in range(20):
        walk = np.clip(np.random.default_rng(seed).normal(0.0, 0.15, (81, 3)).cumsum(axis=0), -3.1, 3.1)
        starts, ends, off = walk[:-1].copy(), walk[1:].copy(), np.zeros((80, 3))
        used, alone, counts = drawn_view(seed), [], np.zeros(8, np.int64)
        for row in zip(starts, ends, off, strict=True):
            view = drawn_view(seed)
            alone.append(view.segment_hit(*row))
            counts += view._own.counts
        seen.update(alone)
        for _ in range(2):
            before = used._own.counts.copy()
            assert used.segments_hit(starts, ends, off).tolist() == alone
            own = used._own.counts - before
            assert own[SEARCHES] == counts[SEARCHES]
            rounds["used"] += int(own[ITERATIONS])
            rounds["alone"] += int(counts[ITERATIONS])
    assert len(seen) > 5
    assert rounds["used"] < 0.95 * rounds["alone"]


def test_counters_count():
    view = sliding_cube()
    view.configuration_hit([0.0])  # far away: no narrow phase
    assert (view.counters.configuration_checks, view.counters.pair_checks, view.counters.positive) == (1, 0, 0)
    view.configuration_hit([0.4])
    view.configurations_hit([[0.0], [0.4], [0.5]])
    assert (view.counters.configuration_checks, view.counters.pair_checks, view.counters.positive) == (5, 3, 3)
    view.segment_hit([0.0], [1.0])
    assert (view.counters.sweep_checks, view.counters.positive) == (1, 4)
    assert view.counters.pair_checks > 3
