"""A closed mesh as few convex parts of at most 24 vertices, each proven within a tolerance of the solid.

Cutting planes come from CoACD [Wei 2022] and from a cell's own axes. The parts are not CoACD's hulls, which miss
some of the surface, but hulls of the solid inside each cell between the cuts, so their union covers the solid by
construction. Cells whose part sticks out too far are cut again; neighbours are joined where one part can replace
two.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.children import made_in_child, never
from kabo.errors import KaboError
from kabo.geometry.bounding.cells import Cell, cut, whole
from kabo.geometry.bounding.enclosing_polytope import enclosing_polytope, hull_planes, solid_points
from kabo.geometry.triangles.solids import Solid
from kabo.meshes.topology import edges_of, repeating

COARSE_CONCAVITY = 0.15  # CoACD's threshold, for a mesh scaled to [-1, 1]
COACD_PROCESSOR_SECONDS = 120  # allowed to CoACD; shipped meshes take 30 at most
MAX_CELLS = 200  # a mesh that needs more is refused
CUT_POSITIONS = np.linspace(0.0, 1.0, 8)[1:-1]  # of cutting planes, as shares of a cell along each direction
RANKING_SEGMENTS, PLANES_COMPARED = 400, 3  # segments by which planes are ranked; planes compared exactly
PROVABLE_SHARE = 0.9  # of the tolerance: parts that stick out farther take too long to prove
TIGHTER_SHARES = (0.02, 0.5)  # between the deviation and the tolerance: tried as tighter bounds


Cut = tuple[Array, float]  # a plane: normal·x = offset


class ToleranceTooFine(Exception):
    """Raised if the tolerance needs more cells than allowed; its argument is the permitted number of cells."""


@dataclass(frozen=True)
class EnclosedCell:
    """The solid inside a cell, and its enclosing part; `part` is None while no enclosing part is close enough."""

    points: Array  # (P, 3) hull vertices of the solid inside the cell
    cell: Cell | None  # None if cells were joined
    part: Array | None


def decompose(solid: Solid, tolerance: float, seed: int, look: Callable[[], None] = never) -> list[Array]:
    """The convex parts (V <= 24, 3) [m] that enclose a solid within `tolerance` [m]; one part if it is nearly convex.

    CoACD runs in a child process, since it cannot be interrupted and its threads do not survive a fork. `look` is
    called repeatedly meanwhile; if it raises an exception, the child process is killed.

    Raises:
        ToleranceTooFine: more than 200 cells would be needed.
    """
    cell = whole(solid.vertices, solid.faces)
    piece = _piece(solid, tolerance, cell.points, cell)
    if piece.part is not None:
        return [piece.part]
    return made_in_child(lambda: _in_cells(solid, tolerance, seed, cell), look)


def _in_cells(solid: Solid, tolerance: float, seed: int, cell: Cell) -> list[Array]:
    """The parts of a solid that needs several."""
    cuts = proposed_cuts(solid.vertices, solid.faces, seed)
    pieces = _joined(solid, tolerance, list(_settled(solid, tolerance, cell, cuts)))
    return [piece.part for piece in pieces if piece.part is not None]


def proposed_cuts(vertices: Array, faces: Integers, seed: int) -> list[Cut]:
    """Planes between neighbouring hulls of a coarse CoACD decomposition of the mesh.

    CoACD's search is short and bounded by counts, not by a clock, so that the same mesh gives the same planes. For
    a mesh that is not a manifold there are no planes, since CoACD may crash on it.
    """
    edges = edges_of(faces)
    if edges.crowded.any() or repeating(np.sort(faces, axis=1)).any():
        return []
    hulls = _hulls(
        vertices,
        faces,
        threshold=COARSE_CONCAVITY,
        preprocess_mode="off",
        resolution=200,
        mcts_nodes=10,
        mcts_iterations=20,
        mcts_max_depth=1,
        seed=seed,
    )
    points: list[Array] = []
    planes: list[Array] = []
    for hull in hulls:
        with suppress(QhullError):  # a flat one has no faces to cut along
            planes.append(hull_planes(hull))
            points.append(hull)
    cuts = []
    for i in range(len(points)):
        for j in range(i):
            sides = [(points[i], planes[j]), (points[j], planes[i])]
            # The face of one hull that the other lies farthest behind.
            gaps = [(other @ own[:, :3].T - own[:, 3]).min(axis=0) for other, own in sides]
            side = int(gaps[1].max() > gaps[0].max())
            normal_d = sides[side][1][int(np.argmax(gaps[side]))]
            cuts.append((normal_d[:3], float(normal_d[3])))
    return cuts


def proven_deviation(solid: Solid, parts: list[Array], tolerance: float) -> float:
    """A proven bound, at most `tolerance`, of how far any point of the parts is from the solid [m]."""
    planes = [hull_planes(part) for part in parts]
    reached = max(float(solid.outside_distances(part).max()) for part in parts)
    for share in TIGHTER_SHARES:  # the farthest point is mostly a vertex, so the first try mostly succeeds
        bound = reached + share * (tolerance - reached)
        if all(solid.proves_within(part, own, bound) for part, own in zip(parts, planes, strict=True)):
            return bound
    return tolerance


def _piece(solid: Solid, tolerance: float, points: Array, cell: Cell | None) -> EnclosedCell:
    """The points of a cell with an enclosing part, if one is proven close enough."""
    points = solid_points(points, 5e-3 * tolerance)
    if cell is None or _may_do(solid, points, tolerance):
        part = enclosing_polytope(points, 0.5 * tolerance)
        near = (solid.outside_distances(part) <= PROVABLE_SHARE * tolerance).all()
        if near and solid.proves_within(part, hull_planes(part), tolerance):
            return EnclosedCell(points, cell, part)
    return EnclosedCell(points, cell, None)


def _may_do(solid: Solid, points: Array, tolerance: float) -> bool:
    """Whether the hull of the points is close enough at its faces' centres; if not, no enclosing part can be."""
    hull = ConvexHull(points)
    areas = np.linalg.norm(
        np.cross(
            points[hull.simplices[:, 1]] - points[hull.simplices[:, 0]],
            points[hull.simplices[:, 2]] - points[hull.simplices[:, 0]],
        ),
        axis=1,
    )
    largest = hull.simplices[np.argsort(-areas, kind="stable")[:64]]
    return bool((solid.outside_distances(points[largest].mean(axis=1)) <= tolerance).all())


def _hulls(vertices: Array, faces: Integers, **parameters: Any) -> list[Array]:
    """The corners (V, 3) of the hulls into which CoACD cuts a mesh; none if it crashes or takes too long.

    It may crash on unusual meshes; then there are more parts, but proofs do not depend on it.
    """
    try:
        return made_in_child(lambda: _by_coacd(vertices, faces, parameters))
    except KaboError:
        return []


def _by_coacd(vertices: Array, faces: Integers, parameters: dict[str, Any]) -> list[Array]:
    with suppress(ImportError):  # a system without such limits
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (COACD_PROCESSOR_SECONDS, COACD_PROCESSOR_SECONDS))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(2, 1)  # what the library says is no answer of a command
    import coacd

    coacd.set_log_level("off")
    return [np.asarray(hull[0], np.float64) for hull in coacd.run_coacd(coacd.Mesh(vertices, faces), **parameters)]


def _settled(solid: Solid, tolerance: float, cell: Cell, cuts: list[Cut]) -> Iterator[EnclosedCell]:
    """Cells with their parts: cells are cut until each has a part."""
    work = [(cell, list(cuts))]
    count = 0
    while work:
        cell, left = work.pop()
        piece = _piece(solid, tolerance, cell.points, cell)
        if piece.part is not None:
            count += 1
            yield piece
            continue
        if count + len(work) >= MAX_CELLS:
            raise ToleranceTooFine(f"{MAX_CELLS}")
        index, normal, offset = _best_cut(cell, piece.points, left)
        rest = [c for i, c in enumerate(left) if i != index]
        work += [(half, rest) for half in cut(cell, normal, offset) if len(half.segments)]


def _best_cut(cell: Cell, points: Array, proposed: list[Cut]) -> tuple[int, Array, float]:
    """The plane with the least volume of both hulls, among those proposed and those across the cell's own axes."""
    axes = np.vstack([np.eye(3), np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]])
    candidates = list(enumerate(proposed))
    for axis in axes:
        low, high = (points @ axis).min(), (points @ axis).max()
        candidates += [(-1, (axis, low + t * (high - low))) for t in CUT_POSITIONS]
    # A thinned cell ranks the planes, the whole cell decides between the best.
    stride = max(1, len(cell.segments) // RANKING_SEGMENTS)
    thinned = Cell(cell.segments[::stride], np.arange(len(cell.segments[::stride])))
    ranked = sorted(range(len(candidates)), key=lambda i: (_cut_volume(thinned, *candidates[i][1]), i))
    best = min(ranked[:PLANES_COMPARED], key=lambda i: (_cut_volume(cell, *candidates[i][1]), i))
    return candidates[best][0], *candidates[best][1]


def _cut_volume(cell: Cell, normal: Array, offset: float) -> float:
    """The volume of the hulls on both sides of a plane; infinite if one side is empty."""
    halves = cut(cell, normal, offset)
    if any(len(half.segments) < 4 for half in halves):
        return np.inf
    return sum(_volume(half.segments.reshape(-1, 3)) for half in halves)


def _volume(points: Array) -> float:
    try:
        return float(ConvexHull(points).volume)
    except QhullError:  # flat
        return 0.0


def _joined(solid: Solid, tolerance: float, pieces: list[EnclosedCell]) -> list[EnclosedCell]:
    """The pieces after neighbours were joined, cheapest first, where one part can replace two."""
    refused: set[tuple[int, int]] = set()
    gains: dict[tuple[int, int], float] = {}
    numbered = dict(enumerate(pieces))
    following = len(pieces)
    while True:
        pairs = [(i, j) for i in numbered for j in numbered if i < j and (i, j) not in refused]
        for i, j in pairs:
            if (i, j) not in gains:
                gains[i, j] = _gain(numbered[i], numbered[j])
        for _, i, j in sorted((gains[pair], *pair) for pair in pairs if np.isfinite(gains[pair])):
            points = np.vstack([numbered[i].points, numbered[j].points])
            joined = _piece(solid, tolerance, points, None)
            if joined.part is not None:
                del numbered[i], numbered[j]
                numbered[following] = joined
                following += 1
                break
            refused.add((i, j))
        else:
            return list(numbered.values())


def _gain(first: EnclosedCell, second: EnclosedCell) -> float:
    """The volume that joining two pieces would add, relative to theirs; infinite if they are apart or it is too much."""
    low = np.maximum(first.points.min(axis=0), second.points.min(axis=0))
    high = np.minimum(first.points.max(axis=0), second.points.max(axis=0))
    if (low > high + 1e-6).any():
        return np.inf
    own = _volume(first.points) + _volume(second.points)
    added = _volume(np.vstack([first.points, second.points])) - own
    return added / own if own > 0 and added < 0.6 * own else np.inf
