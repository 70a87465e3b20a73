"""Parts cut closer to their mesh: nothing of the mesh is lost, and they lie within the parts that they were."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kabo.geometry import Enclosure
from kabo.geometry.bounding.enclosure import enclosing_parts
from kabo.geometry.collision.separation_proofs import ordered
from kabo.geometry.parts import COLUMNS
from kabo.meshes import load_mesh
from kabo.planner.certify.cut_parts import CutParts
from kabo.verify.certificate.cover import faces_of, uncovered

MESHES = Path(__file__).resolve().parents[3] / "meshes"


@pytest.fixture(scope="module")
def finger():
    mesh = load_mesh(MESHES / "gripper_wide" / "left_finger.stl")
    return mesh, ordered(enclosing_parts(mesh, 0.004))


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_cut_parts_cover_the_mesh_and_lie_in_the_old_ones(finger, seed):
    """The verifier's own check of covers is the judge."""
    mesh, parts = finger
    cut, rng = CutParts(parts, mesh.vertices, mesh.faces), np.random.default_rng(seed)
    for direction in rng.normal(size=(8, 3)):
        direction /= np.linalg.norm(direction)
        part = int(rng.integers(len(parts.vertices)))
        before, needed = cut.reach(part, direction), cut.needed(part, direction)
        if cut.cut(part, direction):
            assert needed - 1e-12 <= cut.reach(part, direction) <= needed + 1e-12 < before
    made = cut.made()
    assert uncovered(mesh.vertices, mesh.faces, made.vertices) is None
    for old, new in zip(parts.vertices, made.vertices, strict=True):
        faces = faces_of(old)
        assert len(new) <= COLUMNS and (new @ faces.normals.T <= faces.offsets + 1e-9).all()


def test_a_corner_that_sticks_out_is_cut_off(finger):
    mesh, parts = finger
    cut, gained = CutParts(parts, mesh.vertices, mesh.faces), 0.0
    for part, corners in enumerate(parts.vertices):
        ways = corners - corners.mean(axis=0)
        for way in ways / np.linalg.norm(ways, axis=1)[:, None]:
            before = cut.reach(part, way)
            gained = max(gained, before - cut.reach(part, way) if cut.cut(part, way) else 0.0)
    assert gained > 1e-3


def test_a_mesh_that_fills_its_part_is_not_cut():
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    faces = np.array([[0, 1, 2], [3, 2, 1], [4, 6, 5], [7, 5, 6], [0, 4, 1], [5, 1, 4], [2, 3, 6], [7, 6, 3]])
    cut = CutParts(ordered(Enclosure((corners,), 0.0)), corners, faces)
    assert not any(cut.cut(0, way / np.linalg.norm(way)) for way in np.random.default_rng(0).normal(size=(20, 3)))
