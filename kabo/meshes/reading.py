"""Reads mesh files through trimesh: all pieces of a file become one mesh in metres, or one sentence says why not.

Readers of many formats trust the sizes that a file announces, so `kabo.meshes.headers` compares these with its
size before anything is allocated.
"""

import hashlib
import logging
import math
import re
from collections.abc import Iterable, Sequence
from io import BytesIO
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from kabo.content_cache import ContentCache
from kabo.displays import counted
from kabo.errors import did_you_mean
from kabo.given import as_float, require_flag, require_given, require_path, shown
from kabo.language.formulas import Place
from kabo.meshes.headers import MESH_FORMATS, misleading
from kabo.meshes.mesh import Faces, Mesh, Vertices, merged
from kabo.meshes.mesh_errors import EXPORT_HINT, FETCH_HINT, refuse, require_numbers, unusable
from kabo.meshes.repair import repaired

FORMATS = tuple(MESH_FORMATS)
MAX_FILE_BYTES = 2 * 1024**3  # bytes
_MAX_PARSER_CHARACTERS = 160  # characters of a parser's error that a message repeats
_LOG = logging.getLogger("kabo.meshes")
_TRIANGLES: ContentCache[tuple[Vertices, Faces]] = ContentCache(
    16 << 20, lambda made: made[0].nbytes + made[1].nbytes
)

# What trimesh complains of, kabo says itself.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

LFS_POINTER = b"version https://git-lfs.github.com/spec/"  # what a clone holds until the large files are fetched

WEB_PAGES = (b"<!doctype html", b"<html")  # what is saved of a link to a page about the file
PAGE_HINT = "download the file itself, for example by the link `Raw` of its page"


def load_mesh(
    path: str | Path,
    scale: float | Sequence[float] = 1.0,
    place: Place | None = None,
    *,
    repair: bool = False,
) -> Mesh:
    """The mesh of a file (STL, OBJ, PLY, OFF, DAE, GLB), equal vertices merged, scaled to metres.

    All pieces of a file are placed by their nodes and put together; faces with more corners become triangles; a
    mirroring scale turns the faces, so that they still point outwards.

    Args:
        path: the file.
        scale: metres per unit of the file, one for all axes or one for each.
        place: the place in a file that names the mesh, for errors.
        repair: apply the safe repairs of `kabo.meshes.repaired`.

    Raises:
        ArgumentError: an argument is of a wrong kind.
        MeshError: the file cannot be read, or holds no triangles, or numbers that are not finite.
    """
    path = require_path("path", path)
    require_given("place", place, Place, type(None))
    require_flag("repair", repair)
    place = place or Place(str(path), 1, 1)
    given = (scale,) * 3 if isinstance(scale, Real) else tuple(scale) if isinstance(scale, Iterable) else ()
    factors = tuple(as_float(each) for each in given if isinstance(each, Real) and not isinstance(each, bool))
    if (
        len(given) != 3
        or not all(math.isfinite(factor) and factor != 0.0 for factor in factors)
        or len(factors) != 3
    ):
        what = f"a mesh cannot be scaled by {shown(scale)}"
        raise refuse(place, what, "write a number, e.g. 0.001 for millimetres")
    _require_readable(path, place)
    mesh = _read(path, factors, place)
    if repair:
        mesh, _ = repaired(mesh)
    return mesh


def _require_readable(path: Path, place: Place) -> None:
    """Raises MeshError if the path is missing, is not a file, or is larger than any intended mesh."""
    try:
        status = path.stat()
    except (OSError, ValueError):  # ValueError: a null byte in the name
        raise refuse(place, f'mesh file "{path.name}" does not exist') from None
    if not path.is_file():
        raise refuse(place, f'mesh file "{path.name}" is not a file')
    if status.st_size > MAX_FILE_BYTES:
        raise refuse(place, f'mesh file "{path.name}" is larger than 2 GiB', "simplify the mesh before")


def _read(path: Path, scale: tuple[float, float, float], place: Place) -> Mesh:
    """The mesh of a file; files with equal content share their arrays, as two arms of one kind do."""
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        known = [f".{name}" for name in FORMATS]
        hint = did_you_mean(f".{kind}", known) or f"kabo reads {', '.join(known)}"
        raise refuse(place, f'mesh file "{path.name}" has no ending of a format that kabo reads', hint)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise refuse(place, f'mesh file "{path.name}" cannot be read: {error.strerror}') from None
    _LOG.debug("read %s", path, extra={"fields": {"file": str(path), "bytes": len(data)}})
    key = hashlib.sha256(data).digest(), kind, scale
    vertices, faces = _TRIANGLES.get_or_make(key, lambda: _triangles(data, kind, scale, path, place))
    return Mesh(vertices, faces, path)


def _triangles(
    data: bytes, kind: str, scale: tuple[float, float, float], path: Path, place: Place
) -> tuple[Vertices, Faces]:
    """The vertices and triangles in a file's content; `path` and `place` appear in errors only."""
    if data.startswith(LFS_POINTER):
        raise refuse(place, f'mesh file "{path.name}" is a pointer of Git LFS, not the mesh', FETCH_HINT)
    if data[:256].lstrip(b"\xef\xbb\xbf \t\r\n").lower().startswith(WEB_PAGES):
        raise refuse(place, f'mesh file "{path.name}" is a web page (HTML), not the mesh', PAGE_HINT)
    data = readable(data, kind)
    why = misleading(kind, data)
    if why is not None:
        raise refuse(place, f'mesh file "{path.name}" {why}', EXPORT_HINT)
    vertices, faces = joined(_parsed(data, kind, path.name, place), scale)
    if not len(faces):
        raise refuse(place, f'mesh file "{path.name}" holds no triangles', EXPORT_HINT)
    require_numbers(Mesh(vertices, faces, path), place)
    mesh = Mesh(*merged(vertices, faces), path)
    if not len(mesh.faces):
        said = f"has {counted(len(faces), 'triangle')}, none of which has three different vertices"
        raise unusable(mesh, place, said, EXPORT_HINT)
    return mesh.vertices, mesh.faces


def readable(data: bytes, kind: str) -> bytes:
    """The content of an OBJ file as UTF-8; older programs write names and comments in Latin-1."""
    if kind != "obj":
        return data
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


def _parsed(data: bytes, kind: str, name: str, place: Place) -> list[tuple[Vertices, Faces]]:
    """The pieces of a mesh file; any error of a parser becomes a MeshError of one sentence."""
    if kind == "dae" and not _has_collada():
        hint = 'install it with the extra: pip install "kabo[robots]"'
        raise refuse(place, f'mesh file "{name}": reading DAE needs the library pycollada', hint)
    try:
        return pieces(data, kind)
    except Exception as error:  # noqa: BLE001  readers of many formats raise whatever their parsers do
        if isinstance(error, IndexError):  # of numpy, in readers that trust the numbers of vertices
            said = f'mesh file "{name}" cannot be read: its faces name vertices that it does not have'
            raise refuse(place, said, EXPORT_HINT) from None
        words = re.sub(r"\b\w*(Error|Exception): ", "", str(error)).split()  # names of a parser's classes
        said = " ".join(words)[:_MAX_PARSER_CHARACTERS] or type(error).__name__
        raise refuse(place, f'mesh file "{name}" cannot be read: {said}', EXPORT_HINT) from None


def _has_collada() -> bool:
    from importlib.util import find_spec

    return find_spec("collada") is not None


def pieces(data: bytes, kind: str) -> list[tuple[Vertices, Faces]]:
    """The triangle meshes in a file's content, each moved to where its node places it, in the file's units.

    Raises:
        Exception: whatever the reader of this format raises on bytes that it does not understand.
    """
    read = MESH_FORMATS[kind].read
    own = None if read is None else read(data)
    if own is not None:
        return [own]
    import trimesh

    with np.errstate(all="ignore"):
        scene = trimesh.load_scene(BytesIO(data), file_type=kind, process=False)
        found = []
        for node in scene.graph.nodes_geometry:
            matrix, name = scene.graph[node]
            shape = scene.geometry[name]
            if len(getattr(shape, "faces", ())) == 0:  # points and curves enclose nothing
                continue
            vertices = np.asarray(shape.vertices, dtype=np.float64).reshape(-1, 3)
            faces = np.asarray(shape.faces, dtype=np.int64).reshape(-1, 3)
            matrix = np.asarray(matrix, dtype=np.float64)
            if not np.array_equal(matrix, np.eye(4)):
                vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
                if np.linalg.det(matrix[:3, :3]) < 0.0:
                    faces = faces[:, ::-1]
            found.append((vertices * _unit(shape), faces))
    return found


def _unit(shape: Any) -> float:
    """Metres per unit, if the file says so itself (DAE), else 1."""
    said = str(shape.metadata.get("units", ""))
    return float(said.removesuffix(" * meters")) if said.endswith(" * meters") else 1.0


def joined(found: list[tuple[Vertices, Faces]], scale: tuple[float, float, float]) -> tuple[Vertices, Faces]:
    """All pieces in one mesh, scaled; a face that names a vertex its piece lacks stays out of range."""
    if not found:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in found)])
    total = int(starts[-1])
    shifted = [
        np.where((faces >= 0) & (faces < len(vertices)), faces + start, total)
        for (vertices, faces), start in zip(found, starts[:-1], strict=True)
    ]
    faces = np.concatenate(shifted)
    if math.prod(scale) < 0.0:
        faces = faces[:, ::-1]
    with np.errstate(all="ignore"):
        return np.concatenate([vertices for vertices, _ in found]) * np.array(scale), faces
