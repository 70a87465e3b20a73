"""From solids to files: canonical triangles, binary STL, the same bytes for the same solid."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scripts.solids import Solid

SHORTEST = 2e-5  # edges below this are collapsed where the shape allows it [m]
DECIMALS = 6  # corners lie on a grid of a micrometre, and those that meet there are one


def triangles(solid: Solid) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (V, 3) [m] and faces (F, 3) of a solid, in an order that depends on the shape alone."""
    mesh = solid.shell.simplify(SHORTEST).to_mesh64()
    points = np.round(np.asarray(mesh.vert_properties)[:, :3], DECIMALS) + 0.0
    vertices, place = np.unique(points, axis=0, return_inverse=True)
    faces = _without_folds(place.reshape(-1)[np.asarray(mesh.tri_verts, dtype=np.int64)])
    _require_closed(faces)
    first = faces.argmin(axis=1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return vertices, faces[np.lexsort(faces.T[::-1])]


def _without_folds(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """The faces less those that the grid made a line, and less pairs of faces that lie back to back."""
    corners = np.sort(faces, axis=1)
    proper = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
    faces, corners = faces[proper], corners[proper]
    _, which, count = np.unique(corners, axis=0, return_inverse=True, return_counts=True)
    return faces[count[which.reshape(-1)] == 1]


def _require_closed(faces: NDArray[np.int64]) -> None:
    """Every edge belongs to two faces, once in each direction."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    directed, count = np.unique(edges, axis=0, return_counts=True)
    assert (count == 1).all(), "surfaces of two parts coincide: vary a radius a little"
    assert np.array_equal(directed, np.unique(edges[:, ::-1], axis=0)), "the surface has a border"


def write_stl(path: Path, solid: Solid, scale: float = 1.0) -> int:
    """Writes a solid as binary STL in units of `scale` metres; returns the number of triangles."""
    vertices, faces = triangles(solid)
    corners = (vertices / scale).astype(np.float32)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    record = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    record["normal"] = normals / np.where(lengths > 0.0, lengths, 1.0)
    record["corners"] = corners
    path.parent.mkdir(parents=True, exist_ok=True)
    header = f"kabo {path.stem}".encode().ljust(80)
    path.write_bytes(header + np.uint32(len(faces)).tobytes() + record.tobytes())
    return len(faces)
