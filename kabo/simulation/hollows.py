"""Hollows of a mesh into which others are put: where they are, and convex parts that do not bridge them.

A part for contacts is the hull of what it holds of a mesh, so it fills each hollow inside it. That is no matter in a groove
which nothing enters. A bore, though, has to stay as wide as it is: parts are cut in two there, at planes through the edges
at which the mesh is hollow, until none bridges it [Chazelle 1984, notches].
"""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from kabo.arrays import Array, Booleans, Integers
from kabo.geometry.collision.tight_parts import behind, kept_numbers, tight_part
from kabo.meshes import Mesh
from kabo.meshes.mesh import distinct

WIDTH = 4e-3  # [m]: radius of the balls that enter hollows that count
BRIDGED = 1e-4  # [m] by which a part may bridge such a hollow: half of a narrow fit
SPACING = 1e-3  # [m] between points on surfaces
ROOM = (
    0.05  # share of the ball's radius by which points on surfaces, and polygons in place of circles, may be in it
)
ROLLS = 6  # how often a ball that meets the mesh moves away from it
CORNER = 1.415  # radii from the middle of a ball to a right corner into which it rolls
INSIDE = 1e-7  # [m]
LEAST_AREA = 1e-12  # [m²], twice that of triangles that have a normal
TRIED, COUNTED = 3, 400  # hollows whose planes are tried for a cut; points of hollows that are counted meanwhile
WORTH = 1e-3  # share of what is bridged by which a cut makes it less, at least
METHOD_VERSION = 1  # to be incremented when the same parts are cut otherwise
MOST_CUTS, LAST_CUTS = 40, 4  # of a part of a part: all, and those over middles of triangles alone


@dataclass(frozen=True)
class Notches:
    """Points (n, 3) just above a mesh where it is hollow [m], with the planes (n, 3, 4) n·x + d = 0 that part it there.

    These are the planes of both faces, and the one between them; on a face its own, and two across it.
    """

    points: Array
    planes: Array

    def at(self, which: Booleans | Integers) -> "Notches":
        """Some of them."""
        return Notches(self.points[which], self.planes[which])


class Hollows:
    """The hollows of a mesh that a ball of radius `WIDTH` enters from outside.

    Attributes:
        notches: along the edges at which it is hollow. Points are `BRIDGED` above the mesh, so that parts which hold one of
            them bridge the hollow by more.
    """

    def __init__(self, mesh: Mesh) -> None:
        corners = mesh.vertices[mesh.faces]
        normals, lengths = _normals(corners)
        fine = lengths > 0.0
        self._surface = cKDTree(_spread(corners[fine]))
        self.notches = self._open(*_concave_edges(mesh.faces[fine], mesh.vertices, normals[fine]))

    def _open(self, points: Array, above: Array, planes: Array, rolls: int = 0) -> Notches:
        """Points on the mesh, above which a ball fits, moved to `BRIDGED` above it.

        A ball that rolls moves away from what it meets: into a right corner it does not reach, and the corner counts.
        """
        if not len(points):
            return Notches(points, planes)
        middles = points + WIDTH * above
        nearest, which = self._surface.query(middles)
        met = np.flatnonzero((nearest < WIDTH) & (nearest > 0.0))
        for _ in range(rolls):  # the others stay where they are
            away = (middles[met] - self._surface.data[which[met]]) / nearest[met, None]
            middles[met] += (WIDTH - nearest[met])[:, None] * away
            nearest[met], which[met] = self._surface.query(middles[met])
            met = met[(nearest[met] < WIDTH) & (nearest[met] > 0.0)]
        ways = np.maximum(np.linalg.norm(above, axis=1), CORNER) * WIDTH * (1.0 + ROOM)
        near = np.linalg.norm(middles - points, axis=1) <= ways
        return Notches(points + BRIDGED * above, planes).at(near & (nearest >= (1.0 - ROOM) * WIDTH))

    def over(self, triangles: Array, equations: Array) -> Notches:
        """Those hollows over the middles of triangles (T, 3, 3) that a convex part fills.

        A part may reach over the corner of a hollow which it does not hold.
        """
        normals, lengths = _normals(triangles)
        middles = triangles.mean(axis=1)
        filled = (lengths > 0.0) & (_depths(middles + BRIDGED * normals, equations) > INSIDE)
        middles, normals = middles[filled], normals[filled]
        along = triangles[filled, 1] - triangles[filled, 0]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), INSIDE)
        sides = np.stack([normals, along, np.cross(normals, along)], axis=1)
        planes = np.concatenate([sides, -np.einsum("tkj,tj->tk", sides, middles)[:, :, None]], axis=2)
        return self._open(middles, normals, planes, ROLLS)


def _normals(corners: Array) -> tuple[Array, Array]:
    """The unit normals (T, 3) of triangles (T, 3, 3), and twice their areas (T,); 0 where they are degenerate."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    lengths = np.where(lengths > LEAST_AREA, lengths, 0.0)
    return normals / np.where(lengths > 0.0, lengths, 1.0)[:, None], lengths


def _concave_edges(faces: Integers, vertices: Array, normals: Array) -> tuple[Array, Array, Array]:
    """Points along edges where two faces form a hollow, the ways (n, 3) to 1 m above both, and planes (n, 3, 4)."""
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    opposite = np.concatenate([faces[:, 2], faces[:, 0], faces[:, 1]])
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    ends, owner, opposite = ends[order], owner[order], opposite[order]
    same = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    first, second = owner[same], owner[same + 1]
    middle = vertices[ends[same]].mean(axis=1)
    # The other face's far corner is above the plane of the first one: a hollow.
    above = np.einsum("ij,ij->i", normals[first], vertices[opposite[same + 1]] - middle) > INSIDE
    out = normals[first] + normals[second]
    size = np.linalg.norm(out, axis=1)
    fine = above & (size > 0.1)
    begin, end = vertices[ends[same][fine]].transpose(1, 0, 2)
    counts = np.ceil(np.linalg.norm(end - begin, axis=1) / SPACING).astype(int) + 1
    edge = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / np.repeat(counts - 1, counts)
    share = np.clip(share, INSIDE, 1.0 - INSIDE)[:, None]
    ways = 2.0 * out[fine] / size[fine, None] ** 2  # the sharper the edge, the longer
    between = np.cross(end - begin, out[fine])
    between /= np.linalg.norm(between, axis=1, keepdims=True)
    sides = np.stack([normals[first[fine]], normals[second[fine]], between], axis=1)
    planes = np.concatenate([sides, -np.einsum("nkj,nj->nk", sides, begin)[:, :, None]], axis=2)
    return begin[edge] + share * (end - begin)[edge], ways[edge], planes[edge]


def _spread(corners: Array) -> Array:
    """Points (n, 3) on triangles (T, 3, 3), at most about `SPACING` apart."""
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    counts = np.minimum(np.ceil(longest / SPACING).astype(int), 64)
    found = [corners.mean(axis=1)]
    for count in np.unique(counts):
        own = corners[counts == count]
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
        keep = i + j <= count
        a, b = i[keep] / count, j[keep] / count
        weights = np.stack([1.0 - a - b, a, b], axis=1)
        found.append(np.einsum("wk,tkx->twx", weights, own).reshape(-1, 3))
    return np.concatenate(found)


def unbridged(mesh: Mesh, parts: Sequence[Array]) -> list[Array]:
    """The corners (V, 3) of parts which together hold what the given ones (V, 3) do, and bridge no hollow that counts.

    They are kept in the cache folder, as it may take half a minute to find them.
    """
    given = hashlib.sha256(b"".join(np.ascontiguousarray(part).tobytes() + b"|" for part in parts)).hexdigest()

    def numbers() -> Array:
        found = _unbridged(mesh, parts)
        return np.concatenate([[len(found)], [len(each) for each in found], *map(np.ravel, found)])

    found = kept_numbers(("unbridged", METHOD_VERSION, mesh.digest, given), numbers)
    first = 1 + int(found[0])
    ends = np.cumsum(found[1:first].astype(int))
    return np.split(found[first:].reshape(-1, 3), ends[:-1]) if len(ends) else []


def _unbridged(mesh: Mesh, parts: Iterable[Array]) -> list[Array]:
    """As above: a part that bridges is cut in two at a plane through one of the hollows, after which least is bridged."""
    found: list[Array] = []
    hollows = Hollows(mesh)
    waiting = [(tight_part(mesh, part).triangles, hollows.notches, MOST_CUTS) for part in parts]
    while waiting:
        triangles, own, left = waiting.pop()
        part = _hull(triangles)
        if part is None:
            continue
        corners, equations = part
        own = own.at(_depths(own.points, equations) > INSIDE)
        bridged = own
        if not len(own.points):
            bridged, left = hollows.over(triangles, equations), min(left, LAST_CUTS)
        halves = None if left == 0 or not len(bridged.points) else _cut(triangles, bridged, equations)
        if halves is None:
            found.append(corners)
        else:
            waiting += [(half, own, left - 1) for half in halves]
    return found


def _hull(triangles: Array) -> tuple[Array, Array] | None:
    """The corners and the equations (F, 4) of the hull of triangles (T, 3, 3); None if they are flat."""
    points, _ = distinct(triangles.reshape(-1, 3))
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    return points[hull.vertices], np.round(hull.equations, 9)


def _depths(points: Array, equations: Array) -> Array:
    """How deep points (n, 3) are in a convex part [m]; below 0 outside."""
    return np.asarray(-(points @ equations[:, :3].T + equations[:, 3]).max(axis=1, initial=-np.inf))


def _cut(triangles: Array, own: Notches, equations: Array) -> tuple[Array, Array] | None:
    """The halves of a part at the plane after which least is bridged; None if none makes it less."""
    some = own.at(np.unique(np.linspace(0, len(own.points) - 1, COUNTED).astype(int))).points
    deep = _depths(some, equations)
    least, best = (1.0 - WORTH) * float(deep.sum()), None
    deepest = int(np.argmax(_depths(own.points, equations)))
    chosen = np.unique([*np.linspace(0, len(own.points) - 1, TRIED).astype(int), deepest])
    for plane in np.unique(np.round(own.planes[chosen].reshape(-1, 4), 7), axis=0):
        halves, left = [], 0.0
        for side in (plane, -plane):
            half = behind(triangles, side)
            part = _hull(half) if len(half) and left < least else None
            left += np.inf if part is None else float(np.maximum(_depths(some, part[1]), 0.0).sum())
            halves.append(half)
        if left < least:
            least, best = left, (halves[0], halves[1])
    return best
