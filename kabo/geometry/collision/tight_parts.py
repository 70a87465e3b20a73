"""Convex parts tight around what they hold of a mesh, and their halves, without end: each lies in the part that it is of.

A part sticks out of its body by up to some millimetres: it has few corners, and bridges hollows. What it has to hold are
the triangles inside it, as long as the parts around it hold theirs. So it may be cut anywhere outside of the hull of these,
and replaced by two parts that hold a half of them each. These depend on mesh and part alone, so they can be kept.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import count, product
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.compilation import cache_folder, keep_below
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
HASH_BYTES = 32  # of a file's content, at its beginning
CACHE_BYTES = 64 * 1024**2  # of parts in memory
FILE_BYTES = 256 * 1024**2  # of files in the cache folder
LOOKED_AFTER = 64  # files that a process writes, from the first on, until it looks again how many bytes there are
_AXES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [0, 1, -1], [1, 0, 1], [1, 0, -1], [1, 1, 0], [1, -1, 0]]
)
_DIRECTIONS = _AXES / np.linalg.norm(_AXES, axis=1)[:, None]
_FRAMES = np.array(
    [[0, 1, 2], [0, 3, 4], [1, 5, 6], [2, 7, 8]]
)  # axes of boxes: straight, or turned about one of them

METHOD_VERSION = 1  # part of the names of files; to be incremented when the same part is drawn otherwise


@dataclass(frozen=True, eq=False)
class TightPart:
    """A convex part, and what it has to hold."""

    corners: Array  # (V <= 64, 3) [m]
    triangles: Array  # (T, 3, 3) [m]

    @property
    def nbytes(self) -> int:
        """Its size [bytes]."""
        return self.corners.nbytes + self.triangles.nbytes

    def can_be_halved(self, depth: int) -> bool:
        """Whether its halves are worth having."""
        return depth < MAX_DEPTH and len(self.triangles) > 1 and self._size > LEAST_SIZE

    @cached_property
    def _size(self) -> float:
        """The longest side of the box around it [m]."""
        return float(np.ptp(self.corners, axis=0).max())

    @cached_property
    def planes(self) -> Array | None:
        """The planes (F, 4) n·x + d <= 0 of its faces; None if it is flat."""
        return _hull_of(self.corners)

    @cached_property
    def best_plane(self) -> Array:
        """The plane (4,) across an axis of the frame whose two halves have the least boxes around them."""
        low, high = self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))
        planes = np.zeros((3 * len(SHARES), 4))
        for row, (axis, share) in enumerate(product(range(3), SHARES)):
            planes[row, axis], planes[row, 3] = 1.0, -(low[axis] + share * (high[axis] - low[axis]))
        volumes = np.array(
            [sum(_volume(behind(self.triangles, s * plane)) for s in (1.0, -1.0)) for plane in planes]
        )
        lengths = np.repeat(high - low, len(SHARES))
        volumes[lengths < LEAST_SHARE * lengths.max()] = np.inf
        return np.asarray(planes[int(np.argmin(np.round(volumes / (np.prod(high - low) + 1e-30), 6)))])


_WRITTEN = count()  # files of this process
_MADE: ContentCache[TightPart] = ContentCache(CACHE_BYTES, lambda part: part.nbytes)


def tight_part(mesh: Mesh, part: Array, path: str = "") -> TightPart:
    """A part (V, 3) [m] of a mesh drawn tight, or the half of a half of it that a path of 0 and 1 leads to.

    It is kept in memory and in the cache folder.
    """
    key = mesh.digest, hashlib.sha256(part.tobytes()).hexdigest(), path
    return _MADE.get_or_make(key, lambda: kept_or_made(key, lambda: _made(mesh, part, path)))


def kept_or_made(key: tuple[str, str, str], make: Callable[[], TightPart]) -> TightPart:
    """The part in the file of the cache folder that belongs to a key, or a new one, which is then kept there."""

    def numbers() -> Array:
        made = make()
        return np.concatenate([[float(len(made.corners))], made.corners.ravel(), made.triangles.ravel()])

    found = kept_numbers((METHOD_VERSION, *key), numbers)
    end = 1 + 3 * int(found[0])
    return TightPart(found[1:end].reshape(-1, 3), found[end:].reshape(-1, 3, 3))


def kept_numbers(key: tuple[object, ...], make: Callable[[], Array]) -> Array:
    """The numbers (n,) in the file of the cache folder that belongs to a key, or new ones, which are then kept there.

    A file that is damaged, or cut off, is made anew: its first bytes are the hash of the others.
    """
    name = hashlib.sha256(repr(key).encode()).hexdigest()[:40]
    path = cache_folder() / "tight" / f"{name}.tight"
    with suppress(OSError, ValueError):
        found = path.read_bytes()
        _note_use(path)
        if found[:HASH_BYTES] == hashlib.sha256(found[HASH_BYTES:]).digest():
            return np.frombuffer(found, "<f8", offset=HASH_BYTES).astype(np.float64)
    made = make()
    body = made.astype("<f8").tobytes()
    with suppress(OSError):  # a read-only cache costs time, never an answer
        _write(path, hashlib.sha256(body).digest() + body)
        if next(_WRITTEN) % LOOKED_AFTER == 0:
            keep_below(path.parent, FILE_BYTES)
    return made


def _note_use(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)  # files that were used least recently are removed first


def _write(path: Path, content: bytes) -> None:
    """Writes a file so that others see all of it or nothing."""
    path.parent.mkdir(mode=0o700, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(name).replace(path)
    finally:
        Path(name).unlink(missing_ok=True)


def _made(mesh: Mesh, part: Array, path: str) -> TightPart:
    if not path:
        start = TightPart(part, np.empty((0, 3, 3)))
        return _drawn_tight(start, _held(mesh, start), None)
    whole = tight_part(mesh, part, path[:-1])
    plane = whole.best_plane * (1.0 if path[-1] == "0" else -1.0)
    return _drawn_tight(whole, behind(whole.triangles, plane), plane)


def _volume(triangles: Array) -> float:
    """A bound of the volume of triangles (T, 3, 3) [m3]: the least box around them in some frames."""
    if not len(triangles):
        return 0.0
    heights = triangles.reshape(-1, 3) @ _DIRECTIONS.T
    widths = heights.max(axis=0) - heights.min(axis=0)
    return float(widths[_FRAMES].prod(axis=1).min())


def _held(mesh: Mesh, part: TightPart) -> Array:
    """What is inside a part of a mesh's triangles (T, 3, 3); of a flat part nothing, for it covers nothing."""
    if part.planes is None:
        return part.triangles
    room = np.empty((len(mesh.faces), 3, 3))
    box = np.concatenate([part.corners.min(axis=0) - SLACK, part.corners.max(axis=0) + SLACK])
    vertices, faces = np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, np.int64)
    found = np.asarray(room[: int(triangles_at(vertices, faces, box, room))].copy())
    for plane in part.planes:
        found = behind(found, plane)
    return found


def behind(triangles: Array, plane: Array) -> Array:
    """What of triangles (T, 3, 3) is where n·x + d <= 0, or a little beyond."""
    room = np.empty((2 * len(triangles), 3, 3))
    count = int(halve(triangles, plane, SLACK, np.empty((2, 4, 3)), room))
    return np.asarray(room[:count].copy())


def _drawn_tight(start: TightPart, triangles: Array, plane: Array | None) -> TightPart:
    """The part of a polytope that holds triangles inside it, cut at a plane first; the polytope if it is flat."""
    planes, count = start.planes, len(start.corners)
    if planes is None or not len(triangles):
        return TightPart(start.corners, triangles[:0])
    points = np.ascontiguousarray(np.unique(triangles.reshape(-1, 3), axis=0).T)
    corners, marks = np.zeros((MOST_CORNERS, 3)), np.zeros((MOST_CORNERS, WORDS), np.int64)
    excess = np.zeros((MOST_CORNERS, 5))
    corners[:count] = start.corners
    on = np.abs(start.corners @ planes[:, :3].T + planes[:, 3]) < 1e-9
    for bit in range(len(planes)):
        marks[:count, bit // BITS] |= on[:, bit].astype(np.int64) << (bit % BITS)
    room = Room(np.zeros(MOST_CORNERS), np.zeros((MOST_CORNERS, 3)), np.zeros((MOST_CORNERS, WORDS), np.int64))
    bit = len(planes)
    if plane is not None:
        beyond = np.array([*plane[:3], SLACK - plane[3]])
        count, bit = max(cut(corners, marks, excess, count, beyond, bit, room), 0) or count, bit + 1
    limits = np.array([STICKS_OUT, SLACK])
    count = tighten(points, corners, marks, excess, count, bit, limits, np.zeros(4), room, np.zeros((4, 3)))
    made = TightPart(corners[:count].copy(), triangles)
    if made.planes is None or (made.planes[:, :3] @ points + made.planes[:, 3:]).max() > 2.0 * SLACK:
        return TightPart(start.corners, triangles)
    return made


def _hull_of(points: Array) -> Array | None:
    """The planes (F, 4) n·x + d <= 0 of the hull of points; None if they are flat."""
    try:
        found = ConvexHull(points).equations
    except (QhullError, ValueError):
        return None
    return np.ascontiguousarray(found[np.sort(np.unique(np.round(found, 9), axis=0, return_index=True)[1])])
