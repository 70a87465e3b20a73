"""Encloses a convex point set by a polytope with few vertices, an intersection of few half-spaces.

`enclosing_polytope` may use any method that encloses, since callers prove how far the result sticks out.
"""

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from kabo.arrays import Array, Integers

MAX_CORNERS = 24  # of a polytope, unless callers say another number
FACE_WIDENING = 2e-9  # [m] by which every face moves outwards at least: far more than all rounding
CONTAINMENT_MARGIN = 5e-10  # [m] by which every point must then lie inside
MAX_LEADING_PLANES, INITIAL_PLANES = 160, 48  # half-spaces to choose from, and chosen first
TURN_ANGLES = (0.2, 0.1, 0.1, 0.05, 0.02)  # [rad] tried in turn


def hull_planes(points: Array) -> Array:
    """The distinct half-spaces (H, 4) of the convex hull of points (P, 3): n·x <= d with |n| = 1."""
    equations = ConvexHull(points).equations
    return np.unique(np.round(np.column_stack([equations[:, :3], -equations[:, 3]]), 12), axis=0)


def _leading_planes(points: Array) -> Array:
    """At most 160 half-spaces of the hull: those of large faces first, none within a few degrees of another."""
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    normals = hull.equations[np.argsort(-np.round(areas / areas.max(), 6), kind="stable"), :3]
    near, chosen = np.cos(np.radians(6.0)), np.empty((0, 3))
    while len(chosen) == 0 or len(chosen) > MAX_LEADING_PLANES:
        chosen, near = np.empty((0, 3)), np.cos(1.3 * np.arccos(near)) if len(chosen) else near
        for normal in normals:
            if not (chosen @ normal > near).any():
                chosen = np.vstack([chosen, normal])
                if len(chosen) > MAX_LEADING_PLANES:
                    break
    return np.column_stack([chosen, (points @ chosen.T).max(axis=0)])


def solid_points(points: Array, thickness: float) -> Array:
    """The corners of the points' hull; a flat set is first made `thickness` [m] thick, so that it has an interior."""
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False) / np.sqrt(len(points))
    if len(points) < 4 or spread[2] < thickness:
        shifts = thickness * np.vstack([np.eye(3), -np.eye(3)])
        points = (points[:, None] + shifts[None]).reshape(-1, 3)
    corners: Array = points[np.sort(ConvexHull(points).vertices)]
    return corners


def enclosing_polytope(points: Array, enough: float, most: int = MAX_CORNERS) -> Array:
    """The vertices (V <= most, 3) of a convex polytope that contains all points (P, 3), proven with a margin.

    Half-spaces of the points' hull are added where the polytope sticks out most, until the gain is small; then
    half-spaces whose removal changes the polytope least are dropped one by one. The remaining ones are rotated
    slightly while the polytope becomes tighter, unless it is within `enough` [m] of the hull already.

    Raises:
        ValueError: no polytope could be proven to contain the points (they are not finite, or span no volume).
    """
    hull = ConvexHull(points)
    inside = points[hull.vertices].mean(axis=0)
    if len(hull.vertices) <= most:
        vertices = points[hull.vertices]
    else:
        points = points[hull.vertices]
        measure = _leading_planes(points)
        chosen = _drop(measure, _take(measure, inside, INITIAL_PLANES), inside, most)
        planes = measure[chosen]
        if _worst(measure, chosen, inside)[0] > enough:
            planes = _turn(planes, points, measure, inside, most)
        vertices = _vertices(planes, inside)[0]
    vertices = widened(vertices)
    if not contains_proven(vertices, points):
        raise ValueError("the polytope could not be proven to contain the points")
    return vertices


def widened(vertices: Array) -> Array:
    """The vertices, moved away from their mean until every face has moved outwards by `FACE_WIDENING`."""
    middle = vertices.mean(axis=0)
    equations = ConvexHull(vertices).equations
    inner = float(-(equations[:, :3] @ middle + equations[:, 3]).max())
    wider: Array = middle + (vertices - middle) * (1.0 + FACE_WIDENING / inner)
    return wider


def contains_proven(vertices: Array, points: Array) -> bool:
    """Whether the hull of the vertices contains all points with a margin above rounding."""
    try:
        equations = ConvexHull(vertices).equations
    except QhullError:
        return False
    return bool((points @ equations[:, :3].T + equations[:, 3] <= -CONTAINMENT_MARGIN).all())


def _vertices(planes: Array, inside: Array) -> tuple[Array, list[Integers]]:
    """The vertices of a polytope, and the half-spaces that meet in each; none if it is unbounded."""
    try:
        with np.errstate(divide="ignore", invalid="ignore"):  # an unbounded set has vertices at infinity
            found = HalfspaceIntersection(np.column_stack([planes[:, :3], -planes[:, 3]]), inside)
    except QhullError:
        return np.empty((0, 3)), []
    if not (found.dual_equations[:, -1] < -1e-9).all():
        return np.empty((0, 3)), []
    rounded = np.round(found.intersections, 10)
    first = np.sort(np.unique(rounded, axis=0, return_index=True)[1])
    return found.intersections[first], [np.asarray(found.dual_facets[i]) for i in first]


def _worst(planes: Array, chosen: Integers, inside: Array) -> tuple[float, int]:
    """How far the polytope of the chosen half-spaces exceeds the others, and the half-space that it exceeds most."""
    vertices = _vertices(planes[chosen], inside)[0]
    if len(vertices) == 0:
        return np.inf, -1
    sticking = (vertices @ planes[:, :3].T - planes[:, 3]).max(axis=0)
    worst = int(np.argmax(sticking))
    return float(sticking[worst]), worst


def _take(planes: Array, inside: Array, many: int) -> Integers:
    """The half-spaces of an approximation: six around, then always the one that the polytope exceeds most."""
    axes = np.linalg.svd(planes[:, :3] - planes[:, :3].mean(axis=0), full_matrices=False)[2]
    chosen = list(dict.fromkeys(int(np.argmax(planes[:, :3] @ axis)) for axis in (*axes, *-axes)))
    size = float((planes[:, 3] - planes[:, :3] @ inside).max())
    far = np.vstack([np.eye(3), -np.eye(3)])
    framed = np.vstack([planes, np.column_stack([far, far @ inside + 4 * size])])
    frame = np.arange(len(planes), len(framed))
    while len(chosen) < min(many, len(planes)):
        sticking, plane = _worst(framed, np.r_[chosen, frame], inside)
        if sticking <= 1e-4 * size or plane in chosen or plane < 0:
            break
        chosen.append(plane)
    return np.array(chosen)


def _drop(planes: Array, chosen: Integers, inside: Array, most: int) -> Integers:
    """The half-spaces left after dropping some until the polytope has at most `most` vertices."""
    costs: dict[int, float] = {}
    while True:
        vertices, meeting = _vertices(planes[chosen], inside)
        if len(vertices) <= most:
            return chosen
        for index, plane in enumerate(chosen):
            if int(plane) not in costs:
                costs[int(plane)] = _worst(planes, np.delete(chosen, index), inside)[0]
        least = min(costs, key=lambda plane: (costs[plane], plane))
        index = int(np.flatnonzero(chosen == least)[0])
        for corner in meeting:
            if index in corner:
                for neighbour in corner:
                    costs.pop(int(chosen[neighbour]), None)
        costs.pop(least, None)
        chosen = np.delete(chosen, index)


def _turn(planes: Array, points: Array, measure: Array, inside: Array, most: int) -> Array:
    """The half-spaces after small rotations about the points they touch, as long as the polytope gets tighter."""
    best = _badness(planes, measure, inside, most)
    for step in TURN_ANGLES:
        for index in range(len(planes)):
            normal = planes[index, :3]
            first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
            second = np.cross(normal, first)
            for direction in (first, -first, second, -second):
                turned = normal + step * direction / np.linalg.norm(direction)
                turned /= np.linalg.norm(turned)
                other = planes.copy()
                other[index] = [*turned, (points @ turned).max()]
                reached = _badness(other, measure, inside, most)
                if reached < best:
                    best, planes = reached, other
    return planes


def _badness(planes: Array, measure: Array, inside: Array, most: int) -> float:
    """The measure that `_turn` minimises: a mean of the vertices' excess, dominated by the farthest vertices."""
    vertices = _vertices(planes, inside)[0]
    if not 0 < len(vertices) <= most:
        return np.inf
    return float((np.maximum((vertices @ measure[:, :3].T - measure[:, 3]).max(axis=1), 0.0) ** 6).sum())
