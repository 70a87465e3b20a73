"""Tetrahedra that are proven to be inside a solid are; anchors are within the limit; large pieces need one proof."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import Delaunay

from kabo.geometry.bounding.kernels.inner_tetrahedra import anchors_of, tetrahedron_inside
from kabo.geometry.bounding.nearness import near_or_witness
from kabo.geometry.triangles.solids import Solid


def solid(*meshes: trimesh.Trimesh) -> Solid:
    whole = trimesh.util.concatenate(list(meshes))
    return Solid(np.array(whole.vertices, np.float64), np.array(whole.faces, np.int64))


SOLIDS = {
    "a ring": solid(trimesh.creation.annulus(0.4, 1.0, 0.5, sections=24)),
    "a capsule": solid(trimesh.creation.capsule(1.0, 0.4)),
    "two boxes that overlap": solid(
        trimesh.creation.box(extents=[2.0, 0.5, 0.5]), trimesh.creation.box(extents=[0.5, 2.0, 0.6])
    ),
    "a torus turned inside out": solid(trimesh.creation.torus(1.0, 0.3)),
}
SOLIDS["a torus turned inside out"] = Solid(
    SOLIDS["a torus turned inside out"].vertices, SOLIDS["a torus turned inside out"].faces[:, ::-1].copy()
)


def is_inside(own: Solid, corners: np.ndarray) -> bool:
    return bool(tetrahedron_inside(corners, np.empty((4, 4)), own.arrays))


def within(corners: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    points: np.ndarray = rng.dirichlet(np.full(4, 0.5), count) @ corners
    return points


@pytest.mark.parametrize("name", SOLIDS)
def test_no_point_of_a_tetrahedron_proven_to_be_inside_is_outside(name: str) -> None:
    own, rng, held = SOLIDS[name], np.random.default_rng(1), [0, 0]
    low, high = own.vertices.min(axis=0), own.vertices.max(axis=0)
    for _ in range(1500):
        corners = rng.uniform(low, high) + rng.uniform(0.02, 0.6) * rng.normal(size=(4, 3)) * (high - low)
        if rng.random() < 0.1:
            corners[3] = corners[2]  # a triangle
        outside = own.outside_distances(within(corners, rng, 300)).max()
        answer = is_inside(own, corners)
        held[answer] += 1
        assert not (answer and outside > 0.0)
    assert min(held) > 20


def test_a_tetrahedron_is_inside_up_to_the_surface_but_not_through_a_slit() -> None:
    half = trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 0.4999]])
    other = trimesh.creation.box(bounds=[[0.0, 0.0, 0.5001], [1.0, 1.0, 1.0]])
    corners = np.array([[0.1, 0.1, 1e-6], [0.9, 0.1, 1e-6], [0.5, 0.9, 1e-6], [0.5, 0.4, 1.0 - 1e-6]])
    assert is_inside(solid(trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])), corners)
    assert not is_inside(solid(half, other), corners)
    assert not is_inside(solid(half), corners)


@pytest.mark.parametrize("name", SOLIDS)
def test_anchors_are_within_the_limit_and_far_points_are_found(name: str) -> None:
    own, rng = SOLIDS[name], np.random.default_rng(2)
    for limit in (0.3, 0.01):
        corners = own.vertices[own.faces[rng.integers(0, len(own.faces), 500)]].mean(axis=1)
        points = corners + 0.4 * limit * rng.normal(size=corners.shape)
        points = points[own.outside_distances(points) <= 0.99 * limit]
        found, middle = np.empty_like(points), own.vertices.mean(axis=0)
        assert anchors_of(points, limit, middle, own.arrays, found) == -1
        given = ~np.isnan(found[:, 0])
        assert np.linalg.norm(found - points, axis=1)[given].max() <= limit
        if "inside out" not in name:  # there they are of no use
            assert own.insides(found[given]).mean() > 0.9
            assert given.mean() > 0.8
        away = own.vertices.max(axis=0) + limit
        assert anchors_of(np.vstack([points, away]), limit, middle, own.arrays, np.empty((900, 3))) == len(points)


def test_a_part_with_few_faces_around_many_triangles_is_proven_in_few_pieces() -> None:
    """The walls of a cylinder have 400 triangles, and the limit is a thousandth of its size."""
    cylinder = trimesh.creation.cylinder(radius=0.5, height=2.0, sections=200)
    pit = trimesh.creation.box(bounds=[[0.6, -0.2, -0.2], [0.9, 0.2, 0.2]])  # so that the solid is not convex
    own = solid(cylinder, pit)
    alone = solid(cylinder)
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = 0.503 * np.column_stack([np.cos(angle), np.sin(angle)])
    part = np.vstack([np.column_stack([ring, np.full(40, z)]) for z in (-1.001, 1.001)])
    limit = float(alone.outside_distances(part).max()) + 1e-3
    assert near_or_witness(own, part, limit, 300) == (True, None)
    assert near_or_witness(own, part, 0.9 * (limit - 1e-3))[0] is False


@pytest.mark.parametrize("seed", range(6))
def test_proofs_hold_for_all_samples_of_random_parts(seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = sorted(SOLIDS)
    own, answers = SOLIDS[names[seed % len(names)]], []
    for _ in range(12):
        middle = own.vertices[rng.integers(len(own.vertices))]
        part = middle + rng.uniform(0.05, 0.5) * rng.normal(size=(10, 3))
        corners = part[Delaunay(part).simplices]
        points = np.vstack([within(each, rng, 200) for each in corners])
        reached = float(own.outside_distances(points).max())
        limit = reached * rng.choice([0.8, 1.2]) + 1e-3
        near = near_or_witness(own, part, limit)[0]
        answers.append(near)
        assert not (near and reached > limit)
    assert {True, False} <= set(answers)
