"""From solids to files: canonical triangles, binary STL, the same bytes for the same solid."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scripts.solids import Solid

SHORTEST = 2e-5  # edges below this are collapsed [m]: far above what float32 can tell apart


def triangles(solid: Solid) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Vertices (V, 3) and faces (F, 3) of a solid, in an order that depends on the shape alone."""
    mesh = solid.simplify(SHORTEST).to_mesh64()
    vertices = np.asarray(mesh.vert_properties)[:, :3].astype(np.float32) + np.float32(0.0)
    order = np.lexsort(vertices.T[::-1])
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    faces = rank[np.asarray(mesh.tri_verts, dtype=np.int64)]
    first = faces.argmin(axis=1)[:, None]
    faces = np.take_along_axis(faces, (first + np.arange(3)) % 3, axis=1)
    return vertices[order], faces[np.lexsort(faces.T[::-1])]


def write_stl(path: Path, solid: Solid, scale: float = 1.0) -> int:
    """Writes a solid as binary STL in units of 1/scale metres; returns the number of triangles."""
    vertices, faces = triangles(solid)
    corners = (vertices.astype(np.float64) / scale).astype(np.float32)[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    record = np.zeros(len(faces), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    record["normal"] = normals / np.where(lengths > 0.0, lengths, 1.0)
    record["corners"] = corners
    path.parent.mkdir(parents=True, exist_ok=True)
    header = f"kabo {path.stem}".encode().ljust(80)
    path.write_bytes(header + np.uint32(len(faces)).tobytes() + record.tobytes())
    return len(faces)
