"""Sight lines from a point to a body, as convex parts: the hulls of the point and each of the body's parts.

A part is convex, so the hull of the point and the part is the union of the straight lines from the point to all points
of the part. None of these lines is farther from a line to the body itself than the part deviates from the body: hence
predicates on these hulls err as those on the body's parts do. Round parts are replaced by polyhedra around them.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.geometry.parts import COLUMNS, Enclosure, FixedGroup
from kabo.meshes import Rounding

LEVELS = 4  # of icospheres around a ball, with 12, 42, 162, 642 and 2562 corners
SIDES = (16, 32, 64, 128)  # of polygons around a disc
MAX_CUTS = 12  # of a polyhedron with many corners, each into two


def sight_lines(apex: Array, body: FixedGroup, *, share: float = 1.0) -> Enclosure:
    """Parts, in the world's frame, that enclose all sight lines from a point (3,) to the points of a body.

    Args:
        apex: the point [m].
        body: a body with sharp parts of less than 64 corners, as `sharp` gives them.
        share: the part of each line that counts, from the point on; 1 is all of it.
    """
    turn, shift = body.world_T_group[:9].reshape(3, 3), body.world_T_group[9:]
    parts = (apex + share * (part @ turn.T + shift - apex) for part in body.enclosure.parts)
    return Enclosure(tuple(np.vstack([apex, part]) for part in parts), body.enclosure.deviation)


def sharp(enclosure: Enclosure, tolerance: float) -> Enclosure:
    """An enclosure of the same body by hulls of less than 64 corners each, without rounding and without a tree.

    Its parts are the leaves of the tree, refined until each deviates by no more than `tolerance` [m]. Round parts are
    enclosed by polyhedra, which deviate by no more than the rest of the tolerance, as far as there is one.
    """
    parts, deviation = [], 0.0
    for corners, rounding, own in _leaves(enclosure, tolerance):
        points, added = _around(corners, rounding, tolerance - own)
        parts += pieces(points)
        deviation = max(deviation, own + added)
    return Enclosure(tuple(parts), deviation)


def _leaves(enclosure: Enclosure, tolerance: float) -> Iterator[tuple[Array, Rounding, float]]:
    """The corners, rounding and deviation of each part without children; parts that deviate by more are refined."""
    waiting = list(enclosure.root_parts)
    for part in waiting:  # grows while it is read
        if not enclosure.children_of(part) and enclosure.finer and enclosure.deviation_of(part) > tolerance:
            enclosure = enclosure.finer(part)
        children = enclosure.children_of(part)
        waiting += children
        if not children:
            yield enclosure.parts[part], enclosure.rounding_of(part), enclosure.deviation_of(part)


def _around(corners: Array, rounding: Rounding, tolerance: float) -> tuple[Array, float]:
    """Points (N, 3) whose hull encloses a round part, and by how much at most it is larger [m]."""
    points, added = corners, 0.0
    for size, around in ((rounding.disc, _polygon(rounding, tolerance)), (rounding.radius, None)):
        if size > 0.0:
            shape = _ball(rounding.radius, tolerance - added) if around is None else around
            points = _extreme((points[:, None] + shape[None]).reshape(-1, 3))
            added += float(np.linalg.norm(shape, axis=1).max()) - size
    return points, added


def _polygon(rounding: Rounding, tolerance: float) -> Array:
    """The corners (N, 3) of a polygon around a disc, across its axis."""
    share = next((n for n in SIDES if rounding.disc * (1 / np.cos(np.pi / n) - 1) <= tolerance / 2), SIDES[-1])
    angles = 2 * np.pi * np.arange(share) / share
    axis = np.array(rounding.axis)
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    radius = rounding.disc / np.cos(np.pi / share) * (1 + 1e-12)
    second = np.cross(axis, first)
    return np.asarray(radius * (np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second))


def _ball(radius: float, tolerance: float) -> Array:
    """The corners (N, 3) of an icosphere around a ball."""
    around = [_icosphere(level) for level in range(LEVELS + 1)]
    return radius * next((p for p in around if radius * (np.linalg.norm(p[0]) - 1) <= tolerance), around[-1])


@lru_cache(maxsize=LEVELS + 1)
def _icosphere(level: int) -> Array:
    """The corners of an icosphere around the unit ball."""
    import trimesh

    points = np.asarray(trimesh.creation.icosphere(subdivisions=level).vertices, np.float64)
    inner = -ConvexHull(points).equations[:, 3].max()  # the distance of its nearest face
    return np.asarray(points / inner * (1 + 1e-9))


def pieces(points: Array) -> list[Array]:
    """Convex sets of less than 64 points each, whose hulls together are the hull of the points (N, 3)."""
    waiting, found = [(_extreme(points), 0)], []
    for corners, cuts in waiting:  # grows while it is read
        if len(corners) < COLUMNS or cuts == MAX_CUTS:
            found.append(np.ascontiguousarray(corners))
        else:
            waiting += [(_extreme(half), cuts + 1) for half in _halves(corners)]
    return found


def _halves(corners: Array) -> tuple[Array, Array]:
    """The corners of both halves of a hull, cut across its longest axis."""
    middle = corners.mean(axis=0)
    _, axes = np.linalg.eigh((corners - middle).T @ (corners - middle))
    height = (corners - middle) @ axes[:, -1]
    above, below = corners[height >= 0.0], corners[height < 0.0]
    high, low = height[height >= 0.0], height[height < 0.0]
    share = high[:, None] / (high[:, None] - low[None])
    cut = (above[:, None] + share[:, :, None] * (below[None] - above[:, None])).reshape(-1, 3)
    return np.vstack([above, cut]), np.vstack([below, cut])


def _extreme(points: Array) -> Array:
    """The corners of the hull of points (N, 3); all of them if the hull is flat."""
    try:
        return points[ConvexHull(points).vertices] if len(points) > 4 else points
    except QhullError:
        return np.unique(points, axis=0)
