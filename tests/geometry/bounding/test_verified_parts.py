"""Parts from a file are believed once they are proven: every forged file is as if there were none."""

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from kabo.geometry import (
    Budget,
    Enclosure,
    FixedGroup,
    bounding_decomposition,
    collides,
    enclosing_parts,
    write_parts,
)
from kabo.geometry.bounding import stored_parts, verified_parts
from kabo.geometry.bounding.shapes import shape_of
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh, load_mesh
from kabo.scene.transforms import flat

TOLERANCE = 0.004
BOX = np.array(trimesh.creation.box().vertices)  # a cube of 1 m around the origin
MESHES = Path(__file__).parents[3] / "meshes"
SHIPPED = sorted(MESHES.glob("*/*.parts"))


@pytest.fixture
def angle(tmp_path: Path) -> Mesh:
    """An L of two plates, with its parts beside it."""
    plates = [
        trimesh.creation.box(bounds=[[0, 0, 0], [0.1, 0.06, 0.01]]),
        trimesh.creation.box(bounds=[[0, 0, 0], [0.01, 0.06, 0.08]]),
    ]
    path = tmp_path / "angle.off"
    trimesh.util.concatenate(plates).export(path)
    mesh = load_mesh(path)
    write_parts(mesh, TOLERANCE)
    return mesh


def digest(mesh: Mesh) -> str:
    return shape_of(mesh).digest


def forge(mesh: Mesh, parts: list[np.ndarray], deviation: float = TOLERANCE) -> None:
    """Writes a whole file with the right digest and these parts [m]."""
    assert mesh.path is not None
    shape = shape_of(mesh)
    with np.errstate(over="ignore"):
        numbers = [((part - shape.origin) / shape.scale).reshape(-1) for part in parts]
    body = np.concatenate([*numbers, np.full(len(parts), deviation / shape.scale)]).astype("<f8").tobytes()
    entry = {"tolerance": shape.lengths(TOLERANCE), "first": 0, "corners": [len(part) for part in parts]}
    header = {"format": stored_parts.FORMAT, "method": stored_parts.METHOD_VERSION, "shape": shape.digest}
    stored_parts.write_whole(stored_parts.beside(mesh.path), {**header, "entries": [entry]}, body)


def stored(mesh: Mesh) -> list[np.ndarray]:
    assert mesh.path is not None
    shape = shape_of(mesh)
    (cover,) = stored_parts.read(stored_parts.beside(mesh.path), shape.digest)
    return [shape.placed(part) for part in cover.parts]


def loaded(mesh: Mesh, cache: Path) -> Enclosure:
    return enclosing_parts(mesh, TOLERANCE, cache=cache)


def covers(mesh: Mesh, made: Enclosure) -> bool:
    """An oracle of its own: random points of the solid lie in some part."""
    solid = Solid(mesh.vertices, mesh.faces)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (4000, 3))
    points = points[solid.insides(points)]
    hulls = [trimesh.convex.convex_hull(part) for part in made.parts]
    planes = [
        (hull.face_normals, np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])) for hull in hulls
    ]
    inside = [(points @ normals.T <= offsets + 1e-9).all(axis=1) for normals, offsets in planes]
    return bool(np.any(inside, axis=0).all())


FORGED: dict[str, Callable[[list[np.ndarray]], tuple[list[np.ndarray], float]]] = {
    "a small box elsewhere": lambda parts: ([BOX * 0.001 + 5.0], TOLERANCE),
    "a small box inside": lambda parts: ([BOX * 0.001 + 0.005], TOLERANCE),
    "one part missing": lambda parts: (parts[1:], TOLERANCE),
    "shifted by a millimetre": lambda parts: ([part + [0.001, 0, 0] for part in parts], TOLERANCE),
    "too small": lambda parts: ([part * 0.98 for part in parts], TOLERANCE),
    "nearer than it is": lambda parts: ([1.01 * part - 0.01 * part.mean(axis=0) for part in parts], 1e-7),
    "too far away": lambda parts: ([*parts, BOX * 0.02 + 0.04], TOLERANCE),
    "farther than the world": lambda parts: ([*parts, BOX * 1e300], TOLERANCE),
    "NaN": lambda parts: ([np.full((8, 3), np.nan)], TOLERANCE),
    "infinite": lambda parts: ([np.full((8, 3), np.inf), *parts], TOLERANCE),
    "no number as deviation": lambda parts: (parts, float("nan")),
    "a negative deviation": lambda parts: (parts, -0.001),
    "flat": lambda parts: ([part * [1, 1, 0] for part in parts], TOLERANCE),
    "no parts": lambda parts: ([], 0.0),
    "parts of no corners": lambda parts: ([np.empty((0, 3)), *parts], TOLERANCE),
    "too many corners": lambda parts: ([np.tile(part, (9, 1)) for part in parts], TOLERANCE),
}


@pytest.mark.parametrize("kind", FORGED)
def test_forged_parts_are_as_if_there_were_none(angle: Mesh, tmp_path: Path, kind: str) -> None:
    parts, deviation = FORGED[kind](stored(angle))
    forge(angle, parts, deviation)
    made = loaded(angle, tmp_path / "cache")
    assert covers(angle, made)
    assert made.deviation <= TOLERANCE
    assert (tmp_path / "cache").exists(), "they were made anew"


@pytest.mark.parametrize(
    "damage", ["cut off", "cut in a number", "turned", "empty", "deep", "huge counts", "text"]
)
def test_damaged_files_are_as_if_there_were_none(angle: Mesh, tmp_path: Path, damage: str) -> None:
    assert angle.path is not None
    path = stored_parts.beside(angle.path)
    whole = path.read_bytes()
    head, _, body = whole.partition(b"\n")
    header = json.loads(head)
    header["entries"][0]["corners"][0] = 2**62
    path.write_bytes(
        {
            "cut off": whole[:-24],
            "cut in a number": whole[:-1],
            "turned": whole[:-1] + bytes([whole[-1] ^ 1]),
            "empty": b"",
            "deep": b"[" * 100_000 + b"\n",
            "huge counts": json.dumps(header).encode() + b"\n" + body,
            "text": b"parts\n",
        }[damage]
    )
    assert stored_parts.read(path, digest(angle)) == []
    assert covers(angle, loaded(angle, tmp_path / "cache"))


def test_a_huge_file_is_not_read(angle: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    assert angle.path is not None
    monkeypatch.setattr(stored_parts, "MAX_FILE_BYTES", 100)
    assert stored_parts.read(stored_parts.beside(angle.path), digest(angle)) == []


def test_parts_of_another_mesh_are_not_taken(angle: Mesh, tmp_path: Path) -> None:
    assert angle.path is not None
    shutil.copy(MESHES / "crate/crate.stl.parts", stored_parts.beside(angle.path))
    assert covers(angle, loaded(angle, tmp_path / "cache"))


def test_a_forged_file_in_the_cache_is_made_anew(angle: Mesh, tmp_path: Path) -> None:
    assert angle.path is not None
    stored_parts.beside(angle.path).unlink()
    first = loaded(angle, tmp_path)
    (kept,) = tmp_path.glob("*.parts")
    whole = kept.read_bytes()
    forge(angle, [BOX * 0.001 + 5.0])
    header = json.loads(stored_parts.beside(angle.path).read_bytes().partition(b"\n")[0])
    assert header["shape"] == json.loads(whole.partition(b"\n")[0])["shape"]
    shutil.move(stored_parts.beside(angle.path), kept)
    again = loaded(angle, tmp_path)
    assert [part.tobytes() for part in again.parts] == [part.tobytes() for part in first.parts]
    assert kept.read_bytes() == whole


def test_a_forged_decomposition_in_the_cache_is_made_anew(angle: Mesh, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    first = bounding_decomposition(angle, TOLERANCE, cache=cache)
    for file in cache.iterdir():
        header = json.loads(file.read_bytes().partition(b"\n")[0])
        stored_parts.write(file, header["shape"], [Cover((BOX * 0.001 + 5.0,), (TOLERANCE,), TOLERANCE)])
    again = bounding_decomposition(angle, TOLERANCE, cache=cache)
    assert [part.tobytes() for part in again.parts] == [part.tobytes() for part in first.parts]


def test_no_collision_disappears_by_a_forged_file(angle: Mesh, tmp_path: Path) -> None:
    forge(angle, [BOX * 0.001 + 5.0])
    group = FixedGroup(flat(np.eye(4)), loaded(angle, tmp_path))
    cube = FixedGroup(flat(np.eye(4)), Enclosure((BOX * 0.01,), 0.0))
    assert collides(group, cube, Budget.share(0.01))


def test_true_parts_beside_a_mesh_are_used_as_they_are(angle: Mesh, tmp_path: Path) -> None:
    before = stored(angle)
    made = loaded(angle, tmp_path / "cache")
    assert [part.tobytes() for part in made.parts] == [part.tobytes() for part in before]
    assert not (tmp_path / "cache").exists()


@pytest.mark.parametrize("scale", [0.95, 0.7])
def test_parts_are_scaled_with_their_mesh(angle: Mesh, tmp_path: Path, scale: float) -> None:
    assert angle.path is not None
    scaled = load_mesh(angle.path, scale)
    made = loaded(scaled, tmp_path / "cache")
    assert not (tmp_path / "cache").exists(), "nothing was decomposed"
    assert covers(scaled, made)
    assert made.deviation <= TOLERANCE


@pytest.mark.parametrize("scale", [1.2, (-1.0, 1.0, 0.9), (0.9, 1.0, 0.8)])
def test_parts_that_stick_out_too_far_or_are_mirrored_or_stretched_are_made_anew(
    angle: Mesh, tmp_path: Path, scale: float | tuple[float, ...]
) -> None:
    assert angle.path is not None
    scaled = load_mesh(angle.path, scale)
    made = loaded(scaled, tmp_path / "cache")
    assert covers(scaled, made)
    assert made.deviation <= TOLERANCE or made.finer is not None


def test_scaled_and_moved_copies_share_the_cache(angle: Mesh, tmp_path: Path) -> None:
    own, cache = Mesh(angle.vertices, angle.faces), tmp_path / "cache"
    first = enclosing_parts(own, TOLERANCE, cache=cache)
    copy = Mesh(own.vertices * 0.31 + [3.0, -2.0, 7.0], own.faces)
    again = enclosing_parts(copy, 0.31 * TOLERANCE, cache=cache)
    assert len(list(cache.iterdir())) == 1
    assert again.deviation <= 0.31 * TOLERANCE
    for one, other in zip(first.parts, again.parts, strict=True):
        np.testing.assert_allclose(one * 0.31 + [3.0, -2.0, 7.0], other, atol=1e-12)


def test_a_proof_is_remembered_by_content(angle: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    assert angle.path is not None
    shape = shape_of(angle)
    (cover,) = stored_parts.read(stored_parts.beside(angle.path), shape.digest)
    assert verified_parts.are_verified(shape.solid, cover)
    monkeypatch.setattr(verified_parts, "uncovered", lambda *_: pytest.fail("asked again"))
    assert verified_parts.are_verified(shape.solid, cover)
    moved = Cover(tuple(part + 1.0 for part in cover.parts), cover.deviations, cover.tolerance)
    assert not verified_parts.are_verified(shape.solid, moved)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_shipped_parts_are_believed(path: Path) -> None:
    mesh = load_mesh(path.with_suffix(""), 0.001 if path.name.startswith("bottle") else 1.0)
    shape = shape_of(mesh)
    covers = stored_parts.read(path, shape.digest)
    assert covers
    assert all(verified_parts.are_verified(shape.solid, cover) for cover in covers)


def test_the_digest_of_the_body_is_no_proof(angle: Mesh) -> None:
    """What the forged files above have in common: each is whole."""
    assert angle.path is not None
    forge(angle, [BOX * 0.001 + 5.0])
    head, _, body = stored_parts.beside(angle.path).read_bytes().partition(b"\n")
    header: dict[str, Any] = json.loads(head)
    assert header["body"] == hashlib.sha256(body).hexdigest()
    assert header["shape"] == digest(angle)
