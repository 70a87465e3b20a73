"""Penetration depth: the shortest translation of one body until both are apart, with proven bounds [K Table 4.1].

The depth of two convex sets is the distance of the origin from the boundary of their Minkowski difference, whose
hull is computed. Neither bound relies on this hull being exact: if the extents along any direction overlap by u, a
translation by u separates them; and if a closed surface of points of the difference winds around the origin at a
distance r, no translation shorter than r does.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.geometry.collision.kernels.separation import rounding
from kabo.geometry.collision.predicates import Bounds, distance
from kabo.geometry.parts import FixedGroup, body_points
from kabo.geometry.triangles.hulls import hull_mesh
from kabo.geometry.triangles.solids import Solid

COORDINATE_DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])


def penetration(first: Array, second: Array) -> Bounds:
    """Proven bounds of the penetration depth of two convex sets [m]; the lower one is 0 if no overlap is proven.

    Args:
        first, second: points (V, 3) and (W, 3) whose convex hulls are the sets, in the same frame.

    Raises:
        ValueError: there are no points, or values are not finite.
    """
    for points in (first, second):
        if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0 or not np.isfinite(points).all():
            raise ValueError(f"a convex set is (V, 3) finite points with V >= 1, not {points.shape}")
    middle = 0.5 * (first.mean(axis=0) + second.mean(axis=0))
    first, second = first - middle, second - middle
    greatest = float(max(np.abs(first).max(), np.abs(second).max(), 1e-3))
    delta = float(rounding(8.0 * greatest)) + 4e-16 * float(np.abs(middle).max())
    differences = (_corners(first)[:, None] - _corners(second)[None]).reshape(-1, 3)
    try:
        corners, faces = hull_mesh(differences)
    except (QhullError, ValueError):  # flat, or fewer than four points: nothing overlaps
        flat = np.linalg.svd(differences - differences.mean(axis=0))[2]
        return Bounds(0.0, _way_out(first, second, np.concatenate([COORDINATE_DIRECTIONS, flat, -flat])) + delta)
    triangles = corners[faces]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0] / lengths[lengths > 0, None]
    solid, origin = Solid(corners, faces), np.zeros((1, 3))
    lower = float(solid.surface_distances(origin)[0]) if abs(solid.winding_number(origin[0])) > 0.5 else 0.0
    return Bounds(
        max(0.0, lower - delta), _way_out(first, second, np.concatenate([COORDINATE_DIRECTIONS, normals])) + delta
    )


def _corners(points: Array) -> Array:
    """The corners of the points' hull; all points if they lie, nearly, in a plane."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        return np.unique(points, axis=0)


def _way_out(first: Array, second: Array, directions: Array) -> float:
    """The least overlap of the extents along the unit directions (D, 3); 0 if there is a gap along one of them."""
    overlaps = (first @ directions.T).max(axis=0) - (second @ directions.T).min(axis=0)
    return max(0.0, float(overlaps.min()))


def signed_distance(first: FixedGroup, second: FixedGroup, within: float = np.inf) -> Bounds:
    """Proven bounds of the signed distance of two bodies [m]: negative where they overlap, by the penetration depth.

    Where parts overlap, the lower bound is minus the penetration depth of the bodies' hulls. The upper bound
    follows from the parts' deviations (`within`: as for `distance`); if both bodies have meshes, it is minus the
    depth of their deepest vertex.

    Raises:
        ValueError: parts or poses are not usable.
    """
    apart = distance(first, second, within)
    if apart.lower > 0.0:
        return apart
    ours, theirs = (_points(body_points(body.enclosure), body.world_T_group) for body in (first, second))
    upper = apart.upper
    if first.mesh is not None and second.mesh is not None:
        upper = min(upper, -_deepest(first, second), -_deepest(second, first))
    return Bounds(-penetration(ours, theirs).upper, upper + 0.0)


def _points(points: Array, pose: Array) -> Array:
    return np.asarray(points @ pose[:9].reshape(3, 3).T + pose[9:])


def _deepest(inner: FixedGroup, outer: FixedGroup) -> float:
    """The depth of the inner mesh's deepest vertex in the outer solid; -inf if none is inside."""
    assert inner.mesh is not None and outer.mesh is not None
    R, t = outer.world_T_group[:9].reshape(3, 3), outer.world_T_group[9:]
    local = (_points(inner.mesh[0], inner.world_T_group) - t) @ R
    solid = Solid(np.asarray(outer.mesh[0], np.float64), np.asarray(outer.mesh[1], np.int64))
    local = local[solid.insides(local)]
    return float(solid.surface_distances(local).max()) if len(local) else -np.inf
