"""Whether a convex part stays near a solid: what is refuted, is so by a point; and lines of sight inside the solid."""

import numpy as np
import pytest
import trimesh

from kabo.geometry.bounding.kernels.visibility import blocked_pairs, first_crossings
from kabo.geometry.bounding.nearness import near_or_witness
from kabo.geometry.triangles.solids import Solid

SLOT = 0.02  # m: between two plates


def plates() -> Solid:
    """Two plates on a third: a channel SLOT wide and 0.1 deep."""
    boxes = [
        trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.06, 0.2, 0.02]]),
        trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.02, 0.2, 0.12]]),
        trimesh.creation.box(bounds=[[0.04, 0.0, 0.0], [0.06, 0.2, 0.12]]),
    ]
    corners = np.vstack([np.array(box.vertices, np.float64) for box in boxes])
    return Solid(corners, np.vstack([np.array(box.faces, np.int64) + 8 * i for i, box in enumerate(boxes)]))


@pytest.mark.parametrize("beyond", [1e-1, 1e-2, 1e-3, 1e-4])
def test_what_is_too_far_by_little_is_refuted_by_a_point_not_given_up(beyond: float) -> None:
    solid = plates()
    around = np.array(trimesh.creation.box(bounds=[[0.001, 0.003, 0.001], [0.059, 0.197, 0.119]]).vertices)
    limit = 0.5 * SLOT * (1.0 - beyond)
    near, far = near_or_witness(solid, around, limit)
    assert near is False
    assert far is not None
    assert solid.outside_distances(far[None])[0] > limit
    assert (far >= around.min(axis=0) - 1e-9).all()
    assert (far <= around.max(axis=0) + 1e-9).all()


def test_what_is_near_is_proven() -> None:
    around = np.array(trimesh.creation.box(bounds=[[0.001, 0.003, 0.001], [0.059, 0.197, 0.119]]).vertices)
    assert near_or_witness(plates(), around, 0.5 * SLOT * 1.2) == (True, None)


def sampled(solid: Solid, first: np.ndarray, second: np.ndarray) -> float:
    """How far the line between two points leaves a solid, at 2000 of its points."""
    return float(solid.outside_distances(first + np.linspace(0, 1, 2001)[:, None] * (second - first)).max())


def test_lines_of_sight_are_blocked_where_samples_of_them_leave_the_solid() -> None:
    solid, rng = plates(), np.random.default_rng(7)
    corners = solid.vertices[solid.faces[rng.integers(0, len(solid.faces), 40)]]
    points = np.ascontiguousarray((corners * rng.dirichlet(np.ones(3), 40)[:, :, None]).sum(axis=1))
    limit, blocked = 0.004, np.zeros((40, 40), np.int64)
    blocked_pairs(points, limit, *solid.tree, np.zeros(64, np.int64), np.zeros(6), np.zeros(256), blocked)
    assert (blocked == blocked.T).all()
    reached = np.array([[sampled(solid, a, b) for b in points] for a in points])
    assert 0.1 < blocked.mean() < 0.9
    assert (reached[blocked == 1] > limit).all()
    assert (blocked[reached > 1.1 * limit] == 1).all()


def test_the_first_crossing_of_a_step_is_where_it_meets_the_surface() -> None:
    solid = plates()
    steps = np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.005, 0.0, 0.0], [0.0, 0.0, -0.1], [0.0, 0.0, 0.5]])
    shares = np.zeros(5)
    at = np.array([0.03, 0.1, 0.05])
    first_crossings(at, steps, *solid.tree, np.zeros(64, np.int64), np.zeros(6), np.zeros(256), shares)
    assert shares == pytest.approx([0.1, 0.1, 1.0, 0.3, 1.0])


def crossed(boxes: list[list[list[float]]]) -> Solid:
    """Boxes that overlap, given by their bounds."""
    made = [trimesh.creation.box(bounds=bounds) for bounds in boxes]
    corners = np.vstack([np.array(box.vertices, np.float64) for box in made])
    return Solid(corners, np.vstack([np.array(box.faces, np.int64) + 8 * i for i, box in enumerate(made)]))


def test_a_part_around_one_of_two_overlapping_boxes_needs_no_small_pieces() -> None:
    solid = crossed([[[0.0, 0.0, 0.0], [0.3, 0.1, 0.1]], [[0.13, -0.11, 0.02], [0.22, 0.19, 0.12]]])
    limit = 1e-5
    around = np.array(trimesh.creation.box(bounds=[[-5e-6, -5e-6, -5e-6], [0.3, 0.1, 0.1]]).vertices)
    assert near_or_witness(solid, around, limit, 100) == (True, None)
    assert near_or_witness(solid, around, 0.8 * limit)[0] is False


@pytest.mark.parametrize("seed", range(4))
def test_parts_of_overlapping_boxes_are_proven_only_if_all_samples_are_near(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.uniform(0.0, 0.4, (4, 3))
    boxes = np.stack([low, low + rng.uniform(0.2, 0.6, (4, 3))], axis=1)
    solid, answers = crossed(boxes.tolist()), []
    for _ in range(8):
        part = rng.uniform(0.1, 0.8, (8, 3))
        points = rng.dirichlet(np.full(8, 0.4), 3000) @ part
        away = np.maximum(np.maximum(boxes[:, :1] - points, points - boxes[:, 1:]), 0.0)
        reached = float(np.linalg.norm(away, axis=2).min(axis=0).max())
        limit = reached * rng.choice([0.7, 1.5]) + 1e-3
        near, far = near_or_witness(solid, part, limit)
        answers.append(near)
        assert not (near and reached > limit)
        if far is not None:
            gaps = np.maximum(np.maximum(boxes[:, 0] - far, far - boxes[:, 1]), 0.0)
            assert np.linalg.norm(gaps, axis=1).min() > limit
    assert {True, False} <= set(answers)


def test_what_an_inward_component_takes_away_is_no_part_of_a_group_around_it() -> None:
    solid = crossed(
        [
            [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
            [[0.2, 0.2, 0.2], [0.8, 0.8, 0.8]],
            [[0.9, 0.0, 0.0], [2.0, 1.0, 1.0]],
        ]
    )
    faces = solid.faces.copy()
    faces[12:24] = faces[12:24, ::-1]
    hollow = Solid(solid.vertices, faces)
    assert sorted(len(group.faces) for group in hollow.groups) == [12, 24]
    inner = np.array(trimesh.creation.box(bounds=[[0.1, 0.1, 0.1], [0.6, 0.6, 0.6]]).vertices)
    assert near_or_witness(solid, inner, 0.01)[0] is True
    assert near_or_witness(hollow, inner, 0.01)[0] is False
    assert near_or_witness(hollow, inner, 0.31)[0] is True
