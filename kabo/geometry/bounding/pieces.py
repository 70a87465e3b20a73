"""Parts made from convex pieces that a designer provides: faster than searching for cuts, and equally proven.

Each piece is enclosed by a part of at most 24 vertices, or halved until that is possible; the solid outside all
parts is computed cell by cell, and must be empty.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from kabo.arrays import Array
from kabo.geometry.bounding.cells import Cell, cut, whole
from kabo.geometry.bounding.enclosing_polytope import enclosing_polytope, hull_planes
from kabo.geometry.triangles.solids import Solid

PIECE_OVERLAP = 3e-5  # [m] by which pieces grow, so that rounding leaves no gap between neighbours
MAX_HALVINGS = 7  # of a piece
TIGHT_ENOUGH_SHARE = 0.25  # of the tolerance, below which parts are not improved


def parts_of_pieces(solid: Solid, pieces: Sequence[Array], tolerance: float) -> list[Array] | None:
    """Parts (V <= 24, 3) [m] that cover the solid, each proven within the tolerance; None if this fails.

    Args:
        solid: the mesh.
        pieces: convex sets (P, 3) [m] whose union is meant to contain the solid.
        tolerance: the greatest permitted distance of a part's points from the solid [m].
    """
    parts: list[Array] = []
    for piece in pieces:
        settled = _settled(solid, _grown(np.asarray(piece, np.float64)), tolerance, 0)
        if settled is None:
            return None
        parts += settled
    parts = _without_hidden(parts)
    return parts if not uncovered(solid, parts) else None


def uncovered(solid: Solid, parts: Sequence[Array]) -> list[Cell]:
    """The cells of the solid outside all parts; an empty list proves that the parts cover the solid."""
    cells = [whole(solid.vertices, solid.faces)]
    for part in sorted(parts, key=lambda part: -float(np.prod(np.ptp(part, axis=0)))):
        planes = hull_planes(part)
        cells = [left for cell in cells for left in _outside(cell, planes)]
    return cells


def _outside(cell: Cell, planes: Array) -> list[Cell]:
    """The cells of a cell's solid outside a convex part, given by planes (H, 4); the cell itself if they do not meet."""
    heights = cell.segments.reshape(-1, 3) @ planes[:, :3].T - planes[:, 3]
    if (heights.min(axis=0) >= 0.0).any():
        return [cell]
    highest = heights.max(axis=0)
    left: list[Cell] = []
    inside = cell
    for row in np.argsort(-highest, kind="stable"):  # first the plane that most lies behind
        if highest[row] < 0.0:
            break
        inside, outside = cut(inside, planes[row, :3], float(planes[row, 3]))
        if not len(inside.segments):
            return [cell]
        if len(outside.segments):
            left.append(outside)
    return left


def _settled(solid: Solid, points: Array, tolerance: float, depth: int) -> list[Array] | None:
    part = enclosing_polytope(points, TIGHT_ENOUGH_SHARE * tolerance)
    near = (solid.outside_distances(part) <= tolerance).all()
    if near and solid.proves_within(part, hull_planes(part), tolerance):
        return [part]
    if depth == MAX_HALVINGS:
        return None
    parts: list[Array] = []
    for half in _halves(points):
        settled = _settled(solid, half, tolerance, depth + 1)
        if settled is None:
            return None
        parts += settled
    return parts


def _halves(points: Array) -> list[Array]:
    """Both halves of a convex set, cut in the middle across its longest side."""
    axis = int(np.argmax(np.ptp(points, axis=0)))
    middle = 0.5 * (points[:, axis].min() + points[:, axis].max())
    hull = ConvexHull(points)
    return [
        _hull_points(half.points) for half in cut(whole(points, hull.simplices), np.eye(3)[axis], float(middle))
    ]


def _grown(points: Array) -> Array:
    corners = PIECE_OVERLAP * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return _hull_points((points[:, None] + corners[None]).reshape(-1, 3))


def _hull_points(points: Array) -> Array:
    corners: Array = points[ConvexHull(points).vertices]
    return corners


def _without_hidden(parts: list[Array]) -> list[Array]:
    """The parts that do not lie inside another one."""
    kept = list(range(len(parts)))
    for i in range(len(parts)):
        for j in kept:
            planes = hull_planes(parts[j])
            if i != j and (parts[i] @ planes[:, :3].T <= planes[:, 3]).all():
                kept.remove(i)
                break
    return [parts[i] for i in kept]
