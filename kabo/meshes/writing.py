"""Writes mesh files in full precision: under a temporary name, read back, compared bit by bit, then renamed.

A bound that is proven in double precision is lost in single precision: a vertex that is rounded inwards no longer
covers what it covered. So formats of single precision (STL, GLB) are refused.
"""

import os
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from kabo.errors import Diagnostic, InputError, KaboError
from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.reading import pieces

Piece = tuple[str, Vertices, Faces]


def write_off(path: str | Path, vertices: Vertices, faces: Faces) -> None:
    """Writes one mesh as an OFF file of plain triangles with 17 digits, atomically.

    Args:
        path: the file, whose name ends in `.off`.
        vertices: the vertices (V, 3) [m].
        faces: the vertex indices (F, 3) of the triangles.

    Raises:
        InputError: another ending. OSError: the folder cannot be written. KaboError: what is read back differs.
    """
    if Path(path).suffix.lower() != ".off":
        raise _refused(Path(path), "an OFF file ends with .off")
    write_pieces(path, [("mesh", vertices, faces)])


def write_mesh(path: str | Path, vertices: Vertices, faces: Faces) -> None:
    """Writes one mesh in the format that the file's ending names (`.off`, `.ply`, `.obj`); raises as `write_off`."""
    write_pieces(path, [("mesh", vertices, faces)])


def write_pieces(path: str | Path, named: Sequence[Piece]) -> None:
    """Writes several meshes to one file: in OBJ as separate objects, in OFF and PLY concatenated.

    Args:
        path: the file, whose name ends in `.off`, `.ply` or `.obj`.
        named: the name, vertices (V, 3) [m] and faces (F, 3) of each mesh.

    Raises:
        InputError: another ending. OSError: the folder cannot be written. KaboError: what is read back differs.
    """
    path = Path(path)
    require_written(path)
    solid = [
        (name, np.ascontiguousarray(vertices, np.float64) + 0.0, np.ascontiguousarray(faces, np.int64))
        for name, vertices, faces in named
    ]
    content = _WRITERS[path.suffix.lower()](solid)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.part")
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        _compare(temporary.read_bytes(), path, solid)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def require_written(path: Path) -> None:
    """Raises InputError unless the file's ending names a format that keeps all digits."""
    kind = path.suffix.lower()
    if kind in WRITTEN:
        return
    if kind in {".stl", ".glb", ".gltf"}:
        said = f"{kind[1:].upper()} keeps single precision, which would break what is proven of the result"
    else:
        said = f"kabo writes no {kind or 'files without an ending'}"
    raise _refused(path, said)


def _refused(path: Path, said: str) -> InputError:
    first, *others, last = WRITTEN
    instead = f"write {path.stem or 'mesh'}{', '.join((first, *others))} or {last} instead"
    return InputError([Diagnostic(str(path), 1, 1, said, instead)])


def _joined(named: Sequence[Piece]) -> tuple[Vertices, Faces]:
    starts = np.cumsum([0, *(len(vertices) for _, vertices, _ in named)])
    vertices = np.concatenate([vertices for _, vertices, _ in named])
    return vertices, np.concatenate([faces + start for (_, _, faces), start in zip(named, starts, strict=False)])


def _off(named: Sequence[Piece]) -> bytes:
    vertices, faces = _joined(named)
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"]
    lines += ["%.17g %.17g %.17g" % (x, y, z) for x, y, z in vertices.tolist()]  # noqa: UP031  the fastest way
    lines += [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
    return ("\n".join(lines) + "\n").encode()


def _obj(named: Sequence[Piece]) -> bytes:
    lines: list[str] = []
    first = 1
    for name, vertices, faces in named:
        lines.append(f"o {name}")
        lines += ["v %.17g %.17g %.17g" % (x, y, z) for x, y, z in vertices.tolist()]  # noqa: UP031
        lines += [f"f {a} {b} {c}" for a, b, c in (faces + first).tolist()]
        first += len(vertices)
    return ("\n".join(lines) + "\n").encode()


def _ply(named: Sequence[Piece]) -> bytes:
    vertices, faces = _joined(named)
    head = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    rows = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    return ("\n".join(head) + "\n").encode() + vertices.astype("<f8").tobytes() + rows.tobytes()


# The formats that kabo writes, by the ending of their files: all keep doubles whole, and `pieces` reads them back.
_WRITERS: dict[str, Callable[[Sequence[Piece]], bytes]] = {".off": _off, ".ply": _ply, ".obj": _obj}
WRITTEN = tuple(_WRITERS)


def _compare(data: bytes, path: Path, named: Sequence[Piece]) -> None:
    """Raises KaboError unless an independent reader finds the same triangles with the same coordinates, bit by bit."""
    read = pieces(data, path.suffix.lower()[1:])
    expected = np.concatenate([vertices[faces] for _, vertices, faces in named])
    found = np.concatenate([vertices[faces] for vertices, faces in read]) if read else np.empty((0, 3, 3))
    if expected.shape != found.shape or expected.tobytes() != np.ascontiguousarray(found + 0.0).tobytes():
        raise KaboError(f"{path}: what was written is not what is read back; nothing was written")
