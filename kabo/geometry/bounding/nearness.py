"""Tests and proofs that a convex part stays near a solid: quick samples, then tetrahedra."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from kabo.arrays import Array
from kabo.geometry.bounding.containment import hull_of
from kabo.geometry.bounding.kernels.depth_octree import hull_is_far
from kabo.geometry.bounding.kernels.inner_tetrahedra import anchors_of
from kabo.geometry.bounding.kernels.protrusion import faces_reach_beyond, reaches_beyond
from kabo.geometry.bounding.kernels.union_depth import CONVEXITY_MARGIN
from kabo.geometry.triangles.solids import Solid

SIGHT_LINES = 80  # between two sets
SURFACE_SAMPLES = 280  # of a hull's surface
INTERIOR_SAMPLES = 400  # of a hull's interior
SPARE_STACK_ROWS = 200  # of the stack, beside the first tetrahedra
CLIMB_CANDIDATES = 80  # surface samples
CLIMB_STARTS = 4  # of these, the farthest from the solid
CLIMB_STEPS = 12  # of each climb
PLANE_ROUNDING = 1e-12  # [m] of points on the planes of a hull
MAX_FACE_PIECES = 24  # of a triangle, after which its proof is given up
MAX_TETRAHEDRA = 200_000  # after which a proof is given up


def _halton(count: int) -> Array:
    """Points (count, 4) that fill the unit cube evenly [Halton 1960]."""
    columns = []
    for base in (2, 3, 5, 7):
        index, value, share = np.arange(1, count + 1), np.zeros(count), 1.0
        while index.any():
            share /= base
            value += share * (index % base)
            index //= base
        columns.append(value)
    return np.column_stack(columns)


HALTON_POINTS = _halton(SURFACE_SAMPLES + INTERIOR_SAMPLES)


def _directions(many: int) -> Array:
    """Evenly distributed unit vectors (N, 3) in opposite pairs: a golden spiral and its mirror image."""
    half = many // 2
    height, turn = (np.arange(half) + 0.5) / half, np.pi * (3.0 - np.sqrt(5.0)) * np.arange(half)
    across = np.sqrt(1.0 - height**2)
    upper = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    return np.vstack([upper, -upper])


EVEN_DIRECTIONS = _directions(32)


def looks_near(solid: Solid, hull: ConvexHull, limit: float) -> bool:
    """Whether all sampled points of a hull are within `limit` [m] of the solid; True is no proof."""
    return _far_sample(solid, hull, limit) is None


def surface_samples(hull: ConvexHull) -> Array:
    """Points (80, 3) on the faces of a hull, evenly by area."""
    a, b, c = hull.points[hull.simplices].transpose(1, 0, 2)
    areas = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
    chosen = np.minimum(np.searchsorted(areas, HALTON_POINTS[:CLIMB_CANDIDATES, 0] * areas[-1]), len(areas) - 1)
    root, t = np.sqrt(HALTON_POINTS[:CLIMB_CANDIDATES, 1])[:, None], HALTON_POINTS[:CLIMB_CANDIDATES, 2][:, None]
    return np.asarray((1 - root) * a[chosen] + root * (1 - t) * b[chosen] + root * t * c[chosen])


def _far_sample(solid: Solid, hull: ConvexHull, limit: float) -> Array | None:
    """A sample (3,) of a hull's surface or interior that is too far from the solid; None if there is none."""
    at, sums = hull.points.mean(axis=0), np.empty(len(hull.simplices))
    far = hull_is_far(hull.points, hull.simplices, HALTON_POINTS, SURFACE_SAMPLES, sums, at, limit, solid.arrays)
    return at if far else None


def climbed(solid: Solid, hull: ConvexHull, point: Array) -> tuple[Array, float]:
    """A point (3,) of the hull farther from the solid, found by moving `point` inside the hull; and its distance [m]."""
    depth = float(solid.outside_distances(point[None])[0])
    step = depth
    for _ in range(CLIMB_STEPS):
        around = point + step * EVEN_DIRECTIONS
        around = around[(around @ hull.equations[:, :3].T + hull.equations[:, 3] <= -PLANE_ROUNDING).all(axis=1)]
        depths = solid.outside_distances(around) if len(around) else np.zeros(1)
        if depths.max() > depth:
            point, depth = around[int(np.argmax(depths))], float(depths.max())
        else:
            step *= 0.5
    return point, depth


def _far_summit(solid: Solid, hull: ConvexHull, limit: float) -> Array | None:
    """A point (3,) of a hull too far from the solid, found by climbing from the farthest surface samples; or None."""
    samples = surface_samples(hull)
    depths = solid.outside_distances(samples)
    middle = hull.points.mean(axis=0)
    for start in np.argsort(-depths, kind="stable")[:CLIMB_STARTS]:
        if depths[start] > 0.5 * limit:
            point, depth = climbed(solid, hull, middle + (1.0 - 1e-6) * (samples[start] - middle))
            if depth > limit:
                return point
    return None


def proven_near(solid: Solid, part: Array, limit: float, most: int = MAX_TETRAHEDRA) -> bool | None:
    """True if a convex part (V, 3) is proven within `limit` [m] of the solid, False if refuted, None if undecided."""
    return near_or_witness(solid, part, limit, most)[0]


def near_or_witness(
    solid: Solid, part: Array, limit: float, most: int = MAX_TETRAHEDRA
) -> tuple[bool | None, Array | None]:
    """The answer of `proven_near`; if it is False, also a point (3,) of the part that is farther away."""
    room = corner_limit(solid, limit)
    if room > 0.0:
        distances = solid.outside_distances(part)
        worst = int(np.argmax(distances))
        if distances[worst] <= room:
            return True, None
        if distances[worst] > limit:
            return False, part[worst]
    hull = hull_of(part)
    if (far := _far_sample(solid, hull, limit)) is not None:
        return False, far
    if (far := _far_summit(solid, hull, limit)) is not None:
        return False, far
    arrays, limit = solid.arrays, limit * (1 - 1e-9)
    piece = piece_around(part[hull.vertices].mean(axis=0))
    points = np.vstack([part, piece.middle])
    anchors = np.empty_like(points)
    corner = int(anchors_of(points, limit, piece.middle, arrays, anchors))
    if corner >= 0:
        return False, points[corner]
    corners = np.column_stack([hull.simplices, np.full(len(hull.simplices), len(part))])
    cells = np.zeros((len(corners) + SPARE_STACK_ROWS, 26))
    cells[: len(corners), :12] = points[corners].reshape(-1, 12)
    cells[: len(corners), 14:] = anchors[corners].reshape(-1, 12)
    answer = int(reaches_beyond(cells, len(corners), limit, arrays, most, piece))
    return {0: (True, None), 1: (False, cells[0, :3].copy())}.get(answer, (None, None))


def corner_limit(solid: Solid, limit: float) -> float:
    """The distance [m] from a nearly convex solid within which corners prove a convex part within `limit`; or -inf.

    The distance to the solid's convex hull is greatest at a corner, and the solid is nowhere far from its hull.
    """
    return limit - solid.convexity_error - CONVEXITY_MARGIN


def faces_near(solid: Solid, faces: Array, limit: float, middle: Array | None = None) -> bool:
    """Whether a short proof shows that triangles (N, 3, 3) are within `limit` [m] of the solid; False refutes nothing.

    They are faces of a part around `middle` (3,); None: around their own.
    """
    room = corner_limit(solid, limit)
    if room > 0.0 and (solid.outside_distances(faces.reshape(-1, 3)) <= room).all():
        return True
    cells = np.zeros((len(faces) + SPARE_STACK_ROWS, 20))
    cells[: len(faces), :9] = faces.reshape(-1, 9)
    cells[: len(faces), 11:] = np.inf  # no anchors yet
    limit *= 1 - 1e-9
    most, piece = MAX_FACE_PIECES * len(faces), piece_around(faces.mean(axis=(0, 1)) if middle is None else middle)
    answer = faces_reach_beyond(cells, len(faces), limit, solid.arrays, most, piece)
    return int(answer) == 0


class Piece(NamedTuple):
    """Room for the piece of a part that a kernel looks at, and a point around which the part lies."""

    anchors: Array  # (4, 3) [m]
    planes: Array  # (4, 4)
    middle: Array  # (3,) [m]


def piece_around(middle: Array) -> Piece:
    """Room for pieces of a part around a point (3,)."""
    return Piece(np.empty((4, 3)), np.empty((4, 4)), middle)


class Voids:
    """Points known to be far outside a solid, which no hull near the solid may contain.

    They reveal closed hollows, which samples on the hull's surface miss.
    """

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        self._points, self._depths = np.empty((0, 3)), np.empty(0)

    def meet(self, hull: ConvexHull, limit: float) -> bool:
        """Whether a hull contains a stored point that is farther than `limit` [m] from the solid."""
        points = self.between(hull.min_bound, hull.max_bound, limit)
        return bool((points @ hull.equations[:, :3].T + hull.equations[:, 3] <= 0.0).all(axis=1).any())

    def between(self, low: Array, high: Array, limit: float) -> Array:
        """The stored points (N, 3) in the box from `low` to `high` that are farther than `limit` [m] from the solid."""
        chosen = (self._depths > limit) & ((self._points >= low) & (self._points <= high)).all(axis=1)
        return np.asarray(self._points[chosen])

    def add(self, point: Array, hull: ConvexHull) -> None:
        """Stores a point (3,) of a hull outside the solid, after moving it inside the hull away from the solid."""
        point, depth = climbed(self.solid, hull, point)
        self._points, self._depths = np.vstack([self._points, point]), np.r_[self._depths, depth]
