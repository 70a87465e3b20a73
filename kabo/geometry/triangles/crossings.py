"""Self-intersections: which faces of a triangle mesh cross another face of the same mesh.

Vertices are shared by index; faces that share one or two vertices may meet there and nowhere else. A face without
area counts as crossing unless an axis separates it from the other face. The decision is exact, without a
tolerance.
"""

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.kernels.octree import STACK_SIZE, octree_of
from kabo.geometry.triangles.kernels.orientation import SCRATCH_SIZE
from kabo.geometry.triangles.kernels.self_crossing import mark_crossing

MIN_COORDINATE = 1e-80  # [m]: exact arithmetic treats smaller coordinates as 0; the largest one is its inverse


def crossing_faces(vertices: Array, faces: Integers) -> NDArray[np.bool_]:
    """A mask (F,) of the faces that meet another face elsewhere than in the vertices or the edge that both share.

    Args:
        vertices: (V, 3) [m], finite, with absolute values less than 1e80.
        faces: (F, 3), indices of vertices.

    Raises:
        ValueError: a vertex is not finite or too large, or an index is out of range.
    """
    points = np.ascontiguousarray(vertices, dtype=np.float64).reshape(-1, 3)
    corners = np.ascontiguousarray(faces, dtype=np.int64).reshape(-1, 3)
    if not (np.abs(points) < 1.0 / MIN_COORDINATE).all():
        raise ValueError("vertices must be finite and less than 1e80 m")
    if corners.size and (corners.min() < 0 or corners.max() >= len(points)):
        raise ValueError(f"faces must name vertices 0 to {len(points) - 1}")
    crossing = np.zeros(len(corners), dtype=np.bool_)
    if len(corners) == 0:
        return crossing
    points = np.where(np.abs(points) < MIN_COORDINATE, 0.0, points)
    tree = octree_of(points.min(axis=0), points.max(axis=0), len(corners))
    stack, found = np.empty(STACK_SIZE, dtype=np.int64), np.empty(len(corners), dtype=np.int64)
    mark_crossing(points, corners, tree, stack, found, np.empty((6, 3)), np.empty(SCRATCH_SIZE), crossing)
    return crossing
