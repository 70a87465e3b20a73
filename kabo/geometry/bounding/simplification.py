"""Encloses a convex point set by a polytope with few corners that stays within a limit of a solid.

An edge is contracted to a point beyond the planes of all faces around it, so each polytope encloses the previous
one [K 4.3]. A corner may lie anywhere near the solid, also where other parts cover the solid.
"""

import numpy as np
from scipy.spatial import ConvexHull

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.enclosing_polytope import contains_proven, widened
from kabo.geometry.bounding.kernels.depth_octree import star_is_far
from kabo.geometry.bounding.kernels.polytope_corners import contractions
from kabo.geometry.bounding.nearness import Voids, faces_near, near_or_witness, proven_near
from kabo.geometry.triangles.solids import Solid

BATCH_ABOVE_CORNERS = 24  # above which several edges are contracted in a round
BATCH_SHARE = 0.25  # of the corners, contracted in such a round
CORNER_SHARES = (0.99, 0.93, 0.85)  # of the limit, for corners; tried in turn until the result is proven
MAX_RESUMPTIONS = 8  # after refutations, for each of these shares
MAX_FACES_AT_EDGE = 256  # edges with more faces around them are not contracted

Scratch = tuple[Array, Array, Array, Array]


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
    hull = ConvexHull(points)
    way = begun = [points[np.sort(hull.vertices)]]
    asked = False
    for share in CORNER_SHARES:
        way = begun
        for _ in range(MAX_RESUMPTIONS):
            if voids.meet(hull, limit):
                return None
            way = _way(solid, way, share * limit, voids)
            end = widened(way[-1])
            near, far = near_or_witness(solid, end, limit)
            if near and contains_proven(end, points):
                return end
            if not asked and (hollow := near_or_witness(solid, begun[0], limit)[1]) is not None:
                voids.add(hollow, hull)
                return None
            asked = True
            if far is None:
                break
            voids.add(far, ConvexHull(end))
            way = way[: _first_that_meets(way, voids, limit)] or begun
    return _last_proven(solid, points, way, limit)


def _first_that_meets(way: list[Array], voids: Voids, limit: float) -> int:
    """The index of the first polytope of a sequence that contains a void; the last one does, at least after widening."""
    low, high = 0, len(way) - 1
    while low < high:
        middle = (low + high) // 2
        if voids.meet(ConvexHull(way[middle]), limit):
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
        hull = ConvexHull(points)
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


def _scratch() -> Scratch:
    return (
        np.empty((MAX_FACES_AT_EDGE, 4)),
        np.empty(MAX_FACES_AT_EDGE),
        np.empty((MAX_FACES_AT_EDGE, 4)),
        np.empty((2, 3)),
    )


def _contractions(
    solid: Solid, points: Array, hull: ConvexHull, limit: float, scratch: Scratch
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
    held, stack = np.zeros(4, np.int64), np.zeros(64, np.int64)
    contractions(
        points,
        faces,
        planes,
        areas,
        edges,
        starts,
        order // 3,
        limit,
        *solid.tree,
        *scratch,
        held,
        stack,
        costs,
        places,
    )
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
    many = len(points) > BATCH_ABOVE_CORNERS
    good = np.flatnonzero(np.isfinite(costs))
    good = good[np.argsort(costs[good], kind="stable")]
    allowed = max(1, int(BATCH_SHARE * len(points))) if many else 1
    cheap = set(good[: max(1, len(good) // 3)].tolist())
    touched, keep = np.zeros(len(points), bool), np.ones(len(points), bool)
    made: list[Array] = []
    stack = np.zeros(64, np.int64)
    for e in good:
        if made and e not in cheap:  # dear ones only where no cheap one can be had
            break
        a, b = edges[e]
        name = points[a].tobytes(), points[b].tobytes()
        if touched[a] or touched[b] or name in refused:
            continue
        if star_is_far(points, hull.simplices, a, b, places[e], limit, *solid.depths, *solid.tree, stack):
            refused.add(name)
            continue
        if not many:
            joined = np.vstack([np.delete(points, (a, b), axis=0), places[e]])
            larger = ConvexHull(joined)
            new = (larger.simplices == len(joined) - 1).any(axis=1)
            if not voids.meet(larger, limit) and faces_near(solid, joined[larger.simplices[new]], limit):
                return joined
            refused.add(name)
            continue
        around = hull.simplices[np.isin(hull.simplices, (a, b)).any(axis=1)]
        moved = np.where(np.isin(around, (a, b))[..., None], places[e], points[around])
        new = moved[np.isin(around, (a, b)).sum(axis=1) == 1]
        if not faces_near(solid, new, limit) or _meets_between(points, around, a, b, places[e], limit, voids):
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
    return voids.meet(ConvexHull(np.vstack([np.delete(points, (a, b), axis=0), place])), limit)
