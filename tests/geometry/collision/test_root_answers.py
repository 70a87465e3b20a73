"""Roots and surfaces answer what they can: no child is made for it, and the answers are those of all parts."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from kabo.geometry import (
    CollisionView,
    Enclosure,
    ExactView,
    FixedGroup,
    MovingGroup,
    exact_collides,
    surfaces_touch,
)
from kabo.geometry.collision.root_answers import budget_of_roots
from tests.geometry.collision.test_part_trees import BUDGET, COARSE, rows, staircase, tree_of, view_of
from tests.geometry.worlds import box, move, three_joints


def solid(parts):
    """The triangles of some boxes (8, 3) each."""
    hulls = [trimesh.convex.convex_hull(part) for part in parts]
    whole = trimesh.util.concatenate(hulls)
    return np.array(whole.vertices, np.float64), np.array(whole.faces, np.int64)


def world(enclosure, touch=None):
    """Stairs on an arm between stairs that stand, with their triangles: a view, and the exact one."""
    mesh = solid(staircase())
    tool = MovingGroup(3, move(0.1, 0, 0), enclosure, mesh)
    around = [
        FixedGroup(move(*at), enclosure, mesh) for at in ((0.5, 0.5, 0.0), (-0.4, 0.5, -0.1), (0.3, -0.6, 0.0))
    ]
    parts = three_joints(), [tool], around, np.array([[0, 1], [0, 2], [0, 3]])
    exact = ExactView(*parts, BUDGET)
    return CollisionView(*parts, BUDGET, exact.surfaces_touch if touch is None else touch), exact


def test_answers_with_roots_and_surfaces_are_those_of_the_finest_parts():
    fine = Enclosure(tuple(staircase()), 0.0)
    tree, flat = world(tree_of(staircase(), []))[0], world(fine)[0]
    configurations = rows(800)
    found = tree.configurations_hit(configurations)
    assert np.array_equal(found, flat.configurations_hit(configurations))
    assert found.tolist() == [tree.configuration_hit(q) for q in configurations]
    assert 40 < (found >= 0).sum() < 400


def test_a_segment_is_free_where_the_finest_parts_show_it_and_never_where_surfaces_meet():
    tree, exact = world(tree_of(staircase(), []))
    flat, counts = world(Enclosure(tuple(staircase()), BUDGET.geometry))[0], [0, 0]
    for start in rows(150, 1):
        end = start + np.random.default_rng(7).uniform(-0.5, 0.5, 3)
        free = tree.segment_hit(start, end) < 0
        counts[free] += 1
        assert free or flat.segment_hit(start, end) >= 0
        if free:
            between = [start + share * (end - start) for share in np.linspace(0.0, 1.0, 20)]
            assert (exact.configurations_hit(np.array(between)) < 0).all()
    assert min(counts) > 10


def test_where_surfaces_meet_or_roots_are_apart_no_part_is_divided():
    made: list = []
    view, exact = world(tree_of(staircase(), made))
    roots = world(Enclosure(tree_of(staircase(), []).parts, 0.0))[0]
    decided = 0
    for q in rows(400):
        hit = roots.configuration_hit(q)
        if hit < 0 or exact.surfaces_touch(q, hit):
            assert view.configuration_hit(q) == hit
            decided += 1
    assert decided > 200 and not made


def test_segments_of_bodies_that_meet_or_stay_far_apart_divide_nothing():
    made: list = []
    view, exact = world(tree_of(staircase(), made))
    meeting = next(q for q in rows(400) if exact.configuration_hit(q) >= 0 and view.configuration_hit(q) >= 0)
    made.clear()
    assert view.segment_hit(meeting, meeting + 0.2) >= 0
    assert view.segment_hit(meeting - 0.2, meeting) >= 0
    away = np.array([-1.5, 0.0, 0.0])
    assert view.segment_hit(away, away + 0.01) == -1
    assert not made


def test_surfaces_are_asked_only_where_roots_are_not_apart():
    asked: list = []

    def touch(q, pair):
        asked.append((q, pair))
        return True

    view, _ = world(tree_of(staircase(), []), touch)
    assert view.configuration_hit(np.array([-1.5, 0.0, 0.0])) == -1 and not asked
    hits = view.configurations_hit(rows(50))
    assert [pair for _, pair in asked] == hits[hits >= 0].tolist()


def test_the_budget_of_roots_is_that_of_the_coarsest_tree_alone():
    tree, flat = tree_of(staircase(), []), Enclosure(tuple(staircase()), 0.0)
    assert budget_of_roots([flat, flat], BUDGET) is None
    coarse = budget_of_roots([flat, tree], BUDGET)
    assert coarse is not None and coarse.geometry == COARSE
    assert (coarse.sweep, coarse.clearance, coarse.numeric) == (BUDGET.sweep, BUDGET.clearance, BUDGET.numeric)
    assert budget_of_roots([tree], coarse) is None


def test_surfaces_touch_unless_bodies_are_apart_or_nested():
    def body(half, at):
        part = box(half)
        return FixedGroup(move(*at), Enclosure((part,), 0.0), solid([part]))

    large, small = body([0.1, 0.1, 0.1], (0, 0, 0)), body([0.02, 0.02, 0.02], (0, 0, 0))
    assert exact_collides(large, small) and not surfaces_touch(large, small)
    generator = np.random.default_rng(3)
    for _ in range(200):
        gap = generator.uniform(-0.03, 0.03)
        other = replace(small, world_T_group=move(0.12 + gap, *generator.uniform(-0.05, 0.05, 2)))
        assert surfaces_touch(large, other) == (gap <= 0.0)


def test_a_view_without_surfaces_divides_what_roots_do_not_decide():
    made: list = []
    tree = view_of(tree_of(staircase(), made))
    fine = view_of(Enclosure(tuple(staircase()), 0.0))
    assert np.array_equal(tree.configurations_hit(rows(50)), fine.configurations_hit(rows(50)))
    assert made
    with pytest.raises(ValueError, match="a configuration"):
        tree.segment_hit(np.zeros(2), np.zeros(2))


def test_what_is_free_early_divides_nothing_is_free_by_all_parts_and_does_not_depend_on_what_was_asked():
    made: list = []
    view, _ = world(tree_of(staircase(), made))
    starts = np.array(list(rows(200, 1)))
    ends = starts + np.random.default_rng(7).uniform(-0.5, 0.5, starts.shape)
    off = np.full(starts.shape, 1e-3)
    early = view.segments_free_early(starts, ends, off)
    assert not made and 20 < early.sum() < 180
    free = view.segments_hit(starts, ends, off) < 0
    assert made and not (early & ~free).any() and (free & ~early).any()
    assert np.array_equal(view.segments_free_early(starts, ends, off), early)
    again, _ = world(tree_of(staircase(), []))
    one_by_one = [
        again.segments_free_early(*(each[i : i + 1] for each in (starts, ends, off)))[0] for i in range(200)
    ]
    assert np.array_equal(one_by_one, early)
