"""Parts drawn tight, and halved: nothing of the mesh is lost, and they lie within the parts that they were."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kabo.geometry import Enclosure
from kabo.geometry.bounding.enclosure import enclosing_parts
from kabo.geometry.collision import tight_parts
from kabo.geometry.collision.separation_proofs import between_parts, ordered
from kabo.geometry.collision.tight_parts import STICKS_OUT, kept_or_made, tight_part
from kabo.geometry.parts import COLUMNS
from kabo.meshes import Mesh, load_mesh
from kabo.planner.certify.best_margins import Leaves, _Nearest
from kabo.scene.transforms import flat, transform
from kabo.verify.certificate.cover import faces_of, uncovered

BOX = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
SIDES = [[0, 1, 2, 3], [4, 6, 5, 7], [0, 4, 1, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 5, 3, 7]]
BOX_FACES = np.array([face for a, b, c, d in SIDES for face in ([a, b, c], [d, c, b])])
MESHES = Path(__file__).resolve().parents[3] / "meshes"


@pytest.fixture(scope="module")
def finger():
    mesh = load_mesh(MESHES / "gripper_wide" / "left_finger.stl")
    return mesh, ordered(enclosing_parts(mesh, 0.004))


def refined(parts, mesh: Mesh, rng, steps: int) -> Leaves:
    """Parts of which some were refined, at random."""
    leaves = Leaves.of(parts, mesh)
    for _ in range(steps):
        i = int(rng.integers(len(leaves)))
        if leaves.held(i) is not None:
            leaves.refine(i)
    return leaves


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=15, deadline=None)
def test_refined_parts_cover_the_mesh_and_lie_in_the_old_ones(finger, seed):
    """The verifier's own check of covers is the judge."""
    mesh, parts = finger
    leaves = refined(parts, mesh, np.random.default_rng(seed), 12)
    made = leaves.made()
    assert uncovered(mesh.vertices, mesh.faces, made.vertices) is None
    for (first, _), new, box in zip(leaves.names, made.vertices, made.boxes, strict=True):
        faces = faces_of(parts.vertices[first])
        assert len(new) <= COLUMNS and (new @ faces.normals.T <= faces.offsets + 1e-9).all()
        np.testing.assert_allclose(np.concatenate([new.min(axis=0), new.max(axis=0)]), box, atol=1e-12)


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
    leaves = refined(made, Mesh(mesh, BOX_FACES), rng, 20)
    before, after = (uncovered(mesh, BOX_FACES, each.vertices) for each in (made, leaves.made()))
    assert before is None and after is None


def test_a_part_drawn_tight_sticks_out_little_or_has_many_corners(finger):
    mesh, parts = finger
    for part in parts.vertices:
        tight = tight_part(mesh, part)
        hull = faces_of(tight.triangles.reshape(-1, 3))
        out = (tight.corners @ hull.normals.T - hull.offsets).max()
        assert out <= 1.1 * STICKS_OUT or len(tight.corners) > COLUMNS - 4
        assert out < (part @ hull.normals.T - hull.offsets).max() - 5e-4


def test_a_mesh_that_fills_its_part_is_not_cut():
    tight = tight_part(Mesh(BOX, BOX_FACES), BOX)
    assert tight.corners.shape == BOX.shape and len(tight.triangles) == 12


def test_halves_of_a_hollow_body_are_refined_until_they_tell_its_distance():
    """Two walls with a post between them: one part bridges the hollow, which is 30 mm deep."""
    bars = np.array(
        [[0.0, 0.0, 0.0, 0.02, 0.1, 0.1], [0.08, 0.0, 0.0, 0.02, 0.1, 0.1], [0.0, 0.0, 0.0, 0.1, 0.1, 0.02]]
    )
    corners = np.concatenate([BOX * bar[3:] + bar[:3] for bar in bars])
    mesh = Mesh(corners, np.concatenate([BOX_FACES + 8 * k for k in range(3)]))
    hollow = Leaves.of(ordered(Enclosure((((BOX - 0.5) * (1.0 + 1e-5) + 0.5) * 0.1,), 0.0)), mesh)
    post = Leaves.of(ordered(Enclosure((BOX * [0.04, 0.1, 0.1],), 0.0)), None)
    poses = np.array([[flat(np.eye(4))] * 2, [flat(transform((0.03, 0.0, z))) for z in (0.2, 0.05)]])
    found = _Nearest((hollow, post), poses, 4.0, between_parts())
    assert found._least() <= 0.0
    distance = _Nearest((hollow, post), poses, 4.0, between_parts()).refined(1.0)
    assert 0.88 * 0.01 < distance <= 0.01 and len(hollow) < 40
    assert uncovered(mesh.vertices, mesh.faces, hollow.made().vertices) is None


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_the_nearest_place_is_found_as_if_each_pair_of_parts_were_measured_at_each_place(seed):
    """The judge looks at one pair of parts at one place at a time, so that nothing is left out."""
    rng = np.random.default_rng(seed)
    two = [[BOX * rng.uniform(0.02, 0.1, 3) + rng.uniform(0.0, 0.4, 3) for _ in range(6)] for _ in range(2)]
    shifts = np.linspace([0.9, 0.0, 0.0], [0.55, rng.uniform(-0.3, 0.3), 0.1], 9)
    poses = np.array([[flat(np.eye(4))] * 9, [flat(transform(shift)) for shift in shifts]])

    def least(parts, places, between=None):
        leaves = [Leaves.of(ordered(Enclosure(tuple(own), 0.0)), None) for own in parts]
        given = np.ascontiguousarray(poses[:, places])
        return _Nearest((leaves[0], leaves[1]), given, 4.0, between or between_parts())._least()

    alone = [least(([a], [b]), [k]) for a in two[0] for b in two[1] for k in range(9)]
    found = least(two, list(range(9)))
    assert 0.94 * min(alone) <= found <= min(alone) / 0.94
    between = between_parts()
    between.axes[:] = rng.normal(size=between.axes.shape)
    between.axes[:] /= np.linalg.norm(between.axes, axis=1)[:, None]
    assert least(two, list(range(9)), between) == found, "whatever axes are known"


def test_a_part_is_read_from_the_cache_folder_and_made_anew_where_the_file_is_damaged(monkeypatch, tmp_path):
    monkeypatch.setenv("KABO_CACHE", str(tmp_path / "cache"))
    mesh, calls = Mesh(BOX, BOX_FACES), []
    part = tight_part(mesh, BOX * 1.0)

    def make():
        calls.append(1)
        return part

    key = mesh.digest, "a part", "01"
    first, second = kept_or_made(key, make), kept_or_made(key, make)
    assert len(calls) == 1 and second.corners.tolist() == first.corners.tolist() == part.corners.tolist()
    assert second.triangles.tolist() == part.triangles.tolist()
    for file in (tmp_path / "cache" / "tight").glob("*.tight"):
        file.write_bytes(file.read_bytes()[:-8])
    assert kept_or_made(key, make).triangles.shape == part.triangles.shape and len(calls) == 2


def test_the_folder_of_parts_is_bounded_and_what_was_used_last_stays(monkeypatch, tmp_path):
    monkeypatch.setenv("KABO_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tight_parts, "LOOKED_AFTER", 1)
    mesh = load_mesh(MESHES / "gripper_wide" / "left_finger.stl")
    part = tight_part(mesh, ordered(enclosing_parts(mesh, 0.004)).vertices[0])
    folder = tmp_path / "cache" / "tight"
    made = kept_or_made(("", "first", ""), lambda: part)
    size = sum(file.stat().st_size for file in folder.iterdir())
    monkeypatch.setattr(tight_parts, "FILE_BYTES", 8 * size)
    for number in range(40):
        kept_or_made(("", str(number), ""), lambda: part)
        assert sum(file.stat().st_size for file in folder.iterdir()) <= 8 * size
        again = kept_or_made(("", "first", ""), lambda: pytest.fail("what is used all the time was removed"))
        assert np.array_equal(again.corners, made.corners)
    with pytest.raises(pytest.fail.Exception):
        kept_or_made(("", "0", ""), lambda: pytest.fail("removed, as it should be"))
