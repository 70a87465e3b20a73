"""Trees of parts: the answers are those of the finest parts, are the same whatever is known, and little is refined."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from kabo.geometry import (
    Budget,
    CollisionView,
    Enclosure,
    FixedGroup,
    InnerSolid,
    Motion,
    MovingGroup,
    collides,
    distance,
    includes,
    sweep_collides,
    swept_volume,
)
from kabo.geometry.collision.part_trees import Cover, finest, known
from kabo.geometry.triangles.hulls import hull_mesh
from tests.geometry.worlds import box, move, three_joints

BUDGET = Budget.share(0.01)
COARSE = 0.05  # the deviation of what is not divided [m]


def hull_of(*parts):
    points = np.concatenate(parts)
    return np.ascontiguousarray(points[ConvexHull(points).vertices])


def staircase(steps=4):
    """Boxes that climb, as the finest parts of a body."""
    return [box([0.05, 0.05, 0.02]) + [0.1 * k, 0.0, 0.05 * k] for k in range(steps)]


def tree_of(leaves, made):
    """A tree over 2^n leaves in which only the root is known; `made` collects which ranges of leaves are divided."""

    def enclosure(nodes, children):
        parts = tuple(hull_of(*leaves[a:b]) for a, b in nodes)
        deviations = tuple(0.0 if b - a == 1 else COARSE for a, b in nodes)

        def finer(part):
            low, high = nodes[part]
            made.append((low, high))
            middle = (low + high) // 2
            divided = list(children)
            divided[part] = (len(nodes), 2)
            return enclosure([*nodes, (low, middle), (middle, high)], [*divided, (0, 0), (0, 0)])

        coarse = max(d for d, (_, n) in zip(deviations, children, strict=True) if n == 0)
        return Enclosure(parts, coarse, (), deviations, tuple(children), 1, finer)

    return enclosure([(0, len(leaves))], [(0, 0)])


def view_of(enclosure, budget=BUDGET):
    links = [MovingGroup(j, move(0.15, 0, 0), Enclosure((box([0.15, 0.03, 0.03]),), 0.0)) for j in (1, 2)]
    tool = MovingGroup(3, move(0.1, 0, 0), enclosure)
    around = [FixedGroup(move(*at), enclosure) for at in ((0.5, 0.5, 0.0), (-0.4, 0.5, -0.1), (0.3, -0.6, 0.0))]
    pairs = np.array([[0, 2], *((i, 3 + k) for i in range(3) for k in range(3))])
    return CollisionView(three_joints(), [*links, tool], around, pairs, budget)


def rows(count, key=0):
    return np.random.default_rng(key).uniform(-3.0, 3.0, (count, 3))


def test_a_tree_answers_as_its_finest_parts_do_and_is_not_divided_without_need():
    made: list = []
    tree, fine = view_of(tree_of(staircase(), made)), view_of(Enclosure(tuple(staircase()), 0.0))
    far = tree.configurations_hit(np.array([[-1.5, 0.0, 0.0]]))
    assert far.tolist() == [-1] and not made, "bodies that are far apart need no children"
    configurations = rows(400)
    found = tree.configurations_hit(configurations)
    assert np.array_equal(found, fine.configurations_hit(configurations))
    assert 0.1 < (found >= 0).mean() < 0.9
    assert made and len(made) == len(set(made)), "each is divided once, for all groups and views"


def test_a_sweep_of_trees_answers_as_its_finest_parts_do():
    made: list = []
    # The same share for both: deviations of leaves count as the budget's share where there is a tree.
    leaves = tuple(staircase())
    tree, fine = view_of(tree_of(leaves, made)), view_of(Enclosure(leaves, BUDGET.geometry))
    starts, found = rows(150, 1), []
    for start in starts:
        end = start + np.random.default_rng(7).uniform(-0.5, 0.5, 3)
        found.append(tree.segment_hit(start, end))
        assert (found[-1] >= 0) == (fine.segment_hit(start, end) >= 0)
    assert made and 0.1 < np.mean(np.array(found) >= 0) < 0.9


def test_counts_and_answers_do_not_depend_on_what_was_refined_before():
    first, second = tree_of(staircase(), []), tree_of(staircase(), [])
    used = view_of(second)
    used.configurations_hit(rows(300, 5))
    counted = []
    for enclosure in (first, second):
        view = view_of(enclosure)
        hits = [view.configuration_hit(q) for q in rows(40, 2)]
        hits += [view.segment_hit(q, q + 0.3) for q in rows(20, 3)]
        counted.append((hits, view.counters))
    assert counted[0] == counted[1]


def test_parts_near_enough_are_not_divided_even_if_their_children_are_known():
    made: list = []
    enclosure = tree_of(staircase(), made)
    view_of(enclosure).configurations_hit(rows(300))
    whole = known(enclosure)
    assert len(whole.parts) > 1
    loose = Budget.share(0.2)  # its share for a body is more than the root deviates
    tree, root = view_of(whole, loose), view_of(Enclosure(whole.parts[:1], COARSE), loose)
    assert np.array_equal(tree.configurations_hit(rows(200)), root.configurations_hit(rows(200)))


def test_a_part_that_stays_too_coarse_is_refused():
    coarse = replace(tree_of(staircase(), []), finer=None)
    with pytest.raises(ValueError, match=r"deviates by 0\.05 m, the budget allows 0\.004 m"):
        view_of(coarse)


def test_predicates_of_standing_and_moving_bodies_divide_where_they_must():
    made: list = []
    tree, fine = tree_of(staircase(), made), Enclosure(tuple(staircase()), 0.0)
    below = box([0.02, 0.05, 0.02]) + [0.3, 0.0, 0.08]  # in the hull, under the stairs
    thing = FixedGroup(move(0, 0, 0), Enclosure((below,), 0.0))
    stairs, plain = (FixedGroup(move(0, 0, 0), e) for e in (tree, fine))
    assert not collides(stairs, FixedGroup(move(9, 0, 0), fine), BUDGET) and not made
    assert not collides(plain, thing, BUDGET)
    assert not collides(stairs, thing, BUDGET) and made
    lowered = FixedGroup(move(0, 0, 0.06), thing.enclosure)
    assert collides(stairs, lowered, BUDGET) and collides(plain, lowered, BUDGET)
    assert distance(stairs, thing).lower == 0.0, "of the root alone"
    assert distance(stairs, thing, BUDGET.geometry).lower == pytest.approx(distance(plain, thing).lower)
    inside = InnerSolid(move(0, 0, 0), *hull_mesh(box([1.0, 1.0, 1.0])), 0.0)
    assert includes(inside, stairs, BUDGET)
    standing = Motion(three_joints(), (MovingGroup(3, move(0, 0, 0), tree),), np.zeros((1, 3)))
    assert not sweep_collides(standing, FixedGroup(move(0.6, 0, 0), thing.enclosure), BUDGET)
    assert sweep_collides(standing, FixedGroup(move(0.6, 0, 0.06), thing.enclosure), BUDGET)
    assert len(swept_volume(standing, 0.001).hulls) == 4


def test_a_cover_is_its_parts_in_order():
    tree = tree_of(staircase(), [])
    cover = Cover.of(tree).divided(0).divided(0)
    assert len(cover.enclosure.parts) == 3
    assert cover.enclosure.deviations == (0.0, 0.0, COARSE)
    assert len(finest(tree, 0.0).parts) == 4
    flat = Enclosure(tuple(staircase()), 0.0)
    assert finest(flat, 0.0) is flat
