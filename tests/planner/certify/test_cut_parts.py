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

BOX = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
SIDES = [[0, 1, 2, 3], [4, 6, 5, 7], [0, 4, 1, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 5, 3, 7]]
BOX_FACES = np.array([face for a, b, c, d in SIDES for face in ([a, b, c], [d, c, b])])
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


@given(seed=st.integers(0, 2**32 - 1), growth=st.sampled_from([1e-8, 1e-7, 1e-5, 1e-3]))
@settings(max_examples=40, deadline=None)
def test_triangles_of_several_parts_stay_covered_however_little_the_parts_stick_out(seed, growth):
    """A box of twelve triangles in nine parts, some of whose edges pass through the middle of triangles."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    size, shift = rng.uniform(0.02, 0.3, 3), rng.normal(size=3)
    borders = np.concatenate([[0.0], np.sort(rng.uniform(0.2, 0.8, 2)), [1.0]])
    grown = (BOX - 0.5) * (1.0 + growth) + 0.5
    steps = [(a, b - a) for a, b in zip(borders, borders[1:], strict=False)]
    pieces = [grown * [x[1], y[1], 1.0] + [x[0], y[0], 0.0] for x in steps for y in steps]
    mesh, *parts = ((each * size) @ turn.T + shift for each in (BOX, *pieces))
    made = ordered(Enclosure(tuple(parts), 0.0))
    cut = CutParts(made, mesh, BOX_FACES)
    for direction in rng.normal(size=(36, 3)):
        cut.cut(int(rng.integers(9)), direction / np.linalg.norm(direction))
    before, after = (uncovered(mesh, BOX_FACES, each.vertices) for each in (made, cut.made()))
    assert before is None and after is None


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
    cut = CutParts(ordered(Enclosure((BOX,), 0.0)), BOX, BOX_FACES)
    assert not any(cut.cut(0, way / np.linalg.norm(way)) for way in np.random.default_rng(0).normal(size=(20, 3)))
