"""Shapes: meshes at unit size, so that what is proven of a mesh is proven of all its scaled and moved copies.

A shape has a bounding box with a diagonal of 1 whose lowest corner is the origin; its coordinates are rounded, so that
copies of a mesh have the same shape, whatever their size and place. The parts of a shape with deviation d are,
scaled by s, parts of the mesh with deviation s·d.
"""

import hashlib
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Integers
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh, outwards, require_closed

DIGITS = 9  # of coordinates after the point
ROUNDING = 2e-9  # a bound of the distance by which rounding moves a point of a shape, and of a part


@dataclass(frozen=True, eq=False)
class Shape:
    """A closed mesh at unit size, in canonical order; a point p of it is the point `scale`·p + `origin` of the mesh."""

    solid: Solid
    scale: float  # [m]
    origin: Array  # (3,) [m]
    digest: str  # the SHA-256 of the triangles

    def lengths(self, metres: float) -> float:
        """A length of the mesh as a length of the shape, less what rounding may add; of nine digits."""
        return float(f"{metres / self.scale - 2.0 * ROUNDING:.9g}")

    def metres(self, length: float) -> float:
        """A distance from the shape as a distance from the mesh [m], with what rounding may add."""
        return (length + ROUNDING) * self.scale

    def placed(self, part: Array) -> Array:
        """The corners (V, 3) of a part of the shape as those of a part of the mesh [m]."""
        return np.ascontiguousarray(part * self.scale + self.origin)


def shape_of(mesh: Mesh) -> Shape:
    """The shape of a closed mesh; components that are inside out are turned.

    Raises:
        MeshError: the mesh is empty, not finite, open, a needle, or has indices out of range.
    """
    require_closed(mesh)
    turned, _ = outwards(mesh)
    points = np.asarray(turned.vertices, np.float64)
    faces = np.asarray(turned.faces, np.int64)
    used = points[np.unique(faces)]
    origin = used.min(axis=0)
    scale = float(np.linalg.norm(used.max(axis=0) - origin))
    vertices, faces = canonical(np.round((points - origin) / scale, DIGITS), faces)
    if not len(faces):
        name = "mesh" if mesh.path is None else str(mesh.path)
        raise MeshError([Diagnostic(name, 1, 1, "the mesh is a line, which encloses nothing", "export it again")])
    return Shape(Solid(vertices, faces), scale, origin, digest_of(vertices, faces))


def canonical(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The vertices and faces of a mesh in canonical order, with equal vertices merged and others left out."""
    merged, index = np.unique(vertices[np.unique(faces)] + 0.0, axis=0, return_inverse=True)
    place = np.zeros(len(vertices), np.int64)
    place[np.unique(faces)] = index.reshape(-1)
    turned = place[faces]
    turned = np.take_along_axis(turned, (np.argmin(turned, axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    proper = (turned[:, 0] != turned[:, 1]) & (turned[:, 1] != turned[:, 2]) & (turned[:, 2] != turned[:, 0])
    turned = turned[proper]
    return merged, turned[np.lexsort(turned.T[::-1])]


def digest_of(vertices: Array, faces: Integers) -> str:
    """The SHA-256 of a canonical mesh."""
    return hashlib.sha256(np.ascontiguousarray(vertices[faces], "<f8").tobytes()).hexdigest()
