"""Convex hulls as closed meshes whose triangles face outwards."""

import numpy as np
from scipy.spatial import ConvexHull

from kabo.arrays import Array, Integers


def hull_mesh(points: Array) -> tuple[Array, Integers]:
    """The corners (V, 3) of the hull of points (P, 3), and its triangles (F, 3), facing outwards.

    Raises:
        scipy.spatial.QhullError: the points lie in a plane.
    """
    hull = ConvexHull(points)
    number = np.full(len(points), -1)
    number[hull.vertices] = np.arange(len(hull.vertices))
    faces = number[hull.simplices]
    triangles = points[hull.vertices][faces]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inwards = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    return points[hull.vertices], faces.astype(np.int64)
