"""Whether a closed mesh is convex, exactly or nearly."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.kernels.solids import winding_number

PLANE_TOLERANCE = 1e-9  # [m] of rounding in the planes of a convex mesh
MAX_CONVEXITY_WORK = 20_000_000  # faces times vertices: above, convexity is not tested
MIN_HULL_SHARE = 0.9  # of the hull's volume that a nearly convex mesh encloses
HEIGHT_ROUNDING = 1e-13  # of a mesh's size: of heights above planes
NUMBERS_AT_ONCE = 1_000_000  # of heights, in one array


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


def convexity_error(vertices: Array, faces: Integers) -> float:
    """A proven bound [m] of how far points of a closed mesh's convex hull may be from its solid; inf if none is known.

    Let every face lie within s of one of the hull's planes. Then no face meets the interior of K, which lies behind
    all these planes moved inwards by s; all of K is in the solid if the mesh winds around one point of K. With a
    centre of K at a depth of R below the hull's planes, K holds the hull scaled about this centre by 1 - s / R. So no
    point of the hull is farther from K than s / R times its distance from the centre.

    Args:
        vertices: (V, 3) [m]. faces: (F, 3), of which none may be missing: nothing here tests that the mesh is closed.
    """
    used, index = np.unique(faces, return_inverse=True)
    points, triangles = vertices[used], index.reshape(-1, 3)
    try:
        hull = ConvexHull(points)
    except QhullError:
        return np.inf
    corners = np.ascontiguousarray(points[triangles])
    volume = float(np.linalg.det(corners - points[0]).sum()) / 6.0
    normals = np.unique(np.round(hull.equations[:, :3], 12), axis=0)
    if abs(volume) < MIN_HULL_SHARE * hull.volume or len(normals) * len(faces) > MAX_CONVEXITY_WORK:
        return np.inf
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = (points @ normals.T).max(axis=0)
    centre = _centroid(points[hull.simplices], points.mean(axis=0))
    depth = float((offsets - normals @ centre).min())
    reach = float(np.linalg.norm(points - centre, axis=1).max())
    shift = _farthest_face(points, triangles, normals, offsets) + HEIGHT_ROUNDING * reach
    if not shift < 0.5 * depth or not abs(winding_number(corners, *centre.tolist())) > 0.5:
        return np.inf
    return shift / depth * reach


def _centroid(triangles: Array, inner: Array) -> Array:
    """The centroid of the pyramids over triangles (F, 3, 3) with a common apex."""
    volumes = np.abs(np.linalg.det(triangles - inner))
    centre: Array = inner + 0.25 * volumes @ (triangles - inner).sum(axis=1) / volumes.sum()
    return centre


def _farthest_face(points: Array, triangles: Integers, normals: Array, offsets: Array) -> float:
    """The greatest depth of a face (F, 3) behind that plane n·x = d, of (H, 3) and (H,), which it is nearest to."""
    nearest = np.full(len(triangles), np.inf)
    step = max(1, NUMBERS_AT_ONCE // max(len(triangles), len(points)))
    for first in range(0, len(normals), step):
        some = slice(first, first + step)
        depths = offsets[some] - points @ normals[some].T
        nearest = np.minimum(nearest, depths[triangles].max(axis=1).min(axis=1))
    return float(nearest.max())
