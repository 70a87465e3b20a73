"""Written meshes: every bit comes back, whatever the numbers; a file is whole or absent."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.errors import InputError, KaboError
from kabo.meshes import hull_faces, load_mesh, write_mesh, write_off, write_pieces
from tests.meshes.solids import box

FACES = box().faces


def awkward(seed: int = 0) -> np.ndarray:
    """Eight vertices whose coordinates need all their digits."""
    numbers = np.random.default_rng(seed).normal(size=(8, 3)) * 10.0 ** np.arange(-7.0, 1.0)[:, None]
    numbers[0] = [0.1, 1 / 3, np.nextafter(1.0, 2.0)]
    return numbers


@pytest.mark.parametrize("kind", ["off", "ply", "obj"])
def test_all_digits_come_back(tmp_path: Path, kind: str) -> None:
    vertices = awkward()
    write_mesh(tmp_path / f"m.{kind}", vertices, FACES)
    read = trimesh.load(tmp_path / f"m.{kind}", process=False, force="mesh")
    assert np.array_equal(np.asarray(read.vertices)[read.faces], vertices[FACES])
    loaded = load_mesh(tmp_path / f"m.{kind}")
    assert {tuple(v) for v in loaded.vertices} == {tuple(v) for v in vertices}
    assert [path.name for path in tmp_path.iterdir()] == [f"m.{kind}"]


def test_an_off_file_is_plain_triangles(tmp_path: Path) -> None:
    write_off(
        tmp_path / "m.off", np.array([[0.1, 0.0, -0.0], [1.0, 0.0, 0.0], [0.0, 1e-30, 0.0]]), np.array([[0, 1, 2]])
    )
    assert (tmp_path / "m.off").read_text() == (
        "OFF\n3 1 0\n0.10000000000000001 0 0\n1 0 0\n0 1.0000000000000001e-30 0\n3 0 1 2\n"
    )


def test_an_obj_file_holds_one_object_for_each_piece(tmp_path: Path) -> None:
    pieces = [(f"part_{k}", box(at=(2.0 * k, 0.0, 0.0)).vertices, FACES) for k in range(3)]
    write_pieces(tmp_path / "parts.obj", pieces)
    scene = trimesh.load_scene(tmp_path / "parts.obj", process=False, split_objects=True)
    assert set(scene.geometry) == {"part_0", "part_1", "part_2"}
    assert (tmp_path / "parts.obj").read_text().count("\no part_") + 1 == 3


@pytest.mark.parametrize("name", ["m.stl", "m.glb"])
def test_single_precision_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"single precision.*\n.*m\.off"):
        write_mesh(tmp_path / name, awkward(), FACES)
    with pytest.raises(InputError, match="ends with .off"):
        write_off(tmp_path / name, awkward(), FACES)


def test_a_difference_leaves_the_old_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.off"
    write_off(path, awkward(), FACES)
    before = path.read_bytes()
    monkeypatch.setattr("kabo.meshes.writing.pieces", lambda *_: [(awkward(1), FACES)])
    with pytest.raises(KaboError, match="not what is read back"):
        write_off(path, awkward(), FACES)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def test_the_hull_of_a_part_points_outwards() -> None:
    vertices = awkward()
    made = trimesh.Trimesh(vertices, hull_faces(vertices), process=False)
    assert made.is_watertight and made.is_winding_consistent and made.volume > 0.0
    with pytest.raises(KaboError, match="no hull"):
        hull_faces(np.eye(3))
