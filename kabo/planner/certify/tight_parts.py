"""Convex parts tight around what they hold of a mesh, and their halves, without end: each lies in the part that it is of.

A part sticks out of its body by up to some millimetres: it has few corners, and bridges hollows. What it has to hold are
the triangles inside it, as long as the parts around it hold theirs. So it may be cut anywhere outside of the hull of these,
and replaced by two parts that hold a half of them each. These depend on mesh and part alone, so they can be kept.
"""

import hashlib
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.content_cache import ContentCache
from kabo.geometry.collision.kernels.tight_parts import BITS, MOST_CORNERS, WORDS, Room, cut, halve, tighten
from kabo.geometry.triangles.kernels.clipping import triangles_at
from kabo.scene import Mesh

SLACK = 1e-7  # [m] by which a cut stays away from the mesh: far more than verifiers move faces inwards
STICKS_OUT = 5e-5  # [m]: corners that stick out less are not cut off
SHARES = (0.3, 0.5, 0.7)  # of an axis, at which a part is halved
LEAST_SHARE = 0.2  # of the longest side of a box: it is not halved across shorter ones
MAX_DEPTH = 14  # of halves of halves
LEAST_SIZE = 1e-3  # [m] of what is halved
CACHE_BYTES = 64 * 1024**2


class TightPart(NamedTuple):
    """A convex part, and what it has to hold."""

    corners: Array  # (V <= 64, 3) [m]
    triangles: Array  # (T, 3, 3) [m]

    @property
    def nbytes(self) -> int:
        """Its size [bytes]."""
        return self.corners.nbytes + self.triangles.nbytes

    def can_be_halved(self, depth: int) -> bool:
        """Whether its halves are worth having."""
        return (
            depth < MAX_DEPTH
            and len(self.triangles) > 1
            and float(np.ptp(self.corners, axis=0).max()) > LEAST_SIZE
        )


_MADE: ContentCache[TightPart] = ContentCache(CACHE_BYTES, lambda part: part.nbytes)


def tight_part(mesh: Mesh, part: Array, path: str = "") -> TightPart:
    """A part (V, 3) [m] of a mesh drawn tight, or the half of a half of it that a path of 0 and 1 leads to."""
    key = mesh.digest, hashlib.sha256(part.tobytes()).digest(), path
    return _MADE.get_or_make(key, lambda: _made(mesh, part, path))


def _made(mesh: Mesh, part: Array, path: str) -> TightPart:
    if not path:
        return _drawn_tight(part, _held(mesh, part), None)
    whole = tight_part(mesh, part, path[:-1])
    plane = _best_plane(whole) * (1.0 if path[-1] == "0" else -1.0)
    return _drawn_tight(whole.corners, _behind(whole.triangles, plane), plane)


def _best_plane(whole: TightPart) -> Array:
    """The plane (4,) across an axis of the frame whose two halves have the least volume."""
    low, high = whole.triangles.min(axis=(0, 1)), whole.triangles.max(axis=(0, 1))
    planes = []
    for axis in range(3):
        for share in SHARES:
            plane = np.zeros(4)
            plane[axis], plane[3] = 1.0, -float(low[axis] + share * (high[axis] - low[axis]))
            planes.append(plane)
    halves = [(_behind(whole.triangles, plane), _behind(whole.triangles, -plane)) for plane in planes]
    lengths = np.repeat(high - low, len(SHARES))
    volumes = np.array([sum(_volume(half) for half in both) for both in halves])
    volumes[lengths < LEAST_SHARE * lengths.max()] = np.inf
    return planes[int(np.argmin(np.round(volumes / (np.prod(high - low) + 1e-30), 6)))]


def _volume(triangles: Array) -> float:
    """The volume of the hull of triangles (T, 3, 3) [m3]."""
    try:
        return float(ConvexHull(triangles.reshape(-1, 3)).volume)
    except (QhullError, ValueError):
        return 0.0


def _held(mesh: Mesh, part: Array) -> Array:
    """What is inside a part of a mesh's triangles (T, 3, 3); of a flat part nothing, for it covers nothing."""
    hull = _hull_of(part)
    if hull is None:
        return np.empty((0, 3, 3))
    room = np.empty((len(mesh.faces), 3, 3))
    box = np.concatenate([part.min(axis=0) - SLACK, part.max(axis=0) + SLACK])
    vertices, faces = np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, np.int64)
    found = np.asarray(room[: int(triangles_at(vertices, faces, box, room))].copy())
    for plane in hull:
        found = _behind(found, plane)
    return found


def _behind(triangles: Array, plane: Array) -> Array:
    """What of triangles (T, 3, 3) is where n·x + d <= 0, or a little beyond."""
    room = np.empty((2 * len(triangles), 3, 3))
    count = int(halve(triangles, plane, SLACK, np.empty((2, 4, 3)), room))
    return np.asarray(room[:count].copy())


def _drawn_tight(start: Array, triangles: Array, plane: Array | None) -> TightPart:
    """The part of a polytope that holds triangles inside it, cut at a plane first; the polytope if it is flat."""
    planes = _hull_of(start)
    if planes is None or not len(triangles):
        return TightPart(start, triangles[:0])
    points = np.ascontiguousarray(np.unique(triangles.reshape(-1, 3), axis=0).T)
    corners, marks = np.zeros((MOST_CORNERS, 3)), np.zeros((MOST_CORNERS, WORDS), np.int64)
    excess = np.zeros((MOST_CORNERS, 5))
    corners[: len(start)] = start
    on = np.abs(start @ planes[:, :3].T + planes[:, 3]) < 1e-9
    for bit in range(len(planes)):
        marks[: len(start), bit // BITS] |= on[:, bit].astype(np.int64) << (bit % BITS)
    room = Room(np.zeros(MOST_CORNERS), np.zeros((MOST_CORNERS, 3)), np.zeros((MOST_CORNERS, WORDS), np.int64))
    count, bit = len(start), len(planes)
    if plane is not None:
        beyond = np.array([*plane[:3], SLACK - plane[3]])
        count, bit = max(cut(corners, marks, excess, count, beyond, bit, room), 0) or count, bit + 1
    limits = np.array([STICKS_OUT, SLACK])
    count = tighten(points, corners, marks, excess, count, bit, limits, np.zeros(4), room, np.zeros((4, 3)))
    made = corners[:count].copy()
    hull = _hull_of(made)
    if hull is None or (hull[:, :3] @ points + hull[:, 3:]).max() > 2.0 * SLACK:
        return TightPart(start, triangles)
    return TightPart(made, triangles)


def _hull_of(points: Array) -> Array | None:
    """The planes (F, 4) n·x + d <= 0 of the hull of points; None if they are flat."""
    try:
        found = ConvexHull(points).equations
    except (QhullError, ValueError):
        return None
    return np.ascontiguousarray(found[np.sort(np.unique(np.round(found, 9), axis=0, return_index=True)[1])])
