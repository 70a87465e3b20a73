"""Mesh files: pieces are placed and joined, equal vertices merged; what is wrong is one sentence, at once."""

import json
import re
import struct
import sys
import tracemalloc
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.errors import MeshError
from kabo.meshes import load_mesh
from kabo.meshes.plain_stl import binary_triangles
from kabo.meshes.reading import pieces
from tests.meshes.solids import volume

REPOSITORY = Path(__file__).parents[2]


def test_a_file_in_millimetres_is_scaled_and_its_vertices_merged(tmp_path: Path) -> None:
    path = tmp_path / "box.stl"
    trimesh.creation.box(extents=(100.0, 200.0, 300.0)).export(path)
    mesh = load_mesh(path, 0.001)
    assert mesh.vertices.shape == (8, 3)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).is_watertight


def test_only_equal_vertices_are_merged(tmp_path: Path) -> None:
    path = tmp_path / "near.off"
    path.write_text("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1e-12\n3 0 1 2\n3 3 2 1\n")
    assert len(load_mesh(path).vertices) == 4


def test_a_file_that_changed_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "box.ply"
    trimesh.creation.box(extents=(1.0, 1.0, 1.0)).export(path)
    first = load_mesh(path)
    trimesh.creation.box(extents=(2.0, 1.0, 1.0)).export(path)
    assert load_mesh(path).digest != first.digest


@pytest.mark.parametrize("name", ["m.stl", "m.STL", "m.obj", "m.ply", "m.off", "m.dae", "m.glb"])
def test_all_formats_give_the_same_solid(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    kind = path.suffix.lower()[1:]
    made = trimesh.creation.icosphere(subdivisions=1).export(file_type=kind)
    path.write_bytes(made if isinstance(made, bytes) else made.encode())
    mesh = load_mesh(str(path))
    assert (len(mesh.vertices), len(mesh.faces), mesh.path) == (42, 80, path)
    assert volume(mesh) == pytest.approx(3.6588, abs=1e-3)


@pytest.mark.parametrize("encoding", ["stl_ascii", "ply_ascii"])
def test_text_variants_are_read(tmp_path: Path, encoding: str) -> None:
    box = trimesh.creation.box()
    kind = encoding[:3]
    content = box.export(file_type="stl_ascii") if kind == "stl" else box.export(file_type="ply", encoding="ascii")
    path = tmp_path / f"box.{kind}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert volume(load_mesh(path)) == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["glb", "obj"])
def test_pieces_stand_where_their_nodes_place_them_and_mirrored_ones_point_outwards(
    tmp_path: Path, kind: str
) -> None:
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([3, 0, 0]))
    scene.add_geometry(trimesh.creation.box(), transform=np.diag([1.0, 1.0, -2.0, 1.0]))
    path = tmp_path / f"two.{kind}"
    scene.export(path)
    mesh = load_mesh(path)
    assert len(mesh.faces) == 24
    assert mesh.vertices.min(axis=0) == pytest.approx([-0.5, -0.5, -1.0])
    assert mesh.vertices.max(axis=0) == pytest.approx([3.5, 0.5, 1.0])
    assert volume(mesh) == pytest.approx(3.0)


def test_a_mirroring_scale_keeps_the_faces_outwards(tmp_path: Path) -> None:
    path = tmp_path / "box.off"
    trimesh.creation.box().export(path)
    assert volume(load_mesh(path, (1.0, -2.0, 1.0))) == pytest.approx(2.0)


def test_the_unit_of_a_dae_file_counts(tmp_path: Path) -> None:
    path = tmp_path / "box.dae"
    path.write_bytes(
        trimesh.creation.box().export(file_type="dae").replace(b"<up_axis>", b'<unit meter="0.01"/><up_axis>')
    )
    assert volume(load_mesh(path)) == pytest.approx(1e-6)


def test_faces_with_four_corners_become_triangles(tmp_path: Path) -> None:
    path = tmp_path / "square.off"
    path.write_text("OFF\n# a square\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    assert len(load_mesh(path).faces) == 2


def test_dae_without_its_library_is_one_sentence_with_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "box.dae"
    path.write_bytes(trimesh.creation.box().export(file_type="dae"))
    monkeypatch.setitem(sys.modules, "collada", None)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MeshError, match=r"needs the library pycollada\n.*kabo\[robots\]"):
        load_mesh(path)


PLY = (
    "ply\nformat {}\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
    "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
)
HUGE = {
    "text.ply": PLY.format("ascii 1.0", 10**9, 1).encode() + b"0 0 0\n",
    "vertices.ply": PLY.format("binary_little_endian 1.0", 10**9, 1).encode() + bytes(100),
    "faces.ply": PLY.format("binary_little_endian 1.0", 3, 10**9).encode() + bytes(100),
    "binary.stl": b"x" * 80 + struct.pack("<I", 10**9) + bytes(100),
    "counts.off": b"OFF\n1000000000 1000000000 0\n0 0 0\n",
    "length.glb": b"glTF" + struct.pack("<II", 2, 1 << 31) + struct.pack("<I4s", 10, b"JSON") + b"{}        ",
}


@pytest.mark.parametrize("name", HUGE)
def test_a_header_that_announces_too_much_is_refused_at_once(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(HUGE[name])
    tracemalloc.start()
    try:
        with pytest.raises(MeshError) as caught:
            load_mesh(path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert "announces" in caught.value.diagnostics[0].message  # the text of the error holds the path as well
    assert most < 1e7  # bytes: nothing was made room for


def glb(**changes: object) -> bytes:
    """A GLB file of one triangle, with some keys of its tree replaced."""
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
        "buffers": [{"byteLength": 48}],
        **changes,
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    body += struct.pack("<I4s9f3I", 48, b"BIN\0", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def nested(levels: int) -> bytes:
    """A DAE file in which each node stands for two of the next one: 2^levels boxes."""
    text = trimesh.creation.box().export(file_type="dae").decode()
    start = text.index("<node")
    end = text.index("</visual_scene>")
    inner = text[start:end].replace('id="node0"', 'id="n0"')
    nodes = "".join(
        f'<node id="n{k}"><instance_node url="#n{k - 1}"/><instance_node url="#n{k - 1}"/></node>'
        for k in range(1, levels + 1)
    )
    text = text[:start] + f'<node><instance_node url="#n{levels}"/></node>' + text[end:]
    return text.replace("<scene>", f"<library_nodes>{inner}{nodes}</library_nodes><scene>", 1).encode()


UNREAD = {
    "twice.glb": (glb(nodes=[{"children": [1]}, {"children": [2], "mesh": 0}, {"children": [1]}]), "twice"),
    "count.glb": (glb(accessors=[{"componentType": 5126, "count": 10**9, "type": "VEC3"}]), "announces"),
    "sparse.glb": (glb(accessors=[{"componentType": 5126, "count": 3, "type": "VEC3", "sparse": {}}]), "sparse"),
    "draco.glb": (glb(extensionsUsed=["KHR_draco_mesh_compression"]), "compressed"),
    "fan.glb": (glb(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}]), "fans"),
    "nan.glb": (glb(nodes=[{"mesh": 0, "matrix": [float("nan")] * 16}]), "3 of 3 vertices are not finite"),
    "entity.dae": (b'<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>', "entities"),
    "nested.dae": (nested(40), "1099511627776 meshes"),
    "strips.dae": (b"<COLLADA><tristrips /></COLLADA>", "tristrips"),
    "zero.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "count from 1"),
    "absent.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "cannot be read"),
    "absent.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "vertex that is not there"),
    "short.off": (b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "cut off"),
    "damaged.stl": (b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendsolid", "damaged"),
    "line.off": (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1\n", "three different"),
    "far.off": (b"OFF\n3 1 0\n0 0 0\n1e300 0 0\n0 1 0\n3 0 1 2\n", "from the origin"),
    "none.stl": (None, "does not exist"),
    "empty.stl": (b"", "is empty"),
    "cut.ply": (b"ply\nformat binary_little_endian 1.0\nelement vertex 9\n", "no whole PLY header"),
    "nan.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1 of 3 vertices are not finite"),
    "points.obj": (b"v 0 0 0\nv 1 0 0\n", "holds no triangles|cannot be read"),
    "mesh.step": (b"x", "no ending"),
    "\0.stl": (None, "does not exist"),
}


@pytest.mark.parametrize("name", UNREAD)
def test_an_unusable_file_is_one_sentence(tmp_path: Path, name: str) -> None:
    content, message = UNREAD[name]
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(MeshError) as caught:
        load_mesh(path)
    (found,) = caught.value.diagnostics
    assert re.search(message, found.message), found.message
    assert "\n" not in found.message and found.file == str(path)


def test_a_folder_and_an_unreadable_file_are_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(MeshError, match="is not a file"):
        load_mesh(tmp_path)
    path = tmp_path / "box.off"
    trimesh.creation.box().export(path)

    def refused(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refused)  # as root, no file is unreadable
    with pytest.raises(MeshError, match="Permission denied"):
        load_mesh(path)


@pytest.mark.parametrize("scale", [0.0, float("nan"), (1.0, 1.0), (1.0, 0.0, 1.0)])
def test_a_scale_that_is_none_is_refused(tmp_path: Path, scale: float) -> None:
    path = tmp_path / "box.off"
    trimesh.creation.box().export(path)
    with pytest.raises(MeshError, match="cannot be scaled"):
        load_mesh(path, scale)


@pytest.mark.parametrize("page", ["\n<!DOCTYPE html>\n<html lang='en'>…</html>", "<html><body>404</body></html>"])
def test_a_web_page_is_called_so(tmp_path: Path, page: str) -> None:
    path = tmp_path / "hand.stl"
    path.write_text(page + " " * 100)
    with pytest.raises(MeshError, match=r'"hand.stl" is a web page(.|\n)*download the file itself'):
        load_mesh(path)


def test_a_pointer_of_git_lfs_is_called_so(tmp_path: Path) -> None:
    path = tmp_path / "hand.stl"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 120\n")
    with pytest.raises(MeshError, match=r'"hand.stl" is a pointer of Git LFS(.|\n)*git lfs pull'):
        load_mesh(path)


def test_a_cut_off_dae_is_told_without_the_names_of_parsers(tmp_path: Path) -> None:
    path = tmp_path / "hand.dae"
    path.write_text("<COLLADA><x>")
    with pytest.raises(MeshError, match="no element found") as raised:
        load_mesh(path)
    assert "Error:" not in str(raised.value)


@pytest.mark.parametrize("header", [b"", b"solid of a binary file", b"  SOLID \xff\x00"])
def test_a_binary_stl_file_is_read_as_trimesh_reads_it(header: bytes) -> None:
    made = trimesh.creation.icosphere(subdivisions=2, radius=0.1).export(file_type="stl")
    data = header.ljust(80, b"\0") + made[80:]
    ((vertices, faces),) = pieces(data, "stl")
    theirs = trimesh.load(BytesIO(data), file_type="stl", process=False)
    assert np.array_equal(vertices, theirs.vertices)
    assert np.array_equal(faces, theirs.faces)


def test_the_meshes_of_the_repository_are_read_without_trimesh() -> None:
    files = sorted(REPOSITORY.glob("meshes/**/*.stl"))
    assert files
    for file in files:
        made = binary_triangles(file.read_bytes())
        theirs = trimesh.load(file, process=False)
        assert made is not None
        assert np.array_equal(made[0], theirs.vertices)
        assert np.array_equal(made[1], theirs.faces)
