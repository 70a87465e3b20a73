"""A solid cut into cells whose hulls stay near it, by lines of sight.

Two points of the solid block each other if the line between them leaves it by more than a limit; a convex part near
the solid holds no such pair. The plane taken is the one that separates most blocked pairs for few others: unlike the
volume of the hulls it sees what a first cut through a bore is good for. Candidates are planes along the faces of
concave edges, across the cell's own axes, and any that are proposed.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from kabo.geometry.cells import Cell, cut, whole
from kabo.geometry.kernels.sight import blocked_pairs
from kabo.geometry.nearness import proven_near
from kabo.geometry.parts import Array
from kabo.geometry.reduction import solid_points
from kabo.geometry.solids import Solid

SIGHTS = 48  # points of a cell between which lines are drawn
POSITIONS = np.linspace(0.0, 1.0, 14)[1:-1]  # where a cell may be cut, along each of its axes
CONCAVE = 60  # concave edges of a cell that propose planes, the greatest first
FOR_THE_REST = 0.5  # what separating a pair that sees each other weighs against one that does not
SLIVER = 0.2  # of the limit: nothing thinner is cut off
LARGE = 4000  # points of a cell above which only some are looked at
PROOF = 20_000  # tetrahedra after which a cell that looks near is taken for it


@dataclass(frozen=True)
class Atom:
    """What the mesh keeps in a cell: its hull's corners (P, 3), near the solid."""

    points: Array
    cell: Cell


@dataclass(frozen=True)
class Creases:
    """Concave edges: their middles (E, 3), the normals of both faces (E, 3), angle times length (E,)."""

    middles: Array
    left: Array
    right: Array
    weights: Array

    def within(self, chosen: NDArray[np.bool_]) -> "Creases":
        """Those chosen."""
        return Creases(self.middles[chosen], self.left[chosen], self.right[chosen], self.weights[chosen])


class TooFine(Exception):
    """More cells would be needed than were allowed; carries their number."""


def atoms(solid: Solid, limit: float, proposed: Array, most: int) -> list[Atom]:
    """Cells whose hulls look near the solid within `limit` [m]; together they hold all of it.

    Args:
        proposed: planes (N, 4), n·x = d, to consider besides its own.
        most: cells allowed.

    Raises:
        TooFine: more than `most` cells would be needed.
    """
    work = [(whole(solid.vertices, solid.faces), creases(solid.vertices, solid.faces))]
    found: list[Atom] = []
    while work:
        cell, concave = work.pop()
        points = solid_points(cell.points, 5e-3 * limit)
        if proven_near(solid, points, limit, PROOF) is not False:
            found.append(Atom(points, cell))
            continue
        if len(found) + len(work) >= most:
            raise TooFine(f"{most}")
        plane = _best_plane(solid, cell, points, limit, concave, proposed)
        normal, offset = plane[:3], float(plane[3])
        above = concave.middles @ normal >= offset
        for half, side in zip(cut(cell, normal, offset), (~above, above), strict=True):
            if len(half.segments):
                work.append((half, concave.within(side)))
    return found


def creases(vertices: Array, faces: NDArray[np.int64]) -> Creases:
    """The edges of a closed mesh at which it is hollow by more than 5 degrees."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort(edges.T[::-1])
    edges, owner = edges[order], order // 3
    twin = np.flatnonzero((edges[:-1] == edges[1:]).all(axis=1))
    left, right, edges = owner[twin], owner[twin + 1], edges[twin]
    opposite = faces[right].sum(axis=1) - edges.sum(axis=1)
    height = ((vertices[opposite] - vertices[edges[:, 0]]) * normals[left]).sum(axis=1)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    angle = np.arccos(np.clip((normals[left] * normals[right]).sum(axis=1), -1.0, 1.0))
    hollow = (height > 0.0) & (angle > np.radians(5.0))
    middles = vertices[edges].mean(axis=1)
    return Creases(middles, normals[left], normals[right], angle * length).within(hollow)


def _best_plane(solid: Solid, cell: Cell, points: Array, limit: float, concave: Creases, proposed: Array) -> Array:
    """The plane (4,) that separates most blocked pairs for few others."""
    sights = _spread(np.unique(np.vstack([points, cell.points]), axis=0), SIGHTS)
    blocked = np.zeros((len(sights), len(sights)), np.int64)
    blocked_pairs(sights, limit, *solid.tree, np.zeros(64, np.int64), blocked)
    planes = np.vstack([_across(points), _along(concave), proposed])
    above = (sights @ planes[:, :3].T >= planes[:, 3]).astype(float)
    heights = points @ planes[:, :3].T - planes[:, 3]
    thickness = np.minimum(-heights.min(axis=0), heights.max(axis=0))
    hidden = blocked.astype(float)
    score = _separated(hidden, above) - FOR_THE_REST * _separated(1.0 - hidden, above)
    if not blocked.any():
        score = thickness  # too coarse a look: the middle is as good as any
    score = np.where(thickness >= min(SLIVER * limit, float(thickness.max())), score, -np.inf)
    return np.asarray(planes[int(np.argmax(np.round(score, 9)))], np.float64)


def _separated(pairs: Array, above: Array) -> Array:
    """The share of the pairs (N, N) that each plane separates, given who is above (N, planes)."""
    return np.asarray(((pairs @ above) * (1.0 - above)).sum(axis=0) / max(0.5 * pairs.sum(), 1.0))


def _across(points: Array) -> Array:
    """Planes across the coordinate axes and the points' own."""
    axes = np.vstack([np.eye(3), np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]])
    low, high = (points @ axes.T).min(axis=0), (points @ axes.T).max(axis=0)
    offsets = low[:, None] + POSITIONS * (high - low)[:, None]
    return np.column_stack([np.repeat(axes, len(POSITIONS), axis=0), offsets.reshape(-1)])


def _along(concave: Creases) -> Array:
    """Planes along both faces of concave edges, and between them."""
    chosen = np.argsort(-concave.weights, kind="stable")[:CONCAVE]
    left, right = concave.left[chosen], concave.right[chosen]
    between = left - right
    between /= np.maximum(np.linalg.norm(between, axis=1, keepdims=True), 1e-300)
    normals = np.vstack([left, right, between])
    offsets = (normals * np.tile(concave.middles[chosen], (3, 1))).sum(axis=1)
    return np.column_stack([normals, offsets])


def _spread(points: Array, many: int) -> Array:
    """So many of the points, each as far from those before it as can be."""
    points = points[:: len(points) // LARGE + 1]
    chosen = [int(np.argmin(points @ np.array([1.0, 0.9, 0.8])))]
    distances = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(many, len(points)):
        chosen.append(int(np.argmax(distances)))
        distances = np.minimum(distances, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return np.ascontiguousarray(points[chosen])


def hull_volume(points: Array) -> float:
    """The volume of the hull of points that are not flat [m^3]."""
    return float(ConvexHull(points).volume)
