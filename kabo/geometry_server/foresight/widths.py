"""Widths of point sets: how far they extend along directions, at the least over all rotations about an axis or at all."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array

TURNS = 1440  # rotations about an axis that are tried: every quarter of a degree
FEW = 32  # rotations that are tried first, for one at which the body fits
REFINEMENTS, CAP = 8, 200  # searches near the best direction, and directions in each
DIRECTIONS = 20_000  # directions that are tried where every rotation is permitted


@dataclass(frozen=True)
class Excess:
    """How far a body exceeds its room, at the rotation where the greatest excess over all directions is least.

    Args:
        width, room: along the direction that exceeds its room most there [m].
        direction: which of the directions that is.
        proven: the excess is above zero at every permitted rotation, not only at those that were tried.
    """

    width: float
    room: float
    direction: int
    proven: bool

    @property
    def metres(self) -> float:
        """The width beyond the room; negative if the body fits at some rotation, as far as this test can tell."""
        return self.width - self.room


def corners(points: Array) -> Array:
    """The corners (W, 3) of the convex hull of points (V, 3); all of them if they are nearly flat."""
    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except (QhullError, ValueError):
        return points


def widths(points: Array, directions: Array) -> Array:
    """The extents (D,) of points (V, 3) along unit directions (D, 3) [m]."""
    along = points @ directions.T
    return np.asarray(along.max(axis=0) - along.min(axis=0))


def excess_about(points: Array, axis: Array, upright: Array, directions: Array, rooms: Array) -> Excess:
    """The excess of a body that may turn about one axis only, over all directions at once.

    Args:
        points: the body's corners (V, 3) in its own frame.
        axis: a unit vector (3,) of the body's frame that is aligned with `upright` (3,) of the world.
        directions: unit directions (D, 3) in the world.
        rooms: the room (D,) along each of them [m].
    """
    standing = points @ turn_onto(axis, upright).T
    found = _widths_turned(standing, upright, directions, 2.0 * np.pi * np.arange(TURNS) / TURNS)
    beyond = found - rooms
    best = int(beyond.max(axis=1).argmin())
    worst = int(beyond[best].argmax())
    # A point at a distance r from the axis moves by at most r times the angle, and a width has two ends.
    radius = float(np.linalg.norm(np.cross(standing - _middle(standing), upright), axis=1).max())
    slack = 2.0 * radius * np.pi / TURNS
    return Excess(float(found[best, worst]), float(rooms[worst]), worst, bool(beyond[best, worst] > slack))


def fits_about(points: Array, axis: Array, upright: Array, directions: Array, rooms: Array) -> bool:
    """Whether such a body fits at one of a few turns: then `excess_about` proves nothing."""
    standing = points @ turn_onto(axis, upright).T
    turns = 2.0 * np.pi * np.arange(FEW) / FEW
    for some in (turns[:1], turns[1:]):  # most bodies fit as they are
        if (_widths_turned(standing, upright, directions, some) <= rooms).all(axis=1).any():
            return True
    return False


def excess_at_any(points: Array, rooms: Array) -> Excess:
    """The excess of a body that may be rotated at will: its least width beyond the least room."""
    spread = directions_on_sphere(DIRECTIONS)
    every = widths(points, spread)
    found, worst = float(every.min()), int(np.argmin(rooms))
    # Every direction is within this angle of one that was tried: the covering radius of the spiral, rounded up.
    angle = 2.5 / np.sqrt(DIRECTIONS)
    diameter = 2.0 * float(np.linalg.norm(points - _middle(points), axis=1).max())
    proven = found - diameter * angle > float(rooms[worst])
    return Excess(_refined(points, spread[int(every.argmin())], angle), float(rooms[worst]), worst, proven)


def _refined(points: Array, direction: Array, angle: float) -> float:
    """The least width of points near a direction, searched on ever smaller caps of directions about it."""
    least = float(widths(points, direction[None])[0])
    for _ in range(REFINEMENTS):
        cap = directions_on_sphere(CAP)[:, :2] * angle
        across = np.linalg.svd(direction[None])[2][1:]
        near = direction + cap @ across
        near /= np.linalg.norm(near, axis=1, keepdims=True)
        found = widths(points, near)
        if float(found.min()) < least:
            least, direction = float(found.min()), near[int(found.argmin())]
        angle *= 0.5
    return least


def directions_on_sphere(count: int) -> Array:
    """Unit directions (count, 3) on a spiral that covers half of the sphere evenly; widths need no other half."""
    number = np.arange(count) + 0.5
    z = number / count
    around = np.pi * (1.0 + np.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(around), flat * np.sin(around), z], axis=1)


def turn_onto(first: Array, second: Array) -> Array:
    """A rotation (3, 3) that takes one unit vector to another."""
    cross, cosine = np.cross(first, second), float(first @ second)
    if cosine < -1.0 + 1e-12:  # half a turn about any axis across
        across = np.cross(first, np.eye(3)[int(np.argmin(np.abs(first)))])
        across /= np.linalg.norm(across)
        return np.asarray(2.0 * np.outer(across, across) - np.eye(3))
    hat = np.array([[0.0, -cross[2], cross[1]], [cross[2], 0.0, -cross[0]], [-cross[1], cross[0], 0.0]])
    return np.asarray(np.eye(3) + hat + hat @ hat / (1.0 + cosine))


def _widths_turned(points: Array, axis: Array, directions: Array, angles: Array) -> Array:
    """The extents (T, D) of points along directions (D, 3), after turns about an axis by angles (T,) [m]."""
    c, s = np.cos(angles)[:, None, None], -np.sin(angles)[:, None, None]  # directions turn back instead
    along = (directions @ axis)[:, None] * axis[None, :]
    turned = c * directions + s * np.cross(axis, directions) + (1.0 - c) * along
    return widths(points, turned.reshape(-1, 3)).reshape(len(angles), len(directions))


def _middle(points: Array) -> Array:
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))
