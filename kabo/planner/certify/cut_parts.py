"""Convex parts cut closer to their mesh in the directions that proofs need: each still holds what it held of the mesh.

A part sticks out of its body by up to some millimetres, mostly at its corners. Across a direction n it may be cut at the
greatest n·x of what it holds of triangles: the union of the parts covers the mesh as before, and every proof with the
old parts holds with the new ones.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry import Enclosure
from kabo.geometry.collision.separation_proofs import Parts, ordered_as_given
from kabo.geometry.parts import COLUMNS
from kabo.geometry.triangles.kernels.clipping import clipped_reach, triangles_at

SLACK = 1e-7  # [m] by which a cut stays away from the mesh: far more than verifiers move faces inwards


class Hull(NamedTuple):
    """A convex part: its corners, the triangles of its surface, and the planes n·x + d <= 0 of these."""

    corners: Array  # (V, 3) [m]
    simplices: Integers  # (F, 3)
    planes: Array  # (F, 4)


class Held(NamedTuple):
    """What a part has to hold: the triangles near it, as far as they are between the planes that it had at first."""

    triangles: Array  # (T, 3, 3) [m]
    planes: Array  # (F, 4)
    polygons: Array  # (2, F + 4, 3) room for clipping


class CutParts:
    """The parts of one mesh, in their order, and what of the mesh each has to hold."""

    def __init__(self, parts: Parts, vertices: Array, faces: Integers) -> None:
        """`vertices` (V, 3) and `faces` (F, 3) of the mesh that the parts cover."""
        self.parts = list(parts.vertices)
        self._vertices, self._faces = np.ascontiguousarray(vertices), np.ascontiguousarray(faces, np.int64)
        self._full: set[int] = set()  # parts that cannot be cut without too many corners
        self._hulls: dict[int, Hull | None] = {}
        self._holding: dict[int, Held | None] = {}
        self._room = np.empty((len(faces), 3, 3))

    def reach(self, part: int, direction: Array) -> float:
        """How far a part reaches along a direction of length 1 (3,) [m]."""
        return float((self.parts[part] @ direction).max())

    def needed(self, part: int, direction: Array, enough: float = np.inf) -> float:
        """How far a part has to reach [m]: as far as what it holds of triangles, if it is not flat.

        If that is `enough`, a lower bound of it that is as much.
        """
        if part not in self._holding:
            hull = self._hull(part)
            self._holding[part] = None if hull is None else self._held_by(hull)
        held = self._holding[part]
        if held is None:
            return self.reach(part, direction)
        n = np.ascontiguousarray(direction)
        found = clipped_reach(held.triangles, held.planes, SLACK, n, enough, held.polygons)
        return self.reach(part, direction) if found == -np.inf else float(found) + SLACK

    def cut(self, part: int, direction: Array) -> bool:
        """Whether a part could be cut to what it has to hold along a direction, with as many corners as it may have."""
        height = self.needed(part, direction)
        hull = self._hull(part)
        if part in self._full or hull is None:
            return False
        made = _below(hull, direction, height)
        if made is None or len(made.corners) > COLUMNS:
            self._full.add(part)
            return False
        self.parts[part], self._hulls[part] = made.corners, made
        return True

    def made(self) -> Parts:
        """The parts as they are now."""
        return ordered_as_given(Enclosure(tuple(self.parts), 0.0))

    def _hull(self, part: int) -> Hull | None:
        """The hull of a part as it is now; None if it is flat."""
        if part not in self._hulls:
            self._hulls[part] = _hull_of(self.parts[part])
        return self._hulls[part]

    def _held_by(self, hull: Hull) -> "Held":
        """What a part has to hold of the mesh."""
        box = np.concatenate([hull.corners.min(axis=0) - SLACK, hull.corners.max(axis=0) + SLACK])
        count = triangles_at(self._vertices, self._faces, box, self._room)
        return Held(self._room[:count].copy(), hull.planes, np.empty((2, len(hull.planes) + 4, 3)))


def _hull_of(points: Array) -> Hull | None:
    """The hull of points, of which those inside are left out; None if they are flat."""
    try:
        made = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    places = np.zeros(len(points), np.int64)
    places[made.vertices] = np.arange(len(made.vertices))
    return Hull(np.ascontiguousarray(points[made.vertices]), places[made.simplices], made.equations)


def _below(hull: Hull, direction: Array, height: float) -> Hull | None:
    """What of a convex part is where direction · x <= height; None if nothing is cut off, or too much."""
    corners, triangles = hull.corners, hull.simplices
    heights = corners @ direction
    kept = heights <= height
    if kept.all() or not kept.any():
        return None
    ends = np.concatenate([triangles[:, :2], triangles[:, 1:], triangles[:, ::2]])
    low, high = ends[kept[ends].sum(axis=1) == 1].T  # edges twice, which is no harm to their hull
    share = (height - heights[low]) / (heights[high] - heights[low])
    crossed = corners[low] + share[:, None] * (corners[high] - corners[low])
    return _hull_of(np.concatenate([corners[kept], crossed]))
