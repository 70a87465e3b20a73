"""The mesh that all rooms exchange: vertices in metres, triangles, the file they came from."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path

import numpy as np

from kabo.arrays import Array, Integers
from kabo.displays import counted

Vertices = Array
Faces = Integers


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh: vertices (V, 3) [m], faces (F, 3); `path` is the file it came from, None for primitives."""

    vertices: Vertices
    faces: Faces
    path: Path | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        name = "" if self.path is None else f" {self.path.name}"
        sizes = f"{counted(len(self.vertices), 'vertex', 'vertices')}, {counted(len(self.faces), 'face')}"
        return f"<Mesh{name}: {sizes}, diagonal {self.diagonal:.3g} m>"

    @cached_property
    def digest(self) -> str:
        """The SHA-256 of the arrays."""
        content = np.ascontiguousarray(self.vertices).tobytes() + np.ascontiguousarray(self.faces).tobytes()
        return hashlib.sha256(content).hexdigest()

    @cached_property
    def diagonal(self) -> float:
        """The length of the bounding box's diagonal [m]; 0 without vertices."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The least and the greatest coordinates (3,) of its vertices [m]; zeros without vertices."""
        columns = np.ascontiguousarray(self.vertices.T)  # each is read at once
        if not columns.size:
            return np.zeros(3), np.zeros(3)
        return columns.min(axis=1), columns.max(axis=1)

    @cached_property
    def box_corners(self) -> Array:
        """The corners (8, 3) of its bounding box [m]."""
        return np.array(list(product(*zip(*self.bounds, strict=True))))

    def moved(self, matrix: Array) -> "Mesh":
        """This mesh moved by a rigid 4x4 transform."""
        if np.array_equal(matrix, np.eye(4)):
            return self
        return Mesh(self.vertices @ matrix[:3, :3].T + matrix[:3, 3], self.faces, self.path)


def merged(vertices: Vertices, faces: Faces) -> tuple[Vertices, Faces]:
    """The mesh with equal vertices merged and in lexicographic order, without triangles that degenerate."""
    corners, index = distinct(vertices + 0.0)
    faces = index[faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return np.ascontiguousarray(corners), np.ascontiguousarray(faces[proper])


def distinct(points: Vertices) -> tuple[Vertices, Faces]:
    """The distinct rows in lexicographic order, and for each given row the index of its copy among them."""
    order = np.lexsort(points.T[::-1])
    ordered = points[order]
    first = np.ones(len(points), dtype=bool)
    first[1:] = np.any(ordered[1:] != ordered[:-1], axis=1)
    index = np.empty(len(points), dtype=np.int64)
    index[order] = np.cumsum(first) - 1
    return ordered[first], index
