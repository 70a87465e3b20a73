"""Inner bounding meshes of overlapping components lie within their union; what crosses itself is refused by name."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.errors import MeshError
from kabo.geometry import bounding_mesh
from kabo.geometry.triangles.component_groups import groups_without_crossings
from kabo.meshes import Mesh
from kabo.meshes.nesting import winding_number


def mesh_of(*shapes: trimesh.Trimesh) -> Mesh:
    whole = trimesh.util.concatenate(list(shapes))
    return Mesh(np.array(whole.vertices, np.float64), np.array(whole.faces, np.int64))


def ball(x: float, radius: float = 0.05, *, hollow: bool = False) -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    made.apply_translation((x, 0.001, 0.002))
    if hollow:
        made.invert()
    return made


def outside(mesh: Mesh, inner: Mesh, seed: int) -> int:
    """How many random points the inner mesh winds around, but not the mesh: an oracle that sums solid angles."""
    rng = np.random.default_rng(seed)
    near = inner.vertices[inner.faces[rng.integers(len(inner.faces), size=3000)]].mean(axis=1)
    points = np.vstack([near * (1.0 + 1e-4), near + rng.normal(scale=5e-4, size=near.shape)])
    within = np.abs(winding_number(points, inner.vertices, inner.faces)) > 0.5
    return int((np.abs(winding_number(points[within], mesh.vertices, mesh.faces)) < 0.5).sum())


def test_an_inner_mesh_of_overlapping_components_lies_within_their_union() -> None:
    mesh = mesh_of(ball(0.0), ball(0.04), trimesh.creation.box((0.15, 0.02, 0.02)), ball(0.0, 0.02, hollow=True))
    made = bounding_mesh(mesh_of(ball(0.0), ball(0.04), trimesh.creation.box((0.15, 0.02, 0.02))), 0.004, "inner")
    assert len(made.vertices) < 0.3 * len(mesh.vertices)
    assert outside(mesh_of(ball(0.0), ball(0.04), trimesh.creation.box((0.15, 0.02, 0.02))), made, 0) == 0


def test_a_cavity_stays_with_its_solid() -> None:
    mesh = mesh_of(ball(0.0), ball(0.0, 0.02, hollow=True), ball(0.3), ball(0.34))
    groups = groups_without_crossings(mesh.vertices, mesh.faces, "mesh")
    assert sorted(len(group) for group in groups) == [1280, 1280, 2560]
    made = bounding_mesh(mesh, 0.004, "inner")
    assert outside(mesh, made, 1) == 0
    assert abs(winding_number(np.array([[0.0, 0.001, 0.002]]), made.vertices, made.faces)[0]) < 0.5


def test_a_component_that_crosses_itself_is_refused_by_name() -> None:
    folded = ball(0.0)
    folded.vertices[np.argmax(folded.vertices[:, 0])] = (-0.09, 0.001, 0.002)
    mesh = mesh_of(folded)
    with pytest.raises(MeshError, match=r"crosses itself: \d+ of the 1280 triangles of one component"):
        bounding_mesh(mesh, 0.004, "inner")
    assert bounding_mesh(mesh, 0.004, "outer").contractions > 0
    with pytest.raises(MeshError, match=r"finger\.stl:1:1: the mesh crosses itself"):
        groups_without_crossings(mesh.vertices, mesh.faces, str(Path("finger.stl")))
