"""How far a solid is from its convex hull: the bound holds for every point, and nearly convex solids have one."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from kabo.geometry.bounding.nearness import faces_near, near_or_witness
from kabo.geometry.triangles.hulls import hull_mesh
from kabo.geometry.triangles.solids import Solid


def solid(mesh: trimesh.Trimesh) -> Solid:
    return Solid(np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64))


def perturbed(seed: int) -> Solid:
    """The hull of some points, cut finely, with vertices moved by up to a thousandth of its size or much less."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(5, 30)), 3)) * rng.uniform(0.1, 1.0, 3)
    fine = trimesh.Trimesh(*hull_mesh(points)).subdivide()
    size = 10.0 ** rng.uniform(-9, -3)
    return Solid(np.array(fine.vertices) + rng.uniform(-size, size, fine.vertices.shape), np.array(fine.faces))


def within(solid: Solid, count: int, seed: int = 0) -> np.ndarray:
    """Random points of the hull of a solid, many of them near its surface."""
    hull = ConvexHull(solid.vertices)
    corners = solid.vertices[hull.simplices]
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(3), count)
    surface = (corners[rng.integers(0, len(corners), count)] * weights[..., None]).sum(axis=1)
    middle = solid.vertices.mean(axis=0)
    inner: np.ndarray = middle + (surface - middle) * rng.choice([1.0, 0.999, 0.8, 0.3], (count, 1))
    return inner


@pytest.mark.parametrize("seed", range(40))
def test_no_point_of_the_hull_is_farther_from_the_solid_than_the_bound(seed: int) -> None:
    nearly = perturbed(seed)
    error = nearly.convexity_error
    assert 0.0 < error < np.inf
    reached = nearly.outside_distances(within(nearly, 3000))
    assert reached.max() <= error


@pytest.mark.parametrize("seed", range(10))
def test_corners_prove_a_part_around_a_nearly_convex_solid(seed: int) -> None:
    nearly = perturbed(seed)
    part = 1.01 * nearly.vertices[ConvexHull(nearly.vertices).vertices]
    reached = float(nearly.outside_distances(part).max())
    limit = reached + 1.01 * nearly.convexity_error + 2e-8
    assert near_or_witness(nearly, part, limit, 0) == (True, None)
    assert faces_near(nearly, part[:3][None], limit)
    near, far = near_or_witness(nearly, part, 0.999 * reached)
    assert near is False
    assert far is not None
    assert nearly.outside_distances(far[None])[0] > 0.999 * reached


def pitted(depth: float) -> Solid:
    """A cube of which one corner of two triangles is pushed in: a pit as wide as a face, in front of no other plane."""
    box = trimesh.creation.box().subdivide()
    corners = np.array(box.vertices)
    corners[np.argmin(np.linalg.norm(corners - [0.0, 0.0, 0.5], axis=1))] -= [0.0, 0.0, depth]
    return Solid(corners, np.array(box.faces))


def test_a_pit_counts_with_its_depth() -> None:
    assert pitted(0.0).convexity_error < 1e-12
    for depth in (1e-6, 1e-3, 0.02):
        assert depth <= pitted(depth).convexity_error < 4.0 * depth
    assert pitted(0.3).convexity_error == np.inf


def joined(*meshes: trimesh.Trimesh) -> Solid:
    return solid(trimesh.util.concatenate(list(meshes)))


def test_what_only_looks_convex_has_no_bound() -> None:
    box, turned = trimesh.creation.box(), trimesh.creation.box(extents=[0.4, 0.4, 0.4])
    turned.invert()
    assert joined(box, turned).convexity_error == np.inf  # a cavity
    thin = trimesh.creation.box(bounds=[[-1e-3, -1e-3, -0.4], [1e-3, 1e-3, 0.4]])
    thin.invert()
    assert joined(box, thin).convexity_error == np.inf  # a cavity without volume to speak of
    skin = trimesh.creation.box(extents=[0.999999] * 3)
    skin.invert()
    assert joined(box, skin).convexity_error == np.inf  # hollow, though each face is at the hull
    apart = [trimesh.creation.box(bounds=[[x, 0, 0], [x + 0.499, 1, 1]]) for x in (0.0, 0.501)]
    assert joined(*apart).convexity_error == np.inf  # two halves with a slit
    assert solid(trimesh.creation.annulus(0.02, 0.04, 0.05)).convexity_error == np.inf


def test_orientation_does_not_matter() -> None:
    box = trimesh.creation.box()
    box.invert()
    assert solid(box).convexity_error < 1e-12


def test_slivers_with_any_normal_do_no_harm() -> None:
    """As files of single precision have them: a face whose corners nearly lie on a line, turned to any side."""
    box = trimesh.creation.box()
    corners, faces = np.array(box.vertices), np.array(box.faces)
    a, b, c = faces[0]
    middle = 0.5 * (corners[a] + corners[b]) + [1e-8, -2e-8, 3e-8]
    other = next(i for i, face in enumerate(faces) if i and {a, b} <= set(face.tolist()))
    d = next(int(v) for v in faces[other] if v not in (a, b))
    vertices = np.vstack([corners, middle])
    m = len(corners)
    kept = [face for i, face in enumerate(faces) if i not in (0, other)]
    split = Solid(vertices, np.array([*kept, [a, m, c], [m, b, c], [a, b, m], [b, a, d]]))
    assert split.convexity_error < 1e-6
