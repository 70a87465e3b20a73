"""Convex parts cut closer to their mesh in the directions that proofs need: each still holds what it held of the mesh.

A part sticks out of its body by up to some millimetres, mostly at its corners. Across a direction n it may be cut at the
greatest n·x of what it holds of triangles: the union of the parts covers the mesh as before, and every proof with the
old parts holds with the new ones.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry import Enclosure
from kabo.geometry.collision.separation_proofs import Parts, ordered_as_given
from kabo.geometry.parts import COLUMNS

SLACK = 1e-7  # [m] by which a cut stays away from the mesh: far more than verifiers move faces inwards
TOLERANCE = 1e-6  # share of a triangle's edges by which a point may seem to be outside of it


class CutParts:
    """The parts of one mesh, in their order, and the points of the mesh that each has to hold."""

    def __init__(self, parts: Parts, vertices: Array, faces: Integers) -> None:
        """`vertices` (V, 3) and `faces` (F, 3) of the mesh that the parts cover."""
        self.parts = list(parts.vertices)
        self._vertices, self._faces = vertices, faces
        corners = vertices[faces]
        self._boxes = corners.min(axis=1), corners.max(axis=1)  # of the triangles
        self._full: set[int] = set()  # parts that cannot be cut without too many corners
        self._held: dict[int, Array | None] = {}

    def reach(self, part: int, direction: Array) -> float:
        """How far a part reaches along a direction of length 1 (3,) [m]."""
        return float((self.parts[part] @ direction).max())

    def needed(self, part: int, direction: Array) -> float:
        """How far a part has to reach: as far as what it holds of triangles, if it is not flat [m]."""
        held = self._points(part)
        return self.reach(part, direction) if held is None else float((held @ direction).max()) + SLACK

    def cut(self, part: int, direction: Array) -> bool:
        """Whether a part could be cut to what it has to hold along a direction, with as many corners as it may have."""
        height = self.needed(part, direction)
        if part in self._full:
            return False
        made = _below(self.parts[part], direction, height)
        if made is None or len(made) > COLUMNS:
            self._full.add(part)
            return False
        self.parts[part] = made
        return True

    def made(self) -> Parts:
        """The parts as they are now."""
        return ordered_as_given(Enclosure(tuple(self.parts), 0.0))

    def _points(self, part: int) -> Array | None:
        """Points whose hull holds what of the mesh is in a part; None if the part is flat, or touches none."""
        if part not in self._held:
            self._held[part] = self._touching(self.parts[part])
        return self._held[part]

    def _touching(self, corners: Array) -> Array | None:
        """Points whose hull holds what of the triangles is in a part."""
        try:
            hull = ConvexHull(corners)
        except (QhullError, ValueError):
            return None
        faces = np.unique(hull.equations, axis=0)
        low, high = self._boxes
        boxed = self._faces[
            ((low <= corners.max(axis=0) + SLACK) & (high >= corners.min(axis=0) - SLACK)).all(axis=1)
        ]
        used = np.zeros(len(self._vertices), bool)
        used[boxed.ravel()] = True
        vertices, boxed = self._vertices[used], (np.cumsum(used) - 1)[boxed]
        heights = np.asarray(vertices @ faces[:, :3].T + faces[:, 3])
        # Of each vertex the faces that it is outside of, as bits: a triangle is outside if its corners share one.
        outside = np.packbits(heights > SLACK, axis=1)
        first, second, third = outside[boxed.T]
        near = boxed[~(first & second & third).any(axis=1)]
        inside = np.asarray(~outside.any(axis=1))
        across = near[~inside[near].all(axis=1)]
        points = [vertices[np.unique(near[inside[near]])]]
        if len(across):
            ends = np.unique(np.sort(across[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
            points.append(_in_part(vertices[ends], heights[ends]))
            lines = corners[
                np.unique(np.sort(hull.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
            ]
            points.append(_through(lines, vertices[across]))
        found = np.concatenate(points)
        return found if len(found) else None


def _in_part(edges: Array, heights: Array) -> Array:
    """The ends of what of edges (E, 2, 3) is in a part, above whose faces their ends are (E, 2, F) [m]."""
    begin, step = heights[:, 0], heights[:, 1] - heights[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (SLACK - begin) / step
    low = np.where(step < 0.0, share, 0.0).max(axis=1, initial=0.0)
    high = np.where(step > 0.0, share, 1.0).min(axis=1, initial=1.0)
    met = (low <= high) & ~((step == 0.0) & (begin > SLACK)).any(axis=1)
    start, way = edges[met, 0], edges[met, 1] - edges[met, 0]
    return np.concatenate([start + low[met, None] * way, start + high[met, None] * way])


def _through(lines: Array, triangles: Array) -> Array:
    """The points at which lines (L, 2, 3) pass through triangles (T, 3, 3)."""
    start, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    normals = np.cross(u, v)
    begin = ((lines[:, None, 0] - start) * normals).sum(axis=2)
    end = ((lines[:, None, 1] - start) * normals).sum(axis=2)
    line, number = np.nonzero((begin * end <= 0.0) & (begin != end))
    share = begin[line, number] / (begin[line, number] - end[line, number])
    points = lines[line, 0] + share[:, None] * (lines[line, 1] - lines[line, 0])
    away, n = points - start[number], normals[number]
    square = (n * n).sum(axis=1)
    a = (np.cross(away, v[number]) * n).sum(axis=1) / square
    b = (np.cross(u[number], away) * n).sum(axis=1) / square
    return np.asarray(points[(a >= -TOLERANCE) & (b >= -TOLERANCE) & (a + b <= 1.0 + TOLERANCE)])


def _below(corners: Array, direction: Array, height: float) -> Array | None:
    """The corners of a convex part where direction · x <= height; None if nothing is cut off, or too much."""
    heights = corners @ direction
    kept = heights <= height
    if kept.all() or not kept.any():
        return None
    try:
        triangles = ConvexHull(corners).simplices
        edges = np.unique(
            np.sort(np.concatenate([triangles[:, :2], triangles[:, 1:], triangles[:, ::2]]), axis=1), axis=0
        )
        low, high = np.where(kept[edges[:, :1]], edges, edges[:, ::-1]).T
        crossing = kept[low] & ~kept[high]
        low, high = low[crossing], high[crossing]
        share = (height - heights[low]) / (heights[high] - heights[low])
        points = np.concatenate([corners[kept], corners[low] + share[:, None] * (corners[high] - corners[low])])
        return np.ascontiguousarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        return None
