"""Whether a convex part stays near a solid: a quick look at samples of its surface, and a proof."""

import numpy as np
from scipy.spatial import ConvexHull

from kabo.geometry.kernels.polytope_corners import all_near
from kabo.geometry.kernels.protrusion import reaches_beyond
from kabo.geometry.parts import Array
from kabo.geometry.solids import FLAT, Solid

LOOKS = (40, 120, 120)  # samples of the surface, in groups: the first that is too far ends the look
DEEP = 200  # rows of the stack on top of the first tetrahedra
MOST = 200_000  # tetrahedra after which a proof is given up


def _halton(count: int) -> Array:
    """Points (count, 3) that fill the unit cube evenly [Halton 1960]."""
    columns = []
    for base in (2, 3, 5):
        index, value, share = np.arange(1, count + 1), np.zeros(count), 1.0
        while index.any():
            share /= base
            value += share * (index % base)
            index //= base
        columns.append(value)
    return np.column_stack(columns)


_EVEN = _halton(sum(LOOKS))


def surface_samples(hull: ConvexHull) -> Array:
    """Points (280, 3) on the faces of a hull, evenly by area."""
    corners = hull.points[hull.simplices]
    areas = np.cumsum(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    )
    face = np.minimum(np.searchsorted(areas, _EVEN[:, 0] * areas[-1]), len(corners) - 1)
    root, t = np.sqrt(_EVEN[:, 1])[:, None], _EVEN[:, 2][:, None]
    return (1 - root) * corners[face, 0] + root * (1 - t) * corners[face, 1] + root * t * corners[face, 2]


def looks_near(solid: Solid, hull: ConvexHull, limit: float) -> bool:
    """Whether samples of the surface of a hull are all within `limit` [m] of the solid: no proof."""
    samples = np.ascontiguousarray(surface_samples(hull))
    stack, first = np.zeros(64, np.int64), 0
    for many in LOOKS:
        if not all_near(samples[first : first + many], limit, *solid.tree, stack):
            return False
        first += many
    return True


def proven_near(solid: Solid, part: Array, limit: float, most: int = MOST) -> bool | None:
    """Whether all of a convex part (V, 3) is within `limit` [m] of the solid: proven, refuted, or None: given up."""
    hull = ConvexHull(part)
    if not looks_near(solid, hull, limit):
        return False
    if solid.is_convex:  # the distance to a convex set is greatest at a corner
        return bool((solid.outside_distances(part) <= limit - 10 * FLAT).all())
    if not all_near(np.ascontiguousarray(part), limit * (1 - 1e-9), *solid.tree, np.zeros(64, np.int64)):
        return False
    corners = part[hull.simplices]
    cells = np.zeros((len(corners) + DEEP, 14))
    cells[: len(corners), :9] = corners.reshape(-1, 9)
    cells[: len(corners), 9:12] = part[hull.vertices].mean(axis=0)
    answer = int(
        reaches_beyond(cells, len(corners), limit * (1 - 1e-9), *solid.tree, np.zeros(64, np.int64), most)
    )
    return {0: True, 1: False}.get(answer)
