"""Meshes of a view document: near what they stand for, and parts with all that their rounding adds."""

import numpy as np
import trimesh

from kabo.meshes import Mesh, Rounding
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.meshes import LOW_FACES, Meshes, reduced
from kabo.viewer.content.shapes import part_mesh


def ball(subdivisions: int) -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=0.1)
    return Mesh(np.asarray(made.vertices) + [5.0, 0.0, 0.0], np.asarray(made.faces, np.int64))


def test_vertices_are_as_near_as_sixteen_bits_of_their_box_can_say():
    arrays, mesh = Arrays(), ball(3)
    meshes = Meshes(arrays)
    described = meshes.listed[meshes.shape(mesh)["mesh"]]
    row = arrays.table[described["vertices"]["array"]]
    numbers = np.frombuffer(arrays.block, "<u2", row["length"], row["offset"]).reshape(-1, 3)
    found = np.array(described["low"]) + numbers * np.array(described["step"])
    assert np.abs(found - mesh.vertices).max() <= 0.2 / 65535


def test_a_mesh_that_is_asked_for_twice_is_kept_once():
    meshes = Meshes(Arrays())
    assert meshes.shape(ball(2)) == meshes.shape(ball(2))
    assert len(meshes.listed) == 1


def test_a_large_mesh_gets_fewer_triangles_and_keeps_its_shape():
    low = reduced(ball(5))
    assert 0.9 * LOW_FACES <= len(low.faces) <= LOW_FACES
    assert np.abs(np.linalg.norm(low.vertices - [5.0, 0.0, 0.0], axis=1) - 0.1).max() < 1e-3
    small = ball(1)
    assert reduced(small) is small


def test_a_part_is_shown_with_its_rounding():
    ends = np.array([[0.0, 0.0, -0.1], [0.0, 0.0, 0.1]])
    cylinder = part_mesh(ends, Rounding(disc=0.05))
    assert np.allclose(np.ptp(cylinder.vertices, axis=0), [0.1, 0.1, 0.2], atol=1e-3)
    sphere = part_mesh(np.zeros((1, 3)), Rounding(radius=0.05))
    assert np.allclose(np.linalg.norm(sphere.vertices, axis=1), 0.05)
