"""Bases that drive: three joints before a robot's first link, and the floor region that its base never leaves.

The base's links, seen from above, are its footprint; the floor region, seen from above, is its floor. The pose of the
base is planar: x and y along the axes of the pose that the scene writes for it, and yaw about the vertical.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array

BASE_VALUES = 3  # of a configuration: x, y, yaw come first
MAX_SAGITTA_SHARE = 0.05  # of epsilon: how much farther a turning footprint is taken to reach than its chords


@dataclass(frozen=True)
class Drive:
    """The floor of a robot's base, and the base's footprint on it.

    The floor is all points (x, y) with normals (E, 2) @ point <= offsets (E,) [m], unit normals, in the frame
    `world_T_floor` (4, 4), in which the base's values are written. `footprint` (V, 2) are the corners of the base's
    outline about its vertical axis at yaw 0 [m]. `joint` is the last of the three in the tree, `links` those that make
    the footprint, or one without a shape. `travel` are the values of the arm on long drives.
    """

    floor: str
    joint: int
    links: tuple[str, ...]
    world_T_floor: Array
    normals: Array
    offsets: Array
    footprint: Array
    travel: tuple[float, ...] | None = None

    @property
    def radius(self) -> float:
        """The greatest distance of the footprint from the vertical axis [m]."""
        return float(np.linalg.norm(self.footprint, axis=1).max())

    def outside(self, poses: Array) -> Array:
        """How far the footprint reaches out of the floor (N,) [m] at base values (N, 3); 0 or less: it is inside."""
        corners = self._corners(poses)
        return np.asarray((corners @ self.normals.T - self.offsets).max(axis=(1, 2)))

    def outside_along(self, start: Array, goal: Array, epsilon: float) -> float:
        """An upper bound of `outside` on the way between base values (3,), too large by `epsilon` / 20 [m] at most.

        A corner leaves the chord between two poses by no more than its distance from the axis times the square of the
        turn, over eight.
        """
        turn = abs(float(goal[2] - start[2]))
        pieces = max(1, int(np.ceil(turn * np.sqrt(self.radius / (8.0 * MAX_SAGITTA_SHARE * epsilon)))))
        shares = np.linspace(0.0, 1.0, pieces + 1)[:, None]
        reached = self.outside((1.0 - shares) * start + shares * goal)
        return float(reached.max()) + 0.125 * self.radius * (turn / pieces) ** 2

    def missing(self, points: Array) -> Array:
        """Lower bounds (N,) [m] of the distance from world points (N, 3) to the nearest place of the base's axis."""
        local = (points - self.world_T_floor[:3, 3]) @ self.world_T_floor[:3, :2]
        return np.asarray(np.maximum(0.0, (local @ self.normals.T - self.offsets).max(axis=1) + self.inset))

    @property
    def inset(self) -> float:
        """How far inside each edge of the floor the axis stays, at whatever turn [m]; negative: it may be outside."""
        return float(min(_supports(self.footprint, self._directions())))

    def box(self) -> tuple[Array, Array]:
        """The least and the greatest x and y (2,) that the base can have, at whatever turn [m].

        A footprint that is larger than the floor leaves no room: then the least is above the greatest.
        """
        corners = polygon_corners(self.normals, self.offsets - self.inset)
        if not len(corners):
            return np.full(2, np.inf), np.full(2, -np.inf)
        return corners.min(axis=0), corners.max(axis=0)

    def _directions(self) -> Array:
        """The unit directions (D, 2) in which the footprint's support may be least."""
        around = np.vstack([self.footprint, self.footprint[:1]])
        edges = np.diff(around, axis=0)
        found = [np.stack([edges[:, 1], -edges[:, 0]], axis=1), -self.footprint]
        every = np.concatenate(found)
        length = np.linalg.norm(every, axis=1)
        chosen = length > 1e-12
        if not chosen.any():  # a point on its axis
            return np.array([[1.0, 0.0]])
        return np.asarray(every[chosen] / length[chosen, None])

    def _corners(self, poses: Array) -> Array:
        """The corners (N, V, 2) of the footprint at base values (N, 3)."""
        c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
        x, y = self.footprint[:, 0], self.footprint[:, 1]
        return np.stack([c * x - s * y + poses[:, :1], s * x + c * y + poses[:, 1:2]], axis=2)


def _supports(points: Array, directions: Array) -> Array:
    return np.asarray((points @ directions.T).max(axis=0))


def hull_of_points(points: Array) -> Array:
    """The corners (V, 2) of the convex hull of points (N, 2), counter-clockwise; one or two corners if it is flat."""
    ordered = sorted(set(map(tuple, np.round(points, 9).tolist())))
    if len(ordered) < 3:
        return np.array(ordered)
    return np.array(_half(ordered) + _half(ordered[::-1]))


def _half(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """One side of a convex hull, without its last point [Andrew 1979]."""
    kept: list[tuple[float, float]] = []
    for p in points:
        while len(kept) > 1:
            (ax, ay), (bx, by) = kept[-2], kept[-1]
            if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0.0:
                break
            kept.pop()
        kept.append(p)
    return kept[:-1]


def edges_of(corners: Array) -> tuple[Array, Array]:
    """Unit normals (E, 2), outwards, and offsets (E,) of the edges of a convex polygon with corners in order."""
    edges = np.diff(np.vstack([corners, corners[:1]]), axis=0)
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1)[:, None]
    return normals, np.asarray((normals * corners).sum(axis=1))


def polygon_corners(normals: Array, offsets: Array) -> Array:
    """The corners (V, 2) of all points with normals (E, 2) @ point <= offsets (E,); empty if there are none.

    A large square, cut off at one edge after the other [Sutherland, Hodgman 1974].
    """
    far = 4.0 * float(np.abs(offsets).max()) + 1.0
    corners = far * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    for normal, offset in zip(normals, offsets, strict=True):
        above = corners @ normal - offset
        following, next_above = np.roll(corners, -1, axis=0), np.roll(above, -1)
        kept = []
        for here, there, a, b in zip(corners, following, above, next_above, strict=True):
            if a <= 0.0:
                kept.append(here)
            if (a < 0.0 < b) or (b < 0.0 < a):
                kept.append(here + a / (a - b) * (there - here))
        corners = np.array(kept).reshape(-1, 2)
    return corners
