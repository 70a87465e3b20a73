"""Crossing faces of meshes: none on clean ones, exactly those of a list of all pairs on others."""

from itertools import combinations

import numpy as np
import pytest
import trimesh

from kabo.geometry import crossing_faces
from kabo.geometry.triangles.kernels.crossing import faces_cross
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE

SPHERE = trimesh.creation.icosphere(subdivisions=2)


def turned(vertices, seed=0):
    return vertices @ np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0].T


def two(first, second):
    """Two meshes as one."""
    return (
        np.concatenate([first.vertices, second.vertices]),
        np.concatenate([first.faces, second.faces + len(first.vertices)]),
    )


def all_pairs(vertices, faces):
    crossing = np.zeros(len(faces), dtype=bool)
    for f, g in combinations(range(len(faces)), 2):
        if faces_cross(vertices, *faces[f], *faces[g], np.empty((6, 3)), np.empty(SCRATCH_SIZE)):
            crossing[[f, g]] = True
    return crossing


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e5])
@pytest.mark.parametrize(
    "solid",
    [
        SPHERE,
        trimesh.creation.box().subdivide().subdivide(),  # flat regions
        trimesh.creation.cone(1.0, 2.0, sections=400),  # a vertex of high degree
        trimesh.creation.annulus(0.5, 1.0, 0.01),
    ],
)
def test_no_face_of_a_clean_mesh_crosses_another(solid, size):
    vertices = np.asarray(solid.vertices, dtype=float) * size
    for place in (vertices, turned(vertices), turned(vertices) + 100.0 * size):
        assert not crossing_faces(place, solid.faces).any()


def test_faces_of_two_bodies_in_one_another_are_found_as_among_all_pairs():
    vertices, faces = two(SPHERE.copy().apply_scale([1.0, 0.3, 0.3]), SPHERE.copy().apply_scale([0.3, 1.0, 0.4]))
    found = crossing_faces(turned(vertices), faces)
    assert 20 < found.sum() < len(faces) - 20
    nearby = np.flatnonzero(np.abs(vertices[faces]).max(axis=(1, 2)) < 0.7)  # a list of all pairs takes its time
    assert found[~np.isin(np.arange(len(faces)), nearby)].sum() == 0
    assert np.array_equal(found[nearby], all_pairs(turned(vertices), faces[nearby]))


def test_bodies_that_touch_cross_and_bodies_apart_do_not():
    box = trimesh.creation.box()
    for gap, crosses in [(0.0, True), (1e-12, False)]:
        vertices, faces = two(box, box.copy().apply_translation([1.0 + gap, 0.25, 0.125]))
        assert crossing_faces(vertices, faces).any() == crosses


def test_a_face_listed_twice_crosses_itself():
    faces = np.concatenate([SPHERE.faces, SPHERE.faces[7:8, [1, 2, 0]]])
    assert np.flatnonzero(crossing_faces(SPHERE.vertices, faces)).tolist() == [7, len(SPHERE.faces)]


def test_the_order_of_faces_does_not_matter():
    vertices, faces = two(SPHERE, SPHERE.copy().apply_translation([0.7, 0.1, 0.2]))
    order = np.random.default_rng(3).permutation(len(faces))
    assert np.array_equal(crossing_faces(vertices, faces)[order], crossing_faces(vertices, faces[order]))


def test_no_faces_have_no_crossing():
    assert crossing_faces(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)).tolist() == []


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e81])
def test_vertices_that_make_no_sense_are_refused(value):
    with pytest.raises(ValueError, match="vertices must be finite"):
        crossing_faces(np.full((3, 3), value), [[0, 1, 2]])


def test_faces_of_missing_vertices_are_refused():
    with pytest.raises(ValueError, match="faces must name vertices 0 to 2"):
        crossing_faces(np.eye(3), [[0, 1, 3]])
