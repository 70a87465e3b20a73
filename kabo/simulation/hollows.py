"""Hollows of a mesh into which others are put: where they are, and convex parts that do not bridge them.

A part for contacts is the hull of what it holds of a mesh, so it fills each hollow inside it. That is no matter in a groove
which nothing enters. A bore, though, has to stay as wide as it is: parts are halved there until none bridges it.
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from kabo.arrays import Array
from kabo.geometry.collision.tight_parts import tight_part
from kabo.meshes import Mesh

WIDTH = 4e-3  # [m]: radius of the balls that enter hollows that count
BRIDGED = 1e-4  # [m] by which a part may bridge such a hollow: half of a narrow fit
SPACING = 1e-3  # [m] between points on surfaces
ROOM = (
    0.05  # share of the ball's radius by which points on surfaces, and polygons in place of circles, may be in it
)
INSIDE = 1e-7  # [m]


def open_points(mesh: Mesh) -> Array:
    """Points (n, 3) just above a mesh where it is hollow, and a ball of radius `WIDTH` touches it from outside [m].

    They are `BRIDGED` above it, so parts that hold one of them bridge the hollow by more.
    """
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    corners = corners[lengths > 0.0]
    points, above = _concave_edges(mesh.faces[lengths > 0.0], mesh.vertices, normals)
    if not len(points):
        return points
    tree = cKDTree(_spread(corners))
    nearest, _ = tree.query(points + WIDTH * above)
    return np.asarray((points + BRIDGED * above)[nearest >= (1.0 - ROOM) * WIDTH])


def _concave_edges(faces: Array, vertices: Array, normals: Array) -> tuple[Array, Array]:
    """Points along edges at which two faces form a hollow, and the ways (n, 3) to 1 m above both faces."""
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
    return begin[edge] + share * (end - begin)[edge], ways[edge]


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


def unbridged(mesh: Mesh, parts: Iterator[Array]) -> Iterator[Array]:
    """The corners (V, 3) of parts which together hold what the given ones do, and bridge no hollow that counts."""
    points = open_points(mesh)
    for part in parts:
        yield from _halved(mesh, part, "", points)


def _halved(mesh: Mesh, part: Array, path: str, points: Array) -> Iterator[Array]:
    held = tight_part(mesh, part, path)
    if not len(held.triangles):
        return
    corners = np.unique(held.triangles.reshape(-1, 3), axis=0)
    try:
        hull = ConvexHull(corners)
    except (QhullError, ValueError):  # it is flat
        return
    depth = -(points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    inside = points[depth > INSIDE]
    if len(inside) and held.can_be_halved(len(path)):
        yield from _halved(mesh, part, path + "0", inside)
        yield from _halved(mesh, part, path + "1", inside)
        return
    yield corners[hull.vertices]
