"""Cuts a solid into cells whose hulls stay near it, by lines of sight.

Two points of the solid block each other if the line between them leaves it by more than a limit; a convex part
near the solid holds no such pair. The plane chosen separates many blocked pairs and few others; unlike the volume
of hulls, this measure also values a first cut through a bore. A cell is cut because some point of its hull is too
far from the solid; points visible from there are included, so that a small hollow in a large cell is found.
Candidates are planes along the faces of concave edges and of large faces, and across the axes of the cell.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.cells import Cell, cut, of_faces
from kabo.geometry.bounding.containment import hull_of, solid_points
from kabo.geometry.bounding.kernels.visibility import blocked_pairs, first_crossings
from kabo.geometry.bounding.nearness import EVEN_DIRECTIONS, near_or_witness
from kabo.geometry.triangles.solids import Solid

SIGHT_POINTS = 48  # points of a cell between which lines are drawn
SIGHT_SHARE = 0.4  # of the limit, by which lines may leave the solid; below 1 since few lines pass the worst place
MAX_CROSSINGS = 256  # of a line with the surface; further ones are ignored
CUT_POSITIONS = np.linspace(0.0, 1.0, 14)[1:-1]  # of cutting planes, as shares of a cell along its axes
MAX_CONCAVE_EDGES = 60  # of a cell that propose planes, the sharpest and longest first
MAX_FACES_PROPOSED = 40  # of a cell, the largest
SEEN_PAIR_WEIGHT = 0.5  # of separating a pair that sees each other, if a blocked pair weighs 1
MIN_THICKNESS_SHARE = 0.2  # of the limit: thinner slices are not cut off
MAX_GROUPS_APART = 32  # of components: more are cut together
MAX_POINTS_LOOKED_AT = 4000  # of a cell; of more points only some are used
PROOF_TETRAHEDRA = 20_000  # of a proof, after which a cell that appears near is accepted
FLAT_THICKNESS_SHARE = 5e-3  # of the limit, given to flat cells


@dataclass(frozen=True)
class Creases:
    """Concave edges of a mesh: their middles (E, 3), the normals of both faces (E, 3), and angle times length (E,)."""

    middles: Array
    left: Array
    right: Array
    weights: Array

    def within(self, chosen: NDArray[np.bool_] | Integers) -> "Creases":
        """The concave edges selected by a mask or an array of indices."""
        return Creases(self.middles[chosen], self.left[chosen], self.right[chosen], self.weights[chosen])

    def nearest(self, point: Array) -> "Creases":
        """The concave edges whose middles are nearest to a point."""
        away = ((self.middles - point) ** 2).sum(axis=1)
        return self.within(np.argsort(np.round(away, 12), kind="stable")[:MAX_CONCAVE_EDGES])


@dataclass(frozen=True)
class HulledCell:
    """A cell with its hull's corners (P, 3) and the concave edges inside it."""

    points: Array
    cell: Cell
    concave: Creases


class TooManyCells(Exception):
    """Raised if more cells are needed than allowed; its argument is the permitted number of cells."""


def split_solid(
    solid: Solid, limit: float, most: int, sight: float, begun: Sequence[HulledCell] | None = None
) -> list[HulledCell]:
    """Cells that together contain the solid, with hulls within `limit` [m] of it as far as samples show.

    Args:
        most: the greatest number of cells.
        sight: the greatest permitted distance of a line of sight from the solid [m], which decides where cells are cut.
        begun: cells to start from, instead of the whole solid.

    Raises:
        TooManyCells: more than `most` cells would be needed.
    """
    work = [_whole(solid, sight)] if begun is None else list(begun)
    found: list[HulledCell] = []
    while work:
        hulled = work.pop()
        near, far = near_or_witness(solid, hulled.points, limit, PROOF_TETRAHEDRA)
        if near is not False:
            found.append(hulled)
            continue
        if len(found) + len(work) >= most:
            raise TooManyCells(f"{most}")
        apart = cells_of_groups(solid, sight) if begun is None and not found and not work else []
        begun = begun or [hulled]
        work += apart if len(apart) > 1 else cut_in_two(solid, hulled, sight, far)
    return found


def _whole(solid: Solid, sight: float) -> HulledCell:
    return _cell_of(solid, np.arange(len(solid.faces)), sight)


def _cell_of(solid: Solid, own: Integers, sight: float) -> HulledCell:
    """The cell of some faces, given by their indices (F,), that close."""
    cell = of_faces(solid.vertices, solid.faces, own)
    points = solid_points(cell.points, FLAT_THICKNESS_SHARE * sight)
    return HulledCell(points, cell, creases(solid.vertices, solid.faces[own]))


def cells_of_groups(solid: Solid, sight: float) -> list[HulledCell]:
    """A cell for each group of components, except those within a convex one; none if there are many."""
    kept: list[Integers] = []
    around: list[Array] = []
    for group in solid.groups:
        points = group.solid.vertices
        if any((points @ planes[:, :3].T + planes[:, 3] <= 0.0).all() for planes in around):
            continue
        kept.append(group.faces)
        if len(kept) > MAX_GROUPS_APART:
            return []
        if group.solid.is_convex:
            around.append(hull_of(points).equations)
    return [_cell_of(solid, own, sight) for own in kept]


def cut_in_two(solid: Solid, hulled: HulledCell, limit: float, far: Array | None) -> list[HulledCell]:
    """The two parts into which the best plane cuts a cell.

    Args:
        limit: the greatest permitted distance of a line of sight from the solid [m].
        far: a point (3,) of the cell's hull that is too far from the solid; None: the cell is halved.
    """
    plane = _middle(hulled.points) if far is None else _best_plane(solid, hulled, limit, far)
    normal, offset = plane[:3], float(plane[3])
    above = hulled.concave.middles @ normal >= offset
    return [
        HulledCell(solid_points(half.points, FLAT_THICKNESS_SHARE * limit), half, hulled.concave.within(side))
        for half, side in zip(cut(hulled.cell, normal, offset), (~above, above), strict=True)
        if len(half.segments)
    ]


def creases(vertices: Array, faces: Integers) -> Creases:
    """The edges of a closed mesh that are concave by more than 5 degrees."""
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


def _middle(points: Array) -> Array:
    """The plane (4,) through the middle of the longest side, perpendicular to it."""
    low, high = points.min(axis=0), points.max(axis=0)
    axis = int(np.argmax(high - low))
    plane: Array = np.r_[np.eye(3)[axis], 0.5 * (low + high)[axis]]
    return plane


def _best_plane(solid: Solid, hulled: HulledCell, limit: float, far: Array) -> Array:
    """The plane (4,) that separates many blocked pairs and few others."""
    points = hulled.points
    sights = _spread(np.unique(np.vstack([points, hulled.cell.points]), axis=0), SIGHT_POINTS)
    blocked = _blocked(solid, sights, limit)
    planes = np.vstack([_across(points), _along(hulled.concave), _of_faces(solid, hulled.cell)])
    if not blocked.any():  # too coarse a look
        sights = np.ascontiguousarray(np.vstack([sights, _seen_from(solid, points, far)]))
        blocked = _blocked(solid, sights, SIGHT_SHARE * limit)
        planes = np.vstack([planes, _through(planes[:, :3], far), _along(hulled.concave.nearest(far))])
    above = (sights @ planes[:, :3].T >= planes[:, 3]).astype(float)
    heights = points @ planes[:, :3].T - planes[:, 3]
    thickness = np.minimum(-heights.min(axis=0), heights.max(axis=0))
    score = _separated(blocked, above) - SEEN_PAIR_WEIGHT * _separated(1.0 - blocked, above)
    if not blocked.any():
        score = thickness  # the middle is as good as any
    score = np.where(thickness >= min(MIN_THICKNESS_SHARE * limit, float(thickness.max())), score, -np.inf)
    return np.asarray(planes[int(np.argmax(np.round(score, 9)))], np.float64)


def _blocked(solid: Solid, sights: Array, limit: float) -> Array:
    """A matrix (N, N): 1.0 for pairs of points (N, 3) that cannot see each other, else 0.0."""
    blocked = np.zeros((len(sights), len(sights)), np.int64)
    blocked_pairs(
        sights, limit, *solid.tree, np.zeros(64, np.int64), np.zeros(6), np.zeros(MAX_CROSSINGS), blocked
    )
    return blocked.astype(float)


def _seen_from(solid: Solid, points: Array, far: Array) -> Array:
    """The surface points (N, 3) inside a hull of points that are visible from a point of this hull."""
    hull = hull_of(points).equations
    room = np.maximum(-(hull[:, :3] @ far + hull[:, 3]), 0.0)
    nearing = np.maximum(hull[:, :3] @ EVEN_DIRECTIONS.T, 1e-12)  # of each face, in each direction
    steps = np.ascontiguousarray(EVEN_DIRECTIONS * (room[:, None] / nearing).min(axis=0)[:, None])
    shares = np.ones(len(steps))
    scratch = np.zeros(64, np.int64), np.zeros(6), np.zeros(MAX_CROSSINGS)
    first_crossings(far, steps, *solid.tree, *scratch, shares)
    met = shares < 1.0
    return np.asarray(far + steps[met] * shares[met, None])


def _separated(pairs: Array, above: Array) -> Array:
    """The share of the pairs (N, N) that each plane separates; `above` (N, planes): which points lie above it."""
    return np.asarray(((pairs @ above) * (1.0 - above)).sum(axis=0) / max(0.5 * pairs.sum(), 1.0))


def _across(points: Array) -> Array:
    """Planes across the coordinate axes and the points' own."""
    axes = np.vstack([np.eye(3), np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]])
    low, high = (points @ axes.T).min(axis=0), (points @ axes.T).max(axis=0)
    offsets = low[:, None] + CUT_POSITIONS * (high - low)[:, None]
    return np.column_stack([np.repeat(axes, len(CUT_POSITIONS), axis=0), offsets.reshape(-1)])


def _through(normals: Array, point: Array) -> Array:
    """Planes through a point."""
    normals = np.unique(np.round(normals, 9), axis=0)
    return np.column_stack([normals, normals @ point])


def _along(concave: Creases) -> Array:
    """Planes along both faces of concave edges, and between them."""
    chosen = np.argsort(-concave.weights, kind="stable")[:MAX_CONCAVE_EDGES]
    left, right = concave.left[chosen], concave.right[chosen]
    between = left - right
    between /= np.maximum(np.linalg.norm(between, axis=1, keepdims=True), 1e-300)
    normals = np.vstack([left, right, between])
    offsets = (normals * np.tile(concave.middles[chosen], (3, 1))).sum(axis=1)
    return np.column_stack([normals, offsets])


def _of_faces(solid: Solid, cell: Cell) -> Array:
    """The planes of the largest faces of a cell: where components overlap, no edge lies along the concave corner."""
    own = np.unique(cell.faces)
    own = own[own < len(solid.faces)]  # others are cuts
    equations, areas = solid.planes
    largest = own[np.argsort(-np.round(areas[own], 12), kind="stable")[:MAX_FACES_PROPOSED]]
    return np.unique(np.round(equations[largest], 9), axis=0)


def _spread(points: Array, many: int) -> Array:
    """`many` of the points, each as far as possible from those before it."""
    points = points[:: len(points) // MAX_POINTS_LOOKED_AT + 1]
    chosen = [int(np.argmin(points @ np.array([1.0, 0.9, 0.8])))]
    distances = ((points - points[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(many, len(points)):
        chosen.append(int(np.argmax(distances)))
        distances = np.minimum(distances, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
    return np.ascontiguousarray(points[chosen])
