"""Box trees over the triangles of a mesh, as the kernels of distances want them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.geometry.parts import Array
from kabo.geometry.triangles.kernels.triangle_tree import build_tree


class TriangleTree(NamedTuple):
    """Boxes (N, 6) [m], children (N, 2), triangles (T, 3, 3) [m] in the order of the leaves, and that order (T,)."""

    boxes: Array
    children: NDArray[np.int64]
    triangles: Array
    order: NDArray[np.int64]  # the face that triangle t was


def tree_of(vertices: Array, faces: NDArray[np.int64]) -> TriangleTree:
    """The tree over the faces (F, 3) of a mesh; F is at least 1."""
    triangles = np.ascontiguousarray(vertices[faces], np.float64)
    count = len(triangles)
    order, keys = np.arange(count), np.empty(count)
    boxes, children = np.empty((2 * count, 6)), np.empty((2 * count, 2), np.int64)
    nodes = build_tree(triangles, order, keys, boxes, children, np.empty((128, 3), np.int64))
    return TriangleTree(
        boxes[:nodes].copy(), children[:nodes].copy(), np.ascontiguousarray(triangles[order]), order
    )
