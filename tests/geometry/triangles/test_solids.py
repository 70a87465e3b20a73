"""Solids: a convex one is enclosed by one part, whatever its shape; one with a hollow is told apart."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from kabo.errors import MeshError
from kabo.geometry import enclosing_parts
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh


def solid(mesh: trimesh.Trimesh) -> Solid:
    return Solid(np.array(mesh.vertices, np.float64), np.array(mesh.faces, np.int64))


@pytest.mark.parametrize("extents", [(0.95, 1.9, 0.04), (2.0, 2.0, 0.02), (0.1, 0.1, 0.1)])
def test_a_plate_is_one_part_and_hardly_any_larger(tmp_path: Path, extents: tuple[float, float, float]) -> None:
    box = trimesh.creation.box(extents=extents)
    made = enclosing_parts(Mesh(np.array(box.vertices), np.array(box.faces)), 0.004, cache=tmp_path)
    assert len(made.parts) == 1
    assert made.deviation <= 0.001
    assert np.all(np.abs(made.parts[0]).max(axis=0) >= np.array(extents) / 2)


def test_convex_solids_are_told_from_hollow_ones() -> None:
    assert solid(trimesh.creation.icosphere(subdivisions=2)).is_convex
    assert not solid(trimesh.creation.annulus(0.02, 0.04, 0.05)).is_convex


def test_an_open_mesh_is_refused_with_a_count(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    with pytest.raises(MeshError, match="not closed"):
        enclosing_parts(Mesh(np.array(box.vertices), np.array(box.faces)[1:]), 0.01, cache=tmp_path)


def test_a_ring_keeps_its_hole(tmp_path: Path) -> None:
    ring = trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24)
    made = enclosing_parts(Mesh(np.array(ring.vertices), np.array(ring.faces)), 0.008, cache=tmp_path)
    assert made.deviation <= 0.008
    planes = [ConvexHull(part).equations for part in made.parts]
    assert not any((own[:, 3] <= 0.0).all() for own in planes), "the middle of the hole is free"
    surface = trimesh.Trimesh(ring.vertices, ring.faces).sample(500, seed=0)
    covered = [(surface @ own[:, :3].T + own[:, 3] <= 0.0).all(axis=1) for own in planes]
    assert np.any(covered, axis=0).all()
