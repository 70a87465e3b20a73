"""Mesh files: pieces are placed and joined, equal vertices merged; what is wrong is one sentence, at once."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.errors import MeshError
from kabo.meshes import load_mesh


def test_a_file_in_millimetres_is_scaled_and_its_vertices_merged(tmp_path: Path) -> None:
    path = tmp_path / "box.stl"
    trimesh.creation.box(extents=(100.0, 200.0, 300.0)).export(path)
    mesh = load_mesh(path, 0.001)
    assert mesh.vertices.shape == (8, 3)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).is_watertight


def test_a_file_that_changed_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "box.ply"
    trimesh.creation.box(extents=(1.0, 1.0, 1.0)).export(path)
    first = load_mesh(path)
    trimesh.creation.box(extents=(2.0, 1.0, 1.0)).export(path)
    assert load_mesh(path).digest != first.digest


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("none.stl", None, "does not exist"),
        ("empty.stl", b"", "is empty"),
        (
            "cut.ply",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 9\n",
            "has no whole PLY header",
        ),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1 of 3 vertices are not finite|cannot be read"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n", "cannot be read|holds no triangles"),
    ],
)
def test_an_unusable_file_is_one_error(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(MeshError, match=message):
        load_mesh(path)
