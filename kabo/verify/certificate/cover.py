"""Checks that convex parts cover a mesh: what lies inside a part is cut off, until nothing is left.

A triangle whose corners are in one part lies in that part. Any other triangle is cut along the planes of the faces of
each part in turn; the pieces outside of the part go on to the next part.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers

# A part's faces are moved inwards by more than planes and cuts are rounded by: shares of its size (to 1 m) and place.
SIZE_TOLERANCE, PLACE_TOLERANCE = 1e-10, 1e-13


class Faces(NamedTuple):
    """The face planes of a convex part, n @ x <= offset, moved inwards by `face_tolerance`."""

    normals: Array  # (F, 3)
    offsets: Array  # (F,)


def face_tolerance(part: Array) -> float:
    """By how much the faces of a part (V, 3) are moved inwards [m]: little for small parts, as these enclose tightly."""
    size = float(np.linalg.norm(np.ptp(part, axis=0)))
    return SIZE_TOLERANCE * min(1.0, size) + PLACE_TOLERANCE * float(np.abs(part).max())


def faces_of(part: Array) -> Faces | None:
    """The faces of the convex hull of a part's vertices (V, 3); None if the hull has no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(part)
    except (QhullError, ValueError):
        return None
    normals = hull.equations[:, :3]
    # The offset is that of the farthest vertex; qhull's own may lie outside of all vertices.
    offsets = (part @ normals.T).max(axis=0) - face_tolerance(part)
    return Faces(normals, offsets)


def uncovered(vertices: Array, triangles: Integers, parts: Sequence[Array]) -> int | None:
    """The index of the first of the triangles (F, 3) that the parts do not cover; None if they cover all."""
    faces = [found for found in map(faces_of, parts) if found is not None]
    held = np.zeros(len(triangles), bool)
    for part in faces:
        inside = np.all(vertices @ part.normals.T <= part.offsets, axis=1)
        held |= np.all(inside[triangles], axis=1)
    left = np.flatnonzero(~held)
    corners = vertices[triangles[left]]
    meets = [~np.any(np.all(corners @ part.normals.T > part.offsets, axis=1), axis=1) for part in faces]
    for row, index in enumerate(left):
        if not covered(corners[row], [part for part, met in zip(faces, meets, strict=True) if met[row]]):
            return int(index)
    return None


def covered(polygon: Array, parts: Sequence[Faces]) -> bool:
    """Whether a convex polygon with corners (C, 3) lies in the union of the convex parts."""
    left = [polygon]
    for part in parts:
        left = [piece for before in left for piece in outside(before, part)]
        if not left:
            return True
    return False


def outside(polygon: Array, part: Faces) -> list[Array]:
    """The rest of a convex polygon after the region inside a convex part is cut out, as convex polygons."""
    heights = polygon @ part.normals.T - part.offsets
    if (heights > 0.0).all(axis=0).any():
        return [polygon]
    cut = []
    for face in np.flatnonzero((heights > 0.0).any(axis=0)):
        height = polygon @ part.normals[face] - part.offsets[face]
        if (height > 0.0).any():
            above, below = _split(polygon, height)
            cut.append(above)
            if len(below) < 3:
                break
            polygon = below
    return cut


def _split(polygon: Array, height: Array) -> tuple[Array, Array]:
    """The pieces of a polygon above and below a plane, given the heights of its corners."""
    above: list[Array] = []
    below: list[Array] = []
    for k, corner in enumerate(polygon):
        following = (k + 1) % len(polygon)
        (above if height[k] > 0.0 else below).append(corner)
        if (height[k] > 0.0) != (height[following] > 0.0):
            share = height[k] / (height[k] - height[following])
            crossing = corner + share * (polygon[following] - corner)
            above.append(crossing)
            below.append(crossing)
    return np.array(above), np.array(below)
