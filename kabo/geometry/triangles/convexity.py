"""Whether a closed mesh is convex."""

import numpy as np

from kabo.arrays import Array, Integers

PLANE_TOLERANCE = 1e-9  # [m] of rounding in the planes of a convex mesh
MAX_CONVEXITY_WORK = 20_000_000  # faces times vertices: above, convexity is not tested


def is_convex(vertices: Array, faces: Integers) -> bool:
    """Whether no vertex (V, 3) lies in front of any face (F, 3) by more than `PLANE_TOLERANCE`; False if not tested."""
    corners = vertices[faces]
    if len(faces) * len(vertices) > MAX_CONVEXITY_WORK:
        return False
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    area = lengths > 0.0  # a face without area has no front
    if not area.any():
        return False
    normals = normals[area] / lengths[area, None]
    heights = normals @ vertices.T - np.einsum("ij,ij->i", normals, corners[area, 0])[:, None]
    return bool(np.nanmax(heights) <= PLANE_TOLERANCE)
