"""Whether a convex part stays near a solid: a quick look at samples of its surface, and a proof."""

import numpy as np
from scipy.spatial import ConvexHull

from kabo.geometry.kernels.polytope_corners import first_far
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


_SAMPLES = _halton(sum(LOOKS))


def _directions(many: int) -> Array:
    """Unit vectors (N, 3) in pairs of opposite ones, evenly: a spiral of golden turns, and its mirror image."""
    half = many // 2
    height, turn = (np.arange(half) + 0.5) / half, np.pi * (3.0 - np.sqrt(5.0)) * np.arange(half)
    across = np.sqrt(1.0 - height**2)
    upper = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    return np.vstack([upper, -upper])


EVEN = _directions(32)


def surface_samples(hull: ConvexHull) -> Array:
    """Points (280, 3) on the faces of a hull, evenly by area."""
    corners = hull.points[hull.simplices]
    areas = np.cumsum(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    )
    face = np.minimum(np.searchsorted(areas, _SAMPLES[:, 0] * areas[-1]), len(corners) - 1)
    root, t = np.sqrt(_SAMPLES[:, 1])[:, None], _SAMPLES[:, 2][:, None]
    return (1 - root) * corners[face, 0] + root * (1 - t) * corners[face, 1] + root * t * corners[face, 2]


def looks_near(solid: Solid, hull: ConvexHull, limit: float, glance: bool = False) -> bool:
    """Whether samples of the surface of a hull, few at a glance, are all within `limit` [m] of the solid: no proof."""
    return _far_sample(solid, hull, limit, LOOKS[:1] if glance else LOOKS) is None


def _far_sample(solid: Solid, hull: ConvexHull, limit: float, looks: tuple[int, ...] = LOOKS) -> Array | None:
    samples = np.ascontiguousarray(surface_samples(hull))
    stack, first = np.zeros(64, np.int64), 0
    for many in looks:
        far = int(first_far(samples[first : first + many], limit, *solid.tree, stack))
        if far >= 0:
            return np.asarray(samples[first + far])
        first += many
    return None


def proven_near(solid: Solid, part: Array, limit: float, most: int = MOST) -> bool | None:
    """Whether all of a convex part (V, 3) is within `limit` [m] of the solid: proven, refuted, or None: given up."""
    return judged(solid, part, limit, most)[0]


def judged(solid: Solid, part: Array, limit: float, most: int = MOST) -> tuple[bool | None, Array | None]:
    """As `proven_near`, and if it is refuted a point (3,) of the part that is farther away."""
    hull = ConvexHull(part)
    if (far := _far_sample(solid, hull, limit)) is not None:
        return False, far
    if solid.is_convex:  # the distance to a convex set is greatest at a corner
        distances = solid.outside_distances(part)
        worst = int(np.argmax(distances))
        return (True, None) if distances[worst] <= limit - 10 * FLAT else (False, part[worst])
    stack, limit = np.zeros(64, np.int64), limit * (1 - 1e-9)
    corner = int(first_far(np.ascontiguousarray(part), limit, *solid.tree, stack))
    if corner >= 0:
        return False, part[corner]
    corners = part[hull.simplices]
    cells = np.zeros((len(corners) + DEEP, 14))
    cells[: len(corners), :9] = corners.reshape(-1, 9)
    cells[: len(corners), 9:12] = part[hull.vertices].mean(axis=0)
    answer = int(reaches_beyond(cells, len(corners), limit, *solid.tree, stack, most))
    return {0: (True, None), 1: (False, cells[0, :3].copy())}.get(answer, (None, None))
