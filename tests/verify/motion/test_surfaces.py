"""Distances, hulls and containment of surfaces, on cases whose answers are known."""

import numpy as np
import pytest
import trimesh

from kabo.scene import Mesh
from kabo.verify.motion.surfaces import encloses, hull_depth, hull_gap, mesh_distance, surface


def of(made: trimesh.Trimesh):
    return surface(Mesh(np.ascontiguousarray(made.vertices, dtype=float), np.asarray(made.faces, dtype=np.int64)))


def at(x: float, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    world_T = np.eye(4)
    world_T[:3, 3] = x, y, z
    return world_T


CUBE, BALL = of(trimesh.creation.box((1, 1, 1))), of(trimesh.creation.icosphere(radius=0.1))
RING = of(trimesh.creation.torus(0.5, 0.05))


@pytest.mark.parametrize("gap", [1.0, 0.01, 1e-4, 1e-6])
def test_distances_of_meshes_and_gaps_of_hulls_are_never_larger_than_the_distance(gap):
    assert gap - 2e-7 <= mesh_distance(CUBE, at(0), CUBE, at(1 + gap)) <= gap
    assert hull_gap(CUBE, at(0), CUBE, at(1 + gap)) <= gap
    assert gap < 1e-4 or hull_gap(CUBE, at(0), CUBE, at(1 + gap)) >= gap - 2e-7


def test_touching_and_crossing_surfaces_have_no_distance():
    for shift in (1.0, 0.9, 0.2):
        assert mesh_distance(CUBE, at(0), CUBE, at(shift)) <= 0.0
        assert hull_gap(CUBE, at(0), CUBE, at(shift)) <= 1e-9
    assert hull_depth(CUBE, at(0), CUBE, at(0.9)) == pytest.approx(0.1, abs=1e-6)


def test_the_hull_of_a_ring_says_nothing_about_what_is_in_its_hole_but_the_mesh_does():
    assert hull_gap(RING, at(0), BALL, at(0)) == 0.0
    assert mesh_distance(RING, at(0), BALL, at(0)) == pytest.approx(0.35, abs=0.01)
    assert not encloses(RING, at(0), BALL, at(0))


def test_a_body_inside_another_is_noticed_and_one_beside_it_is_not():
    assert encloses(CUBE, at(3), BALL, at(3.2, 0.1))
    assert not encloses(BALL, at(3), CUBE, at(3))
    assert not encloses(CUBE, at(0), BALL, at(0.7))
    inverted = trimesh.creation.box((1, 1, 1))
    inverted.invert()
    assert encloses(of(inverted), at(0), BALL, at(0))


def test_every_piece_of_a_mesh_is_looked_for_inside():
    pieces = trimesh.util.concatenate(
        [trimesh.creation.icosphere(radius=0.1).apply_translation((x, 0, 0)) for x in (5, 0)]
    )
    assert encloses(CUBE, at(0), of(pieces), at(0))


def test_a_flat_mesh_has_a_surface_without_a_hull():
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    sheet = of(flat)
    assert sheet.hull is None and hull_gap(sheet, at(0), CUBE, at(0, 0, 5)) == 0.0
    assert mesh_distance(sheet, at(0), CUBE, at(0, 0, 1)) == pytest.approx(0.5, abs=1e-6)


def test_a_body_one_corner_of_which_has_hundreds_of_neighbours_is_judged_by_its_mesh():
    cone = of(trimesh.creation.cone(radius=0.5, height=1.0, sections=600))  # coal's hulls have at most 255
    assert cone.hull is None
    assert hull_gap(cone, at(0), BALL, at(0.7)) == 0.0
    assert mesh_distance(cone, at(0), BALL, at(0.7)) == pytest.approx(0.1, abs=1e-3)
