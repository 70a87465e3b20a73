"""Triangle meshes: read through trimesh, or made from primitives; closed, in metres, with a digest."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kabo.errors import Diagnostic, MeshError
from kabo.language.formulas import Place
from kabo.language.scene_description import Shape

CIRCLE = 64  # sides of a primitive cylinder; its corners lie *outside*, so that the solid is enclosed


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh: vertices (V, 3) [m], faces (F, 3); `path` is the file it came from, None for primitives."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    path: Path | None = field(default=None, compare=False)

    @cached_property
    def digest(self) -> str:
        """The SHA-256 of the arrays."""
        content = np.ascontiguousarray(self.vertices).tobytes() + np.ascontiguousarray(self.faces).tobytes()
        return hashlib.sha256(content).hexdigest()

    def moved(self, matrix: NDArray[np.float64]) -> "Mesh":
        """This mesh under a rigid 4x4 transform; keeps its file only if nothing moves."""
        if np.array_equal(matrix, np.eye(4)):
            return self
        return Mesh(self.vertices @ matrix[:3, :3].T + matrix[:3, 3], self.faces)


def refuse(place: Place | None, message: str, hint: str | None = None) -> MeshError:
    """The error for a mesh that cannot be used, at the place in the file that names it."""
    at = place or Place("scene", 1, 1)
    return MeshError([Diagnostic(at.file, at.line, at.column, message, hint, at.length)])


def load_mesh(path: Path, scale: float | Sequence[float] = 1.0, place: Place | None = None) -> Mesh:
    """The mesh of a file (STL, OBJ, PLY, OFF, DAE, GLB), equal vertices merged, scaled to metres.

    Raises:
        MeshError: the file cannot be read, or holds no triangles, or numbers that are not finite.
    """
    try:
        seen = path.stat().st_mtime_ns
    except OSError:
        raise refuse(place, f'mesh file "{path.name}" does not exist') from None
    factors = (scale,) * 3 if isinstance(scale, (int, float)) else (*scale,)
    return _read(path, factors, seen, place)


@lru_cache(maxsize=256)
def _read(path: Path, scale: tuple[float, ...], seen: int, place: Place | None) -> Mesh:
    """Reads a file that was last changed at `seen`; two arms of one kind share their links."""
    import trimesh

    try:
        loaded = trimesh.load(path, force="mesh", process=False)
    except Exception as error:  # noqa: BLE001  readers of many formats raise whatever their parsers do
        raise refuse(place, f'mesh file "{path.name}" cannot be read: {error}') from None
    vertices = np.asarray(getattr(loaded, "vertices", np.empty((0, 3))), dtype=np.float64)
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), dtype=np.int64).reshape(-1, 3)
    if not len(faces):
        raise refuse(place, f'mesh file "{path.name}" holds no triangles')
    wrong = int((~np.isfinite(vertices).all(axis=1)).sum())
    if wrong:
        raise refuse(place, f'mesh file "{path.name}": {wrong} of {len(vertices)} vertices are not finite')
    merged, index = _distinct(vertices * np.array(scale) + 0.0)
    faces = index[faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Mesh(np.ascontiguousarray(merged), np.ascontiguousarray(faces[proper]), path)


def _distinct(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The different rows in lexicographic order, and for each row the number of its equal among them."""
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    first = np.ones(len(points), dtype=bool)
    first[1:] = np.any(ordered[1:] != ordered[:-1], axis=1)
    index = np.empty(len(points), dtype=np.int64)
    index[order] = np.cumsum(first) - 1
    return ordered[first], index


def primitive(shape: Shape) -> Mesh:
    """The mesh of a box, cylinder (axis z, centred) or sphere; round ones circumscribe the solid."""
    import trimesh

    if shape.size is None:
        raise ValueError(f"a {shape.kind} needs a size")
    if shape.kind == "box":
        made = trimesh.creation.box(extents=shape.size)
    elif shape.kind == "cylinder":
        made = trimesh.creation.cylinder(shape.size[0] / np.cos(np.pi / CIRCLE), shape.size[2], sections=CIRCLE)
    else:
        made = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
        inner = float(np.min(np.einsum("ij,ij->i", made.face_normals, made.triangles[:, 0])))
        made.apply_scale(shape.size[0] / inner)
    return Mesh(np.ascontiguousarray(made.vertices, dtype=np.float64), np.asarray(made.faces, dtype=np.int64))


def mesh_of(shape: Shape, place: Place | None) -> Mesh:
    """The mesh of any shape, in the frame of its owner [m]."""
    if shape.kind == "mesh":
        if shape.path is None:
            raise ValueError("a mesh needs a path")
        return load_mesh(shape.path, shape.scale, shape.place or place)
    return primitive(shape)
