"""A reader for binary STL files, which most robots' meshes are: loading trimesh takes longer than reading all of them."""

import struct

import numpy as np

from kabo.meshes.mesh import Faces, Vertices

HEADER = 84  # bytes: 80 of any content, and the number of triangles
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
TRIANGLE = _TRIANGLE.itemsize  # bytes


def is_text(data: bytes) -> bool:
    """Whether an STL file is one of text; headers of binary files may begin with `solid`, too."""
    text = data[:2048].lstrip().lower()
    return text.startswith(b"solid") and (b"facet" in text or b"endsolid" in text)


def announced(data: bytes) -> int:
    """The number of triangles that a binary STL file of at least `HEADER` bytes announces."""
    (count,) = struct.unpack_from("<I", data, HEADER - 4)
    return int(count)


def binary_triangles(data: bytes) -> tuple[Vertices, Faces] | None:
    """The vertices (3 F, 3), three for each triangle, and faces (F, 3) of a binary STL file; None if it is one of text."""
    if is_text(data):
        return None
    rows = np.frombuffer(data, _TRIANGLE, announced(data), HEADER)
    vertices = rows["corners"].reshape(-1, 3).astype(np.float64)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)
