"""Exact views: the original meshes through python-fcl, against the bounded views."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from kabo.geometry import Budget, CollisionView, Enclosure, ExactView, FixedGroup, MovingGroup
from kabo.geometry.collision.collision_view import FREE
from tests.geometry.worlds import box, move, rng_rows, slide, three_joints
from tests.support.strategies import IDENTITY

BUDGET = Budget.share(0.01)
PAIRS = np.array([[0, 2], [0, 3], [1, 3], [2, 3], [1, 4], [2, 4]])


def solid(half):
    """The enclosure and the mesh of a box."""
    vertices = box(half)
    return Enclosure((vertices,), 0.0), (vertices, ConvexHull(vertices).simplices.astype(np.int64))


def views(grow=0.0, kind=ExactView):
    """A chain of three boxes and two boxes in the world, all `grow` larger on each side."""
    link, cube = solid(np.array([0.15, 0.03, 0.03]) + grow), solid(np.full(3, 0.1) + grow)
    moving = [MovingGroup(j, move(0.15, 0, 0), *link) for j in (1, 2, 3)]
    fixed = [FixedGroup(move(*p), *cube) for p in ((0.4, 0.4, 0.0), (-0.5, 0.1, 0.1))]
    return kind(three_joints(), moving, fixed, PAIRS, BUDGET)


def test_both_views_agree_outside_the_band_of_epsilon():
    rows = rng_rows(0, 60, 3)
    bounded, exact = views(kind=CollisionView).configurations_hit(rows), views().configurations_hit(rows)
    # Boxes grown by half of epsilon on each side are nearer than epsilon times sqrt(3) wherever they touch.
    grown = views(0.5 * BUDGET.epsilon).configurations_hit(rows)
    assert (bounded[exact != FREE] != FREE).all()
    assert (bounded[grown == FREE] == FREE).all()
    assert 6 < (exact != FREE).sum() < 54


def test_both_views_agree_on_segments_outside_the_band():
    rows = rng_rows(3, 12, 3)
    bounded, exact, grown = views(kind=CollisionView), views(), views(0.5 * BUDGET.epsilon)
    seen = set()
    for start, end in zip(rows, rows[1:], strict=False):
        end = start + 0.2 * (end - start)
        answer = bounded.segment_hit(start, end)
        seen.add(answer == FREE)
        assert answer != FREE or exact.segment_hit(start, end) == FREE
        assert answer == FREE or grown.segment_hit(start, end) != FREE
    assert seen == {True, False}


def cube_view(place=(0.0, 0.0, 0.5), mesh=True):
    """A cube that slides along z, and a cube in its way."""
    enclosure, faces = solid([0.1, 0.1, 0.1])
    moving = [MovingGroup(1, IDENTITY, enclosure, faces)]
    return ExactView(
        slide(IDENTITY),
        moving,
        [FixedGroup(move(*place), enclosure, faces if mesh else None)],
        np.array([[0, 1]]),
        BUDGET,
    )


@pytest.mark.parametrize("height", [0.11, 0.317, 0.51, 0.99])
def test_a_plate_as_thin_as_paper_is_not_passed_through(height):
    enclosure, faces = solid([0.1, 0.1, 0.0002])
    moving = [MovingGroup(1, IDENTITY, enclosure, faces)]
    fixed = [FixedGroup(move(0, 0, height), enclosure, faces)]
    view = ExactView(slide(IDENTITY), moving, fixed, np.array([[0, 1]]), BUDGET)
    assert view.segment_hit([0.0], [1.0]) == 0
    assert view.segment_hit([0.0], [height - 0.0004 - BUDGET.clearance]) == FREE
    assert view.segment_hit([height + 0.0004 + BUDGET.clearance], [1.1]) == FREE


def test_what_is_free_on_a_segment_touches_at_no_sample_of_it():
    rows, view, seen = rng_rows(11, 24, 3), views(), set()
    for start, end in zip(rows, rows[1:], strict=False):
        end = start + 0.15 * (end - start)
        free = view.segment_hit(start, end) == FREE
        touching = (view.configurations_hit(np.linspace(start, end, 60)) != FREE).any()
        seen.add((free, bool(touching)))
        assert not (free and touching)
    assert {(True, False), (False, True)} <= seen


def test_segments_are_seen_between_their_ends():
    view = cube_view()
    assert view.configurations_hit([[0.0], [1.0]]).tolist() == [FREE, FREE]
    assert view.segment_hit([0.0], [1.0]) == 0
    assert view.segment_hit([-1.0], [0.2]) == FREE


def test_only_the_pairs_that_are_asked_for_count():
    enclosure, mesh = solid([0.1, 0.1, 0.1])
    cubes = [MovingGroup(1, IDENTITY, enclosure, mesh)], [FixedGroup(IDENTITY, enclosure, mesh)]
    assert ExactView(slide(IDENTITY), *cubes, np.zeros((0, 2), np.int64), BUDGET).configuration_hit([0.05]) == FREE
    assert ExactView(slide(IDENTITY), *cubes, np.array([[0, 1]]), BUDGET).configuration_hit([0.05]) == 0


def test_a_group_without_a_mesh_is_refused():
    with pytest.raises(ValueError, match="needs the mesh"):
        cube_view(mesh=False)


@pytest.mark.parametrize("q", [[np.nan], [np.inf], [], [0.1, 0.2], [[0.1]]])
def test_a_configuration_that_is_not_usable_is_an_error(q):
    for ask in (cube_view().configuration_hit, lambda q: cube_view().segment_hit([0.0], q)):
        with pytest.raises(ValueError, match="finite values"):
            ask(np.array(q))


def test_counters_count():
    view = cube_view()
    view.configurations_hit([[0.0], [0.45]])
    assert (view.counters.configuration_checks, view.counters.positive) == (2, 1)
    view.segment_hit([0.0], [1.0])
    assert (view.counters.sweep_checks, view.counters.positive) == (1, 2)


def nested(inner=0.1, outer=0.5, hollow=None):
    """A cube that slides along z inside a larger one, which may have a cubic hollow."""
    small, (vertices, faces) = solid([inner] * 3), solid([outer] * 3)[1]
    if hollow is not None:
        cavity, inward = solid([hollow] * 3)[1]
        faces = np.concatenate([outward(vertices, faces), outward(cavity, inward)[:, ::-1] + len(vertices)])
        vertices = np.concatenate([vertices, cavity])
    large = Enclosure((box([outer] * 3),), 0.0), (vertices, np.ascontiguousarray(faces))
    return small, large


def outward(vertices, faces):
    """The faces of a convex body about the origin, turned outwards."""
    corners = vertices[faces]
    turned = np.einsum(
        "ij,ij->i", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), corners[:, 0]
    )
    return np.where(turned[:, None] < 0, faces[:, ::-1], faces)


@pytest.mark.parametrize("moves", ["inner", "outer"])
def test_a_body_wholly_inside_another_touches_it(moves):
    small, large = nested()
    first, second = (small, large) if moves == "inner" else (large, small)
    view = ExactView(
        slide(IDENTITY),
        [MovingGroup(1, IDENTITY, *first)],
        [FixedGroup(move(0, 0, 0.1), *second)],
        np.array([[0, 1]]),
        BUDGET,
    )
    assert view.configurations_hit([[0.0], [0.1], [0.75]]).tolist() == [0, 0, FREE]


def test_a_body_in_the_hollow_of_another_is_free():
    small, large = nested(hollow=0.4)
    view = ExactView(
        slide(IDENTITY),
        [MovingGroup(1, IDENTITY, *small)],
        [FixedGroup(IDENTITY, *large)],
        np.array([[0, 1]]),
        BUDGET,
    )
    assert view.configurations_hit([[0.0], [0.29], [0.31], [0.45], [0.65]]).tolist() == [FREE, FREE, 0, 0, FREE]


def test_pairs_whose_boxes_do_not_meet_and_pairs_not_asked_for_cost_nothing():
    enclosure, mesh = solid([0.1, 0.1, 0.1])
    places = [(0, 0, 0), (0, 0, 5), (0, 0, 0.5)]
    view = ExactView(
        slide(IDENTITY),
        [MovingGroup(1, IDENTITY, enclosure, mesh)],
        [FixedGroup(move(*place), enclosure, mesh) for place in places],
        np.array([[0, 2], [0, 3]]),
        BUDGET,
    )
    assert view.configuration_hit([0.0]) == FREE
    assert view.counters.pair_checks == 0
    assert view.configuration_hit([0.45]) == 1
    assert view.counters.pair_checks == 1
