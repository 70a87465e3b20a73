"""A fast reader for OFF files of plain triangles, as kabo writes them: a hundred times faster than line by line."""

import warnings

import numpy as np

from kabo.meshes.mesh import Faces, Vertices


def plain_triangles(data: bytes) -> tuple[Vertices, Faces] | None:
    """The vertices (V, 3) and faces (F, 3) of an OFF file; None if it holds anything but plain triangles."""
    head = data[:200].split(b"\n", 2)
    if len(head) < 3 or head[0].strip() != b"OFF" or b"#" in data:
        return None
    try:
        vertices, faces = (int(word) for word in head[1].split()[:2])
        rows = data.split(b"\n")[2:]
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of rows that are not there
            points = np.loadtxt(rows[:vertices], dtype=np.float64, ndmin=2)
            corners = np.loadtxt(rows[vertices : vertices + faces], dtype=np.int64, ndmin=2)
    except (ValueError, UserWarning, OverflowError):
        return None
    if points.shape != (vertices, 3) or corners.shape != (faces, 4) or (corners[:, 0] != 3).any():
        return None
    return points, np.ascontiguousarray(corners[:, 1:])
