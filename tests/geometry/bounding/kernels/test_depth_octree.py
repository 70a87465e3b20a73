"""The octree of depths: what it says of a ball and a limit is what distances say; and samples of hulls lie in them."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from kabo.geometry.bounding.kernels.depth_octree import (
    ALL_NEAR,
    MIDDLE_FAR,
    UNDECIDED,
    first_far,
    hull_is_far,
    settled,
    star_is_far,
)
from kabo.geometry.bounding.nearness import HALTON_POINTS
from kabo.geometry.triangles.solids import Solid, SolidArrays

Octree = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]


def ring() -> Solid:
    """A torus with a box in it that crosses it."""
    torus = trimesh.creation.torus(0.3, 0.1, major_sections=24, minor_sections=12)
    box = trimesh.creation.box(bounds=[[0.1, -0.05, -0.05], [0.35, 0.05, 0.2]])
    corners = [np.array(torus.vertices, np.float64), np.array(box.vertices, np.float64)]
    faces = [np.array(torus.faces, np.int64), np.array(box.faces, np.int64) + len(corners[0])]
    return Solid(np.vstack(corners), np.vstack(faces))


def small_octree(solid: Solid, nodes: int) -> Octree:
    return solid.depths[0].copy(), np.full(nodes, np.nan), np.zeros(nodes, np.int64)


def arrays_of(solid: Solid, octree: Octree) -> SolidArrays:
    frame, depths, firsts = octree
    return solid.arrays._replace(frame=frame, depths=depths, firsts=firsts)


@pytest.mark.parametrize("nodes", [1, 60, 40_000])
def test_what_nodes_know_of_a_ball_is_what_distances_say(nodes: int) -> None:
    solid, rng = ring(), np.random.default_rng(3)
    octree, said = small_octree(solid, nodes), {UNDECIDED: 0, ALL_NEAR: 0, MIDDLE_FAR: 0}
    for limit in (0.003, 0.02, 0.08):
        points = rng.uniform(-0.6, 0.6, (1500, 3))
        inside, surface = solid.insides(points), solid.surface_distances(points)
        signed = np.where(inside, -surface, surface)
        for point, depth, ball in zip(points, signed, rng.exponential(limit, 1500), strict=True):
            x, y, z = point
            word = int(settled(x, y, z, ball, limit, arrays_of(solid, octree)))
            said[word] += 1
            assert word != ALL_NEAR or depth + ball <= limit
            assert word != MIDDLE_FAR or depth > limit
    assert octree[0][4] <= nodes
    assert nodes < 40_000 or (said[ALL_NEAR] > 100 and said[MIDDLE_FAR] > 1000)


@pytest.mark.parametrize("nodes", [1, 40_000])
def test_the_first_far_point_is_found_whatever_the_octree_knows(nodes: int) -> None:
    solid, rng = ring(), np.random.default_rng(4)
    octree = small_octree(solid, nodes)
    for limit in (0.005, 0.05):
        for _ in range(100):
            points = rng.uniform(-0.4, 0.4, (6, 3)) * (1.0, 1.0, 0.3)
            far = np.flatnonzero(solid.outside_distances(points) > limit)
            found = first_far(points, limit, arrays_of(solid, octree))
            assert found == (far[0] if len(far) else -1)


def test_a_far_sample_of_a_hull_is_far_and_in_the_hull() -> None:
    solid, rng = ring(), np.random.default_rng(5)
    found = 0
    for _ in range(200):
        hull = ConvexHull(rng.uniform(-0.1, 0.1, (8, 3)) + rng.uniform(-0.35, 0.35, 3) * (1.0, 1.0, 0.3))
        at, sums = hull.points.mean(axis=0), np.empty(len(hull.simplices))
        known = solid.arrays
        if hull_is_far(hull.points, hull.simplices, HALTON_POINTS, 280, sums, at, 0.06, known):
            found += 1
            assert solid.outside_distances(at[None])[0] > 0.06
            assert (hull.equations[:, :3] @ at + hull.equations[:, 3] <= 1e-12).all()
    assert 20 < found < 180


def test_a_hollow_inside_a_hull_is_met_by_samples_of_what_is_within() -> None:
    outer, hole = trimesh.creation.box((0.4, 0.4, 0.4)), trimesh.creation.box((0.2, 0.2, 0.2))
    corners = np.vstack([np.array(outer.vertices), np.array(hole.vertices)])
    solid = Solid(corners, np.vstack([np.array(outer.faces), np.array(hole.faces)[:, ::-1] + 8]).astype(np.int64))
    hull = ConvexHull(np.array(outer.vertices))
    known = solid.arrays
    for samples, far in ((HALTON_POINTS[:280], False), (HALTON_POINTS, True)):
        at = hull.points.mean(axis=0)
        assert hull_is_far(hull.points, hull.simplices, samples, 280, np.empty(12), at, 0.05, known) is far


def test_a_star_that_moves_into_the_solid_is_near_and_one_that_moves_away_is_far() -> None:
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    solid = Solid(np.array(box.vertices, np.float64), np.array(box.faces, np.int64))
    hull = ConvexHull(solid.vertices)
    known = solid.arrays
    a, b = (int(v) for v in hull.simplices[0][:2])
    middle = 0.5 * (hull.points[a] + hull.points[b])
    assert not star_is_far(hull.points, hull.simplices, a, b, 1.1 * middle, 0.02, known)
    assert star_is_far(hull.points, hull.simplices, a, b, 1.6 * middle, 0.02, known)
