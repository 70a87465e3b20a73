"""Encloses a convex point set by a polytope with few corners that stays within a limit of a solid.

An edge is contracted to a point beyond the planes of all faces around it, so each polytope encloses the previous
one [K 4.3]. A corner may lie anywhere near the solid, also where other parts cover the solid.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.containment import contains_proven, hull_of, widened
from kabo.geometry.bounding.kernels.depth_octree import star_is_far
from kabo.geometry.bounding.kernels.polytope_corners import contractions
from kabo.geometry.bounding.nearness import Voids, corner_limit, faces_near, near_or_witness, proven_near
from kabo.geometry.triangles.solids import Solid

BATCH_ABOVE_CORNERS = 24  # above which several edges are contracted in a round
BATCH_SHARE = 0.25  # of the corners, contracted in such a round
CORNER_SHARES = (0.99, 0.93, 0.85)  # of the limit, for corners; tried in turn until the result is proven
MIN_CORNER_ROOM = 0.75  # of the limit: corners keep so near a nearly convex solid that they alone prove a part
MANY_CORNERS = 150  # of a hull, above which contraction begins with a polytope of few planes around it
LIKE_NORMALS = 0.94  # cosine of the angle below which one of two planes is left out at first
FEW_PLANES_SHARE = 0.35  # of the limit: how far that polytope may stick out
FEWER_CORNERS = 0.7  # of the hull's, as which it must have fewer
MAX_PLANE_ROUNDS = 24  # of adding planes
REFUTING_TETRAHEDRA = 20_000  # of an attempt to refute a hull, which is proven with its part otherwise
MAX_RESUMPTIONS = 8  # after refutations, for each of these shares
MAX_FACES_AT_EDGE = 256  # edges with more faces around them are not contracted


class HullArrays(NamedTuple):
    """A hull for kernels; the faces at corner v are around[starts[v]:starts[v + 1]]."""

    points: Array  # (V, 3) [m]
    simplices: Integers  # (F, 3)
    equations: Array  # (F, 4) n·x <= d
    areas: Array  # (F,) twice the areas
    edges: Integers  # (E, 2)
    starts: Integers  # (V + 1,)
    around: Integers  # (3F,)


class ContractionScratch(NamedTuple):
    """Room for the planes around an edge, and for finding the point beyond all of them."""

    planes: Array  # (R, 4)
    weights: Array  # (R,)
    rows: Array  # (R, 4)
    found: Array  # (3,)
    trial: Array  # (3,)
    held: Integers  # (4,)


def enclosing_part(solid: Solid, points: Array, limit: float, voids: Voids | None = None) -> Array | None:
    """The corners (V, 3) [m] of a polytope with few corners, proven to contain points (P, 3) and to stay near the solid.

    If a point refutes the final polytope, contraction resumes from the last polytope that excludes this point.

    Args:
        limit: the greatest permitted distance of any point of the polytope from the solid [m].
        voids: points that no part may contain; refuting points that are found are added.

    Returns:
        The corners; None if not even the convex hull of the points can be proven to stay near the solid.
    """
    voids = Voids(solid) if voids is None else voids
    hull = hull_of(points)
    if voids.meet(hull, limit):
        return None
    corners = points[np.sort(hull.vertices)]
    asked, room = len(corners) > MANY_CORNERS, corner_limit(solid, limit)
    corner_room = room if room > MIN_CORNER_ROOM * limit else limit
    if asked and _is_refuted(solid, corners, hull, limit, voids):
        return None
    around = _around(solid, corners, hull, limit, voids) if asked else None
    for begun in ([corners], [corners, around])[around is not None :: -1]:
        for share in CORNER_SHARES:
            way = begun
            for _ in range(MAX_RESUMPTIONS):
                way = _way(solid, way, min(share * limit, corner_room), voids)
                end = widened(way[-1])
                near, far = near_or_witness(solid, end, limit)
                if near and contains_proven(end, points):
                    return end
                if not asked and _is_refuted(solid, corners, hull, limit, voids):
                    return None
                asked = True
                if far is None:
                    break
                voids.add(far, hull_of(end))
                if voids.meet(hull, limit):
                    return None
                way = way[: _first_that_meets(way, voids, limit)] or [corners]
    return _last_proven(solid, points, way, limit)


def _is_refuted(solid: Solid, corners: Array, hull: ConvexHull, limit: float, voids: Voids) -> bool:
    """Whether a point of a hull is known to be too far from the solid; this point is then a void."""
    hollow = near_or_witness(solid, corners, limit, REFUTING_TETRAHEDRA)[1]
    if hollow is not None:
        voids.add(hollow, hull)
    return hollow is not None


def _around(solid: Solid, corners: Array, hull: ConvexHull, limit: float, voids: Voids) -> Array | None:
    """The corners of a polytope around a hull, of few planes and near the solid; None if it has hardly fewer corners."""
    around = _of_few_planes(solid, corners, hull, FEW_PLANES_SHARE * limit)
    if around is None or len(around) > FEWER_CORNERS * len(corners) or voids.meet(hull_of(around), limit):
        return None
    return around


def _of_few_planes(solid: Solid, corners: Array, hull: ConvexHull, enough: float) -> Array | None:
    """The corners of a polytope of some of a hull's planes, none farther than `enough` from the solid.

    None if it is not found soon.
    """
    triangles = hull.points[hull.simplices]
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    middle = corners.mean(axis=0)
    normals = hull.equations[np.argsort(-np.round(areas / areas.max(), 6), kind="stable"), :3]
    offsets = ((corners - middle) @ normals.T).max(axis=0)
    left, chosen = np.ones(len(normals), np.bool_), np.zeros(len(normals), np.bool_)
    while left.any():
        first = int(np.argmax(left))
        chosen[first] = True
        left &= normals @ normals[first] < LIKE_NORMALS
    for _ in range(MAX_PLANE_ROUNDS):
        around = _meeting(normals[chosen], offsets[chosen])
        if around is None:
            return None
        beyond = around @ normals.T - offsets
        far = (solid.outside_distances(around + middle) > enough) & (beyond.max(axis=1) > 0.1 * enough)
        if not far.any():
            around = around + middle
            return np.asarray(around[np.sort(hull_of(around).vertices)])
        chosen[np.argmax(beyond[far], axis=1)] = True
    return None


def _meeting(normals: Array, offsets: Array) -> Array | None:
    """The corners (V, 3) of the polytope n·x <= d around the origin; None if it is unbounded."""
    try:
        with np.errstate(divide="ignore", invalid="ignore"):  # an unbounded set has corners at infinity
            found = HalfspaceIntersection(np.column_stack([normals, -offsets]), np.zeros(3))
    except QhullError:
        return None
    if not (found.dual_equations[:, -1] < -1e-9).all():
        return None
    return np.unique(np.round(found.intersections, 12), axis=0)


def _first_that_meets(way: list[Array], voids: Voids, limit: float) -> int:
    """The index of the first polytope of a sequence that contains a void; the last one does, at least after widening."""
    low, high = 0, len(way) - 1
    while low < high:
        middle = (low + high) // 2
        if voids.meet(hull_of(way[middle]), limit):
            high = middle
        else:
            low = middle + 1
    return low


def _last_proven(solid: Solid, points: Array, way: list[Array], limit: float) -> Array | None:
    """The last polytope of a sequence that can be proven, found by bisection."""
    best: Array | None = None
    low, index = 0, len(way) - 1
    high = index + 1
    while low < high:
        part = widened(way[index])
        if contains_proven(part, points) and proven_near(solid, part, limit):
            best, low = part, index + 1
        elif index == 0:
            return None
        else:
            high = index
        # After the end itself the beginning: where not even that can be proven, nothing can.
        index = 0 if best is None else (low + high) // 2
    return best


def _way(solid: Solid, begun: list[Array], limit: float, voids: Voids) -> list[Array]:
    """The sequence continued to the fewest corners: polytopes without voids, each of which encloses those before it."""
    way, points = list(begun), begun[-1]
    scratch = _scratch()
    refused: set[tuple[bytes, bytes]] = set()
    while len(points) > 4:
        hull = hull_of(points)
        if len(hull.vertices) < len(points):
            points = points[np.sort(hull.vertices)]
            continue
        edges, costs, places = _contractions(solid, points, hull, limit, scratch)
        following = _contracted(solid, points, hull, edges, costs, places, limit, refused, voids)
        if following is None:
            break
        points = following
        way.append(points)
    return way


def _scratch() -> ContractionScratch:
    most = MAX_FACES_AT_EDGE
    return ContractionScratch(
        np.empty((most, 4)),
        np.empty(most),
        np.empty((most, 4)),
        np.empty(3),
        np.empty(3),
        np.zeros(4, np.int64),
    )


def _contractions(
    solid: Solid, points: Array, hull: ConvexHull, limit: float, scratch: ContractionScratch
) -> tuple[Integers, Array, Array]:
    """The edges (E, 2) of a hull, the cost of contracting each, and the point it would be contracted to."""
    faces = hull.simplices.astype(np.int64)
    corners = points[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    planes = np.column_stack([hull.equations[:, :3], -hull.equations[:, 3]])
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    order = np.argsort(faces.reshape(-1), kind="stable")
    starts = np.searchsorted(faces.reshape(-1)[order], np.arange(len(points) + 1))
    costs, places = np.empty(len(edges)), np.zeros((len(edges), 3))
    arrays = HullArrays(points, faces, planes, areas, edges, starts, order // 3)
    contractions(arrays, limit, solid.arrays, scratch, costs, places)
    return edges, costs, places


def _contracted(
    solid: Solid,
    points: Array,
    hull: ConvexHull,
    edges: Integers,
    costs: Array,
    places: Array,
    limit: float,
    refused: set[tuple[bytes, bytes]],
    voids: Voids,
) -> Array | None:
    """The points after the cheapest contractions whose new faces appear near the solid; None if there are none."""
    many, middle = len(points) > BATCH_ABOVE_CORNERS, points.mean(axis=0)
    good = np.flatnonzero(np.isfinite(costs))
    good = good[np.argsort(costs[good], kind="stable")]
    allowed = max(1, int(BATCH_SHARE * len(points))) if many else 1
    cheap = set(good[: max(1, len(good) // 3)].tolist())
    touched, keep = np.zeros(len(points), bool), np.ones(len(points), bool)
    made: list[Array] = []
    for e in good:
        if made and e not in cheap:  # dear ones only where no cheap one can be had
            break
        a, b = edges[e]
        name = points[a].tobytes(), points[b].tobytes()
        if touched[a] or touched[b] or name in refused:
            continue
        if star_is_far(points, hull.simplices, a, b, places[e], limit, solid.arrays):
            refused.add(name)
            continue
        if not many:
            joined = np.vstack([np.delete(points, (a, b), axis=0), places[e]])
            larger = hull_of(joined)
            new = (larger.simplices == len(joined) - 1).any(axis=1)
            if not voids.meet(larger, limit) and faces_near(solid, joined[larger.simplices[new]], limit, middle):
                return joined
            refused.add(name)
            continue
        around = hull.simplices[np.isin(hull.simplices, (a, b)).any(axis=1)]
        moved = np.where(np.isin(around, (a, b))[..., None], places[e], points[around])
        new = moved[np.isin(around, (a, b)).sum(axis=1) == 1]
        if not faces_near(solid, new, limit, middle) or _meets_between(
            points, around, a, b, places[e], limit, voids
        ):
            refused.add(name)
            continue
        keep[[a, b]] = False
        touched[around] = True
        made.append(places[e])
        if len(made) >= allowed:
            break
    return np.vstack([points[keep], made]) if made else None


def _meets_between(
    points: Array, around: Integers, a: int, b: int, place: Array, limit: float, voids: Voids
) -> bool:
    """Whether the hull would contain a void if the edge a-b moved to `place`; `around` are the faces at the edge."""
    box = np.vstack([points[np.unique(around)], place])
    if not len(voids.between(box.min(axis=0), box.max(axis=0), limit)):
        return False
    return voids.meet(hull_of(np.vstack([np.delete(points, (a, b), axis=0), place])), limit)
