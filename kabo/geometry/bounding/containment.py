"""Polytopes that contain points with a margin above rounding; lengths are those of shapes, whose diagonal is 1."""

from contextlib import suppress

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array

# By which every face moves outwards at least: far more than all rounding, that of a shape's coordinates included.
FACE_WIDENING = 3e-9
CONTAINMENT_MARGIN = 1.5e-9  # by which every point must then lie inside


def hull_of(points: Array) -> ConvexHull:
    """The convex hull of points (P, 3).

    Raises:
        QhullError: the points lie in a plane.
    """
    # Of narrow sets Qhull may begin with four points in a plane, unless it searches all. Where corners are hardly apart
    # it may merge faces to one that is too wide, unless it merges exactly coplanar ones first.
    for options in (None, "Qt Qs"):
        with suppress(QhullError):
            return ConvexHull(points, qhull_options=options)
    return ConvexHull(points, qhull_options="Qt Qx")


def hull_planes(points: Array) -> Array:
    """The distinct half-spaces (H, 4) of the convex hull of points (P, 3): n·x <= d with |n| = 1."""
    equations = hull_of(points).equations
    return np.unique(np.round(np.column_stack([equations[:, :3], -equations[:, 3]]), 12), axis=0)


def solid_points(points: Array, thickness: float) -> Array:
    """The corners of the points' hull; of a flat set and of a needle those of a box around it, or of its thick hull."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) / np.sqrt(len(points))
    if len(points) >= 4 and spread[2] >= thickness:
        with suppress(QhullError):  # its points are too near a plane
            return _corners(points)
    shifts = thickness * np.vstack([np.eye(3), -np.eye(3)])
    with suppress(QhullError):
        return _corners((points[:, None] + shifts[None]).reshape(-1, 3))
    return _box_around(points, thickness)


def _corners(points: Array) -> Array:
    corners: Array = points[np.sort(hull_of(points).vertices)]
    return corners


def _box_around(points: Array, thickness: float) -> Array:
    """The corners (8, 3) of a box along the points' own axes, with some space on all sides."""
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle)[2]
    low, high = ((points - middle) @ axes.T).min(axis=0) - thickness, ((points - middle) @ axes.T).max(axis=0)
    ends = np.array([low, high + thickness])
    corners = np.array([(ends[i, 0], ends[j, 1], ends[k, 2]) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return np.asarray(corners @ axes + middle)


def widened(vertices: Array) -> Array:
    """The vertices, moved away from their mean until every face has moved outwards by `FACE_WIDENING`."""
    middle = vertices.mean(axis=0)
    equations = hull_of(vertices).equations
    inner = float(-(equations[:, :3] @ middle + equations[:, 3]).max())
    wider: Array = middle + (vertices - middle) * (1.0 + FACE_WIDENING / inner)
    return wider


def contains_proven(vertices: Array, points: Array) -> bool:
    """Whether the hull of the vertices contains all points with a margin above rounding."""
    try:
        equations = hull_of(vertices).equations
    except QhullError:
        return False
    return bool((points @ equations[:, :3].T + equations[:, 3] <= -CONTAINMENT_MARGIN).all())
