"""Groups cells into few convex sets: grows sets while their hulls stay near the solid, then chooses a cover.

Sets may overlap. The choice is a set cover problem, solved to optimality by branch and bound (scipy's HiGHS), so
that the same cells give the same sets.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.containment import hull_of
from kabo.geometry.bounding.kernels.depth_octree import between_is_far
from kabo.geometry.bounding.nearness import (
    HALTON_POINTS,
    PLANE_ROUNDING,
    SIGHT_LINES,
    Voids,
    looks_near,
    near_or_witness,
)
from kabo.geometry.triangles.solids import Solid

Members = tuple[int, ...]
NEIGHBOURS_COMPARED = 12  # nearest neighbours, of which the one that adds the least empty volume is taken
NEIGHBOURS_REFRESHED = 4  # of these, whose empty volume is computed again
THINNING_SHARE = 0.5  # of the limit: accuracy of hulls in that comparison
RECEIVING_NEIGHBOURS = 8  # that may take a cell of another set
MAX_REGROWTHS = 6  # of a set whose hull was refuted
HULL_PROOF_TETRAHEDRA = 4_000  # of a proof, after which a hull counts as not refuted


class Growth:
    """Grows sets of cells whose common convex hull stays near a solid, as far as samples show."""

    def __init__(self, solid: Solid, limit: float, points: Sequence[Array], voids: Voids) -> None:
        self.solid, self.limit, self._voids = solid, limit, voids
        self.points = [thinned(each, 0.05 * limit) for each in points]
        self._few = [thinned(each, THINNING_SHARE * limit) for each in self.points]
        self._volumes = [float(hull_of(each).volume) for each in self._few]
        self._middles = np.array([each.mean(axis=0) for each in self.points])
        self._low = np.array([each.min(axis=0) for each in self.points])
        self._high = np.array([each.max(axis=0) for each in self.points])
        low, high = self._low - 1e-2 * limit, self._high + 1e-2 * limit
        self._touching: NDArray[np.bool_] = np.asarray(
            (low[:, None] <= high[None]).all(axis=2) & (low[None] <= high[:, None]).all(axis=2)
        )
        self._joints: dict[Members, bool] = {}
        self._refuted: dict[Members, bool] = {}

    def from_seed(self, seed: int, nearest: bool, prices: Array | None = None) -> Members:
        """The set grown from cell `seed`, adding its nearest neighbour, or the one that adds the least empty volume.

        If prices (C,) are given, cells with a positive price are added before others. If a point of the final hull
        is proven to lie far from the solid, the set is grown again so that its hull excludes this point.
        """
        for _ in range(MAX_REGROWTHS):
            members = self._grown(seed, nearest, prices)
            if len(members) == 1:
                break
            if members not in self._refuted:
                self._refuted[members] = self._refutes(members)
            if not self._refuted[members]:
                break
        return members

    def _refutes(self, members: Members) -> bool:
        """Whether a point of the set's hull is found that is far from the solid; it is then a void."""
        hull = hull_of(np.vstack([self.points[j] for j in members]))
        far = near_or_witness(self.solid, hull.points, self.limit, HULL_PROOF_TETRAHEDRA)[1]
        if far is not None:
            self._voids.add(far, hull)
        return far is not None

    def _grown(self, seed: int, nearest: bool, prices: Array | None) -> Members:
        members, hull = [seed], hull_of(self.points[seed])
        compared = np.zeros(len(self.points), np.int64)  # with how many of the members a cell is known to fit
        refused = np.zeros(len(self.points), bool)
        known: dict[int, float] = {}  # the empty volume that each cell would add
        while True:
            refused[members] = True
            touching = np.logical_or.reduce(self._touching[members], axis=0)
            near = np.flatnonzero(touching & ~refused).tolist()
            candidates = [j for j in near if self._fits_all(members, j, compared, refused)]
            if not candidates:
                return tuple(sorted(members))
            corners = hull.points[hull.vertices]
            away = np.linalg.norm(self._middles[candidates] - corners.mean(axis=0), axis=1)
            candidates = [candidates[i] for i in np.argsort(np.round(away, 9), kind="stable")]
            if not nearest:
                some = self._least_in_vain(members, candidates[:NEIGHBOURS_COMPARED], known)
                candidates = some + candidates[NEIGHBOURS_COMPARED:]
            if prices is not None:
                candidates.sort(key=lambda j: prices[j] <= 0.0)
            for j in candidates:
                larger = hull_of(np.vstack([corners, self.points[j]]))
                if self._looks_near(larger):
                    hull = larger
                    members.append(j)
                    members += self._swallowed(hull, members)
                    break
                refused[j] = True

    def _least_in_vain(self, members: list[int], candidates: list[int], known: dict[int, float]) -> list[int]:
        """The candidates in order of the empty volume that they add to the hull, estimated from few points.

        Estimates from before the hull grew are updated for the best of them only.
        """
        hull = hull_of(np.vstack([self._few[i] for i in members]))
        corners = hull.points[hull.vertices]
        best = sorted((j for j in candidates if j in known), key=lambda j: (known[j], candidates.index(j)))
        for j in [j for j in candidates if j not in known] + best[:NEIGHBOURS_REFRESHED]:
            joined = hull_of(np.vstack([corners, self._few[j]]))
            known[j] = round(1.0 - (hull.volume + self._volumes[j]) / float(joined.volume), 9)
        return sorted(candidates, key=lambda j: (known[j], candidates.index(j)))

    def with_one_less(self, sets: Sequence[Members]) -> list[Members]:
        """Disjoint sets of the same cells, as few as are found by distributing the cells of a set to its neighbours."""
        owned: set[int] = set()
        groups: list[list[int]] = []
        for members in sorted(sets, key=lambda members: (-len(members), members)):
            groups.append([i for i in members if i not in owned])
            owned |= set(members)
        groups = [group for group in groups if group]
        fewer: list[list[int]] | None = groups
        while fewer is not None:
            groups = fewer
            order = sorted(range(len(groups)), key=lambda a: (len(groups[a]), groups[a]))
            fewer = next((less for a in order if (less := self._given_away(groups, a)) is not None), None)
        return [tuple(sorted(group)) for group in groups]

    def _given_away(self, groups: list[list[int]], giver: int) -> list[list[int]] | None:
        """The groups after one of them was dissolved into the others; None if this is impossible."""
        others = [list(group) for index, group in enumerate(groups) if index != giver]
        for i in groups[giver]:
            touched = [b for b, group in enumerate(others) if self._touching[i, group].any()]
            middles = [self._middles[others[b]].mean(axis=0) for b in touched]
            away = [float(np.round(np.linalg.norm(middle - self._middles[i]), 9)) for middle in middles]
            for b in [touched[k] for k in np.argsort(away, kind="stable")][:RECEIVING_NEIGHBOURS]:
                if self._joint(tuple(sorted([*others[b], i]))):
                    others[b].append(i)
                    break
            else:
                return None
        return others

    def _joint(self, members: Members) -> bool:
        """Whether the hull of some cells appears near the solid, or did when last tested; for two cells, along lines."""
        if members not in self._joints:
            if len(members) == 2:
                one, other = (self.points[j] for j in members)
                self._joints[members] = not between_is_far(
                    one, other, HALTON_POINTS[:SIGHT_LINES], self.limit, self.solid.arrays
                )
            else:
                hull = hull_of(np.vstack([self.points[j] for j in members]))
                self._joints[members] = self._looks_near(hull)
        return self._joints[members]

    def _looks_near(self, hull: ConvexHull) -> bool:
        return not self._voids.meet(hull, self.limit) and looks_near(self.solid, hull, self.limit)

    def _fits_all(self, members: list[int], j: int, compared: Integers, refused: NDArray[np.bool_]) -> bool:
        known, compared[j] = compared[j], len(members)
        if all(self._joint((min(i, j), max(i, j))) for i in members[known:]):
            return True
        refused[j] = True
        return False

    def _swallowed(self, hull: ConvexHull, members: list[int]) -> list[int]:
        """The cells inside a hull that are not members yet."""
        low, high = hull.min_bound - PLANE_ROUNDING, hull.max_bound + PLANE_ROUNDING
        within = ((self._low >= low) & (self._high <= high)).all(axis=1)
        within[members] = False
        planes = hull.equations
        return [
            int(j)
            for j in np.flatnonzero(within)
            if (self.points[j] @ planes[:, :3].T + planes[:, 3] <= PLANE_ROUNDING).all()
        ]


def thinned(points: Array, tolerance: float) -> Array:
    """Some corners of the points' convex hull, such that every point lies within `tolerance` [m] of their hull."""
    points = points[np.sort(hull_of(points).vertices)]
    axes = np.array(
        [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) > (0, 0, 0)]
    )
    heights = points @ axes.T
    chosen = np.unique(np.r_[heights.argmin(axis=0), heights.argmax(axis=0)])
    while len(chosen) < len(points):
        try:
            planes = hull_of(points[chosen]).equations
        except QhullError:  # the extremes lie in a plane
            return points
        beyond = points @ planes[:, :3].T + planes[:, 3]
        far = np.unique(beyond.argmax(axis=0)[beyond.max(axis=0) > tolerance])
        if not len(far):
            break
        chosen = np.union1d(chosen, far)
    corners: Array = points[chosen]
    return corners


def prices_of(cells: int, sets: Sequence[Members], costs: Sequence[float]) -> Array:
    """The prices (C,) of covering each cell: the dual solution of the linear relaxation of the cheapest cover.

    Only a set whose cells have a total price above its cost can make the cover cheaper [Dantzig and Wolfe 1960].
    """
    from scipy.optimize import linprog  # 0.1 s, needed only where a decomposition is made

    holds = np.zeros((cells, len(sets)))
    for column, members in enumerate(sets):
        holds[list(members), column] = 1.0
    found = linprog(np.asarray(costs, np.float64), A_ub=-holds, b_ub=-np.ones(cells), method="highs-ds")
    if found.x is None:
        return np.zeros(cells)
    prices: Array = -np.asarray(found.ineqlin.marginals, np.float64)
    rounded: Array = prices.round(9)
    return rounded


def fewest_sets(cells: int, sets: Sequence[Members], costs: Sequence[float]) -> list[int]:
    """The indices of the sets that cover all cells at the least total cost."""
    from scipy.optimize import Bounds, LinearConstraint, milp  # as in `prices_of`

    holds = np.zeros((cells, len(sets)))
    for column, members in enumerate(sets):
        holds[list(members), column] = 1.0
    found = milp(
        np.asarray(costs, np.float64),
        constraints=LinearConstraint(holds, lb=1.0),
        integrality=np.ones(len(sets)),
        bounds=Bounds(0.0, 1.0),
        options={"node_limit": 2000},
    )
    if found.x is None:
        return list(range(len(sets)))
    return [int(i) for i in np.flatnonzero(found.x > 0.5)]
