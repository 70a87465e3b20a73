"""The bounding box of a mesh, beside a library that is not ours."""

import numpy as np
import pytest
import trimesh

from kabo.meshes import Mesh


@pytest.mark.parametrize("seed", range(12))
def test_the_box_is_that_of_trimesh_and_its_corners_are_among_those_of_the_vertices(seed: int) -> None:
    rng = np.random.default_rng(seed)
    vertices = rng.uniform(-3.0, 5.0, (int(rng.integers(3, 200)), 3))
    faces = rng.integers(0, len(vertices), (20, 3))
    mesh, other = Mesh(vertices, faces), trimesh.PointCloud(vertices)
    assert np.array_equal(np.array(mesh.bounds), other.bounds)
    assert mesh.diagonal == pytest.approx(other.scale, rel=1e-15)
    expected = trimesh.bounds.corners(other.bounds)
    assert sorted(map(tuple, mesh.box_corners.tolist())) == sorted(map(tuple, expected.tolist()))


def test_a_mesh_without_vertices_has_no_size() -> None:
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
    assert np.array_equal(np.array(empty.bounds), np.zeros((2, 3)))
    assert empty.diagonal == 0.0
