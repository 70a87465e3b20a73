"""Box trees over the triangles of a mesh, as arrays for distance kernels."""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.kernels.triangle_tree import build_tree


class TriangleTree(NamedTuple):
    """A box tree: boxes (N, 6) [m], children (N, 2), triangles (T, 3, 3) [m] in leaf order, and their indices (T,)."""

    boxes: Array
    children: Integers
    triangles: Array
    order: Integers  # the face index of triangle t


def tree_of(vertices: Array, faces: Integers) -> TriangleTree:
    """The box tree over the faces (F, 3) of a mesh; F is at least 1."""
    triangles = np.ascontiguousarray(vertices[faces], np.float64)
    count = len(triangles)
    order, keys = np.arange(count), np.empty(count)
    boxes, children = np.empty((2 * count, 6)), np.empty((2 * count, 2), np.int64)
    nodes = build_tree(triangles, order, keys, boxes, children, np.empty((128, 3), np.int64))
    return TriangleTree(
        boxes[:nodes].copy(), children[:nodes].copy(), np.ascontiguousarray(triangles[order]), order
    )
