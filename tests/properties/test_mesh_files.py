"""Whatever bytes a mesh file holds, it becomes a mesh or one sentence: never a traceback, never a hang.

Files of all formats are cut, overwritten and given numbers that no mesh has. What is read has finite vertices and faces
that name them; it is examined and repaired without an error, and a repair never leaves more faults than it says.
"""

import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.errors import MeshError
from kabo.meshes import Mesh, examine, load_mesh, repaired, require_solid

KINDS = ("stl", "text.stl", "ply", "text.ply", "off", "obj", "glb", "dae")
WORDS = (b"nan", b"inf", b"1e999", b"-1", b"0", b"999999999", b"4294967295", b"x", b"\x00", b"\xff\xff\xff\x7f")
PATIENCE_S = 120.0  # of a busy machine, for a file of 3 kB


@cache
def whole(kind: str) -> bytes:
    """A sound file of the kind."""
    made = trimesh.creation.icosphere(subdivisions=1)
    if kind == "text.stl":
        content = made.export(file_type="stl_ascii")
    elif kind == "text.ply":
        content = made.export(file_type="ply", encoding="ascii")
    else:
        content = made.export(file_type=kind)
    return content if isinstance(content, bytes) else content.encode()


@st.composite
def spoilt(draw: st.DrawFn, kind: str) -> bytes:
    """A file with a few things wrong."""
    data = bytearray(whole(kind))
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(data)) | st.integers(0, min(len(data), 300)))
        way = draw(st.sampled_from(["cut", "byte", "overwrite", "insert", "repeat"]))
        if way == "cut":
            del data[at:]
        elif way == "byte" and at < len(data):
            data[at] = draw(st.integers(0, 255))
        elif way == "overwrite":
            word = draw(st.sampled_from(WORDS))
            data[at : at + len(word)] = word
        elif way == "insert":
            data[at:at] = draw(st.sampled_from(WORDS))
        elif way == "repeat":
            data[at:at] = data[at : at + draw(st.integers(1, 80))]
    return bytes(data)


def read(content: bytes, kind: str, folder: Path) -> Mesh | None:
    """The mesh, or None if it was refused in one sentence."""
    path = folder / f"mesh.{kind}"
    path.write_bytes(content)
    try:
        return load_mesh(path)
    except MeshError as error:
        (found,) = error.diagnostics
        assert found.message and "\n" not in found.message
        return None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("spoilt")


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_a_spoilt_file_is_a_mesh_or_one_sentence(kind: str, folder: Path, data: st.DataObject) -> None:
    began = time.perf_counter()
    mesh = read(data.draw(spoilt(kind)), kind, folder)
    event("refused" if mesh is None else "read")
    if mesh is not None:
        assert np.isfinite(mesh.vertices).all()
        assert len(mesh.faces) and mesh.faces.min() >= 0 and mesh.faces.max() < len(mesh.vertices)
        made, _ = repaired(mesh)
        for candidate in (mesh, made):
            try:
                require_solid(candidate)
            except MeshError as error:
                assert len(error.diagnostics) == 1
    assert time.perf_counter() - began < PATIENCE_S


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data())
def test_a_file_that_is_cut_off_is_never_taken_for_a_whole_solid(
    kind: str, folder: Path, data: st.DataObject
) -> None:
    content = whole(kind)
    kept = data.draw(st.integers(0, len(content.rstrip()) - 1))
    mesh = read(content[:kept], kind, folder)
    if mesh is not None:
        same = len(mesh.faces) == 80 and kind in {"text.ply", "off", "obj", "text.stl", "dae"}
        assert same or not examine(mesh).is_closed


@st.composite
def soups(draw: st.DrawFn) -> Mesh:
    """Any triangles on a few points of a small grid: all that can be wrong with a surface."""
    grid = st.tuples(*[st.integers(0, 2)] * 3)
    points = draw(st.lists(grid, min_size=1, max_size=9, unique=True))
    corner = st.integers(0, len(points) - 1)
    faces = draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=16))
    return Mesh(np.array(points, np.float64), np.array(faces, np.int64))


@given(mesh=soups())
def test_a_repair_of_anything_is_told_and_changes_no_point(mesh: Mesh) -> None:
    made, done = repaired(mesh)
    if not done:
        assert made is mesh
    points = {tuple(point) for point in mesh.vertices.tolist()}
    assert {tuple(point) for point in made.vertices.tolist()} <= points
    found = examine(made)
    assert not (found.repeated or found.not_finite or found.out_of_range)
    event("solid" if not (found.borders or found.crowded or found.turned or found.pinched) else "not solid")


@given(mesh=soups())
def test_the_sentence_of_a_soup_counts_what_an_obvious_count_finds(mesh: Mesh) -> None:
    proper = [tuple(face) for face in mesh.faces.tolist() if len(set(face)) == 3]
    sides: dict[frozenset[int], list[tuple[int, int]]] = {}
    for a, b, c in proper:
        for side in ((a, b), (b, c), (c, a)):
            sides.setdefault(frozenset(side), []).append(side)
    found = examine(mesh)
    assert found.repeated == len(mesh.faces) - len(proper)
    assert found.borders == sum(len(group) == 1 for group in sides.values())
    assert found.crowded == sum(len(group) > 2 for group in sides.values())
    assert found.turned == sum(len(group) == 2 and group[0] == group[1] for group in sides.values())
    assert found.duplicates == len(proper) - len({frozenset(face) for face in proper})
    balanced = all(group.count(side) * 2 == len(group) for group in sides.values() for side in group[:1])
    assert (found.unbalanced == 0) == balanced
