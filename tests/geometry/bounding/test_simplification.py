"""Convex parts of few corners: what they must hold, what they must not, and the looks that guide them."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from kabo.geometry.bounding.kernels.union_depth import CONVEXITY_MARGIN
from kabo.geometry.bounding.nearness import Voids, faces_near, looks_near
from kabo.geometry.bounding.simplification import enclosing_part
from kabo.geometry.triangles.solids import Solid
from tests.geometry.bounding.test_nearness import SLOT, plates


def ball(radius: float) -> Solid:
    """A ball with a closed hollow of half its radius."""
    outer, inner = (trimesh.creation.icosphere(3, radius=r) for r in (radius, 0.5 * radius))
    faces = np.vstack([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)])
    return Solid(np.vstack([outer.vertices, inner.vertices]).astype(np.float64), faces.astype(np.int64))


def across(height: float) -> np.ndarray:
    """A rectangle (2, 3, 3) between the plates, at a share of the way from one to the other."""
    x = 0.02 + height * SLOT
    corners = np.array([[x, 0.01, 0.03], [x, 0.19, 0.03], [x, 0.19, 0.11], [x, 0.01, 0.11]])
    return corners[[[0, 1, 2], [0, 2, 3]]]


@pytest.mark.parametrize(("beyond", "near"), [(0.5, True), (0.1, True), (-1e-3, False), (-1e-1, False)])
def test_triangles_are_near_if_all_of_them_is_within_the_limit(beyond: float, near: bool) -> None:
    assert faces_near(plates(), across(0.5), 0.5 * SLOT * (1.0 + beyond)) is near
    assert faces_near(plates(), across(0.25), 0.25 * SLOT * (1.0 + beyond)) is near


def test_triangles_inside_are_near_however_deep() -> None:
    block = trimesh.creation.box(extents=[1.0, 1.0, 1.0])
    solid = Solid(np.array(block.vertices, np.float64), np.array(block.faces, np.int64))
    assert faces_near(solid, np.array([[[0.1, 0.0, 0.0], [-0.3, 0.4, 0.2], [0.0, -0.4, -0.4]]]), 1e-3)


def test_a_part_holds_its_points_has_few_corners_and_stays_near() -> None:
    sphere = trimesh.creation.icosphere(3, radius=0.1)
    solid, limit = Solid(np.array(sphere.vertices, np.float64), np.array(sphere.faces, np.int64)), 0.004
    part = enclosing_part(solid, solid.vertices, limit)
    assert part is not None
    assert 12 <= len(part) < 160
    planes = ConvexHull(part).equations
    assert (solid.vertices @ planes[:, :3].T + planes[:, 3] < 0.0).all()
    assert np.linalg.norm(part, axis=1).max() <= 0.1 + limit


def test_a_part_around_a_hollow_is_refused_and_the_hollow_is_remembered() -> None:
    solid, limit = ball(0.1), 0.02
    voids = Voids(solid)
    assert enclosing_part(solid, solid.vertices, limit, voids) is None
    hull = ConvexHull(solid.vertices)
    assert voids.meet(hull, limit)
    assert not voids.meet(hull, 0.051)  # nothing is so far from the solid
    assert enclosing_part(solid, solid.vertices, 0.051) is not None


def test_what_holds_a_void_is_no_part_though_samples_see_nothing() -> None:
    solid, limit = plates(), 0.45 * SLOT
    voids = Voids(solid)
    slab = np.array(trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.02, 0.2, 0.12]]).vertices, np.float64)
    free, hull = enclosing_part(solid, slab, limit, voids), ConvexHull(slab)
    assert free is not None
    assert looks_near(solid, hull, limit)
    wide = np.array(trimesh.creation.box(bounds=[[0.0, 0.0, 0.0], [0.06, 0.2, 0.12]]).vertices, np.float64)
    voids.add(np.array([0.03, 0.1, 0.09]), ConvexHull(wide))
    assert enclosing_part(solid, wide, limit, voids) is None
    again = enclosing_part(solid, slab, limit, voids)
    assert again is not None
    assert not voids.meet(ConvexHull(again), limit)


def test_depths_that_a_tree_learns_from_coarser_ones_are_those_that_it_would_search() -> None:
    solid, rng = plates(), np.random.default_rng(3)
    points = rng.uniform([0.0, 0.0, 0.0], [0.06, 0.2, 0.12], (400, 3))
    for point in points:
        faces_near(solid, (point + 1e-5 * rng.normal(size=(3, 3)))[None], 0.3 * SLOT)
    frame, depths, firsts = solid.depths
    middles, work = [], [(0, frame[:3], frame[3])]
    while work:
        n, middle, half = work.pop()
        if not np.isnan(depths[n]):
            middles.append((n, middle))
        for k in range(8 if firsts[n] else 0):
            shift = np.array([k & 1, k >> 1 & 1, k >> 2 & 1]) - 0.5
            work.append((firsts[n] + k, middle + half * shift, 0.5 * half))
    at = np.array([middle for _, middle in middles])
    known = np.array([depths[n] for n, _ in middles])
    assert len(at) > 500
    inside = solid.insides(at)
    plates_alone = [group.solid for group in solid.groups]
    assert len(plates_alone) == 3
    depths = np.max([np.where(each.insides(at), each.surface_distances(at), 0.0) for each in plates_alone], axis=0)
    searched = np.maximum(solid.surface_distances(at), np.where(inside, depths - CONVEXITY_MARGIN, 0.0))
    np.testing.assert_allclose(np.abs(known), searched, rtol=1e-12, atol=1e-15)
    clear = np.abs(known) > 1e-9
    assert ((known < 0.0) == inside)[clear].all()
