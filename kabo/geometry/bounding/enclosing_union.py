"""Encloses a solid by few convex parts with few corners: cuts it into cells, groups the cells, encloses each group.

Covering needs no sampling: the cells contain the solid by construction, and every cell is proven to lie inside one
part. A part may extend into other cells, since its distance to the whole solid is what is proven.
"""

import logging
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.geometry.bounding.containment import CONTAINMENT_MARGIN, hull_of
from kabo.geometry.bounding.covering import Growth, Members, fewest_sets, prices_of
from kabo.geometry.bounding.nearness import Voids, corner_limit, near_or_witness, proven_near
from kabo.geometry.bounding.simplification import enclosing_part
from kabo.geometry.bounding.splitting import HulledCell, TooManyCells, cut_in_two, split_solid
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.triangles.solids import Solid
from kabo.phases import phase

_LOG = logging.getLogger("kabo.geometry")
CELL_SHARE = 0.4  # of epsilon: deviation of a cell's hull
MANY_CELLS = 200  # above which cells may deviate by COARSE_CELL_SHARE
COARSE_CELL_SHARE = 0.7  # of epsilon: the same, tried first
MAX_CELLS_TO_REFINE = 120  # coarse cells above which none are refined
FEW_PARTS_WORTH = 10.0  # of one part, in corners, above which cells are as large as they may be
LARGE_CELL_SHARES = 0.95, 0.6  # of epsilon: deviation of such a cell's hull, and of its lines of sight
# Of epsilon, for hulls of sets, with whether the nearest cells are added first.
JOINED_SHARES = ((0.8, False), (0.96, False), (0.96, True))
SINGLE_GROWTH_ABOVE_CELLS = 110  # above which only the last of these is tried
PRICING_ABOVE_CELLS = 150  # above which long cells are cut, and further sets grown by prices
LONG_CELL_EPSILONS = 9.5  # length of a cell above which it is then cut, up to MANY_CELLS
CELL_WEIGHTS = (0.01, -0.002)  # of a cell, if a set weighs 1: prefers small sets, and large ones
MAX_CELLS = 1000  # a mesh that needs more is refused
PRICING_ROUNDS = 4  # of growing sets by prices
MIN_PRICE_GAIN = 1e-6  # of the cost of a set
SETS_PER_CELL = 2  # of one kind, after which no set is grown from a cell
CHOICE_ROUNDS = 6  # of choosing sets by the actual costs of their parts
SPARE_PARTS_RATIO = 1.5  # parts made for each one used, after which no better choice is sought
MAX_CORNER_CUTS = 8  # of a cell whose part has too many corners
MAX_PROOF_CUTS = 24  # of a cell whose part cannot be proven
TIGHTER_SHARES = (0.02, 0.25)  # between a part's deviation and epsilon: tried as tighter bounds
CORNERS_PER_PART = 2.0  # worth of one part, in corners, where corners are to be few


class Aims(NamedTuple):
    """What the parts of a cover shall be like."""

    tolerance: float  # [m] the greatest permitted distance of their points from the solid
    corners: int | None = None  # the desired greatest number of corners of a part; None: no limit
    strict: bool = False  # whether a part with more corners is worse than any number of parts
    worth: float = CORNERS_PER_PART  # of one part, in corners

    @property
    def few_parts(self) -> bool:
        """Whether few parts matter more than few corners."""
        return self.worth > FEW_PARTS_WORTH


class Undecided(Exception):
    """Raised if a cell cannot be enclosed within epsilon, however small it is cut."""


def cells_of(
    solid: Solid, aims: Aims, begun: Sequence[HulledCell] | None = None, most: int | None = None
) -> list[HulledCell]:
    """Cells that together contain the solid, with convex hulls that stay near it as far as samples show.

    Args:
        begun: cells whose content is to be covered, instead of the whole solid.
        most: the greatest number of cells; None: a thousand.

    Raises:
        TooManyCells: so many cells are not enough.
    """
    most, epsilon = MAX_CELLS if most is None else most, aims.tolerance
    if aims.few_parts:
        share, sight = LARGE_CELL_SHARES
        return split_solid(solid, share * epsilon, most, sight * epsilon, begun)
    cells = split_solid(solid, COARSE_CELL_SHARE * epsilon, most, CELL_SHARE * epsilon, begun)
    if len(cells) <= MAX_CELLS_TO_REFINE:
        with suppress(TooManyCells):
            cells = split_solid(solid, CELL_SHARE * epsilon, min(MANY_CELLS, most), CELL_SHARE * epsilon, cells)
    return _shorter(solid, cells, epsilon) if len(cells) > PRICING_ABOVE_CELLS else cells


def _shorter(solid: Solid, cells: list[HulledCell], epsilon: float) -> list[HulledCell]:
    """The cells after the longest ones were cut across, so that neighbours can take over parts of them."""
    cells = list(cells)
    while len(cells) < MANY_CELLS:
        lengths = [float(np.round(np.ptp(cell.points, axis=0).max(), 9)) for cell in cells]
        longest = int(np.argmax(lengths))
        if lengths[longest] <= LONG_CELL_EPSILONS * epsilon:
            break
        cells[longest : longest + 1] = cut_in_two(solid, cells[longest], CELL_SHARE * epsilon, None)
    return cells


def enclosing_union(solid: Solid, cells: Sequence[HulledCell], aims: Aims) -> Cover:
    """Parts that enclose all cells of a solid, each part proven within the tolerance of the solid.

    Raises:
        Undecided: a cell cannot be enclosed.
    """
    cells, epsilon = list(cells), aims.tolerance
    voids = Voids(solid)
    sets = _sets(solid, cells, epsilon, voids)
    made: dict[Members, Array | None] = {}
    with phase("choosing parts", log=_LOG):
        chosen = _chosen(solid, cells, sets, made, aims, voids)
    needed = {members: set(members) for members in chosen}
    parts = {members: part for members in chosen if (part := made[members]) is not None}
    for members in chosen:
        large = aims.corners is not None and members in parts and len(parts[members]) > aims.corners
        if members not in parts or (large and len(members) == 1):
            parts.pop(members, None)
            for hulled, part in _in_smaller_cells(solid, cells[members[0]], aims, voids):
                cells.append(hulled)
                name = (len(cells) - 1,)
                parts[name], needed[name] = part, set(name)
            del needed[members]
    live = sorted(set().union(*needed.values()))
    with phase("shrinking parts", log=_LOG):
        parts = _shrunk(solid, cells, live, parts, needed, epsilon, voids)
    if not _covers(cells, live, list(parts.values())):
        raise Undecided
    ordered = sorted(parts.values(), key=lambda part: tuple(part.mean(axis=0)))
    return Cover(tuple(ordered), tuple(deviation(solid, part, epsilon) for part in ordered), epsilon)


def _sets(solid: Solid, cells: list[HulledCell], epsilon: float, voids: Voids) -> list[Members]:
    """Sets of cells whose hulls appear near the solid: grown from every cell, and every cell alone."""
    found: set[Members] = {(i,) for i in range(len(cells))}
    growth: Growth | None = None
    for share, nearest in JOINED_SHARES if len(cells) <= SINGLE_GROWTH_ABOVE_CELLS else JOINED_SHARES[-1:]:
        if growth is None or growth.limit != share * epsilon:
            growth = Growth(solid, share * epsilon, [cell.points for cell in cells], voids)
        found |= _grown(growth, len(cells), nearest)
        sets = sorted(found)
        for weight in CELL_WEIGHTS:
            costs = [1.0 + weight * len(members) for members in sets]
            found |= set(growth.with_one_less([sets[i] for i in fewest_sets(len(cells), sets, costs)]))
        for _ in range(PRICING_ROUNDS if len(cells) > PRICING_ABOVE_CELLS else 0):
            before = len(found)
            found |= _priced(growth, len(cells), sorted(found), nearest)
            if len(found) == before:
                break
    return sorted(found)


def _priced(growth: Growth, cells: int, sets: list[Members], nearest: bool) -> set[Members]:
    """Sets that reduce the cost of the relaxed cover, grown from the cells with the highest prices."""
    prices = prices_of(cells, sets, [1.0] * len(sets))
    found: set[Members] = set()
    held = np.zeros(cells, np.bool_)
    for i in np.argsort(-prices, kind="stable"):
        if prices[i] > 0.0 and not held[i]:
            members = growth.from_seed(int(i), nearest, prices)
            held[list(members)] = True
            if prices[list(members)].sum() > 1.0 + MIN_PRICE_GAIN:
                found.add(members)
    return found


def _grown(growth: Growth, cells: int, nearest: bool) -> set[Members]:
    """Sets grown from every cell that is in fewer than `SETS_PER_CELL` of them."""
    found: set[Members] = set()
    held = np.zeros(cells, np.int64)
    with phase("growing convex sets", cells, "cells", log=_LOG) as step:
        for i in range(cells):
            if held[i] < SETS_PER_CELL:
                members = growth.from_seed(i, nearest)
                found.add(members)
                held[list(members)] += 1
            step()
    return found


def deviation(solid: Solid, part: Array, epsilon: float) -> float:
    """A proven upper bound, at most `epsilon`, of the distance of a part's points from the solid [m].

    The part must already be proven to lie within `epsilon` of the solid.
    """
    reached = float(solid.outside_distances(part).max())
    for share in TIGHTER_SHARES:
        bound = reached + share * (epsilon - reached)
        asks_more = reached > corner_limit(solid, bound) > 0.0  # than corners can prove
        if bound < epsilon and not asks_more and proven_near(solid, part, bound):
            return bound
    return epsilon


def proven_cover(solid: Solid, around: Cover, away: float, epsilon: float) -> Cover:
    """The parts of `around`, made for another solid at most `away` [m] from `solid`, with deviations proven for `solid`.

    Raises:
        Undecided: a part cannot be proven to be within `epsilon` [m].
    """
    deviations = []
    for part, farthest in zip(around.parts, around.deviations, strict=True):
        likely = min(farthest + away, epsilon)
        bound = next((b for b in (likely, epsilon) if proven_near(solid, part, b)), None)
        if bound is None:
            raise Undecided
        deviations.append(bound)
    return Cover(around.parts, tuple(deviations), epsilon)


def _chosen(
    solid: Solid,
    cells: list[HulledCell],
    sets: list[Members],
    made: dict[Members, Array | None],
    aims: Aims,
    voids: Voids,
) -> list[Members]:
    """The sets that cover all cells with the fewest corners found; writes their parts to `made`."""
    typical = 10.0
    best: list[Members] = []
    best_cost = np.inf
    for _ in range(CHOICE_ROUNDS + len(sets)):
        costs = [_cost(members, made, typical, aims) for members in sets]
        chosen = [sets[i] for i in fewest_sets(len(cells), sets, costs)]
        missing = [members for members in chosen if members not in made]
        for members in missing:
            points = np.vstack([cells[i].points for i in members])
            made[members] = enclosing_part(solid, points, aims.tolerance, voids)
        usable = all(len(members) == 1 or _is_usable(made[members], aims) for members in chosen)
        cost = sum(_cost(members, made, typical, aims) for members in chosen)
        if usable and cost < best_cost:
            best, best_cost = chosen, cost
        known = [len(part) for part in made.values() if part is not None]
        typical = float(np.median(known)) if known else typical
        if not missing or (best and len(made) > SPARE_PARTS_RATIO * len(best)):
            break
    return best


def _is_usable(part: Array | None, aims: Aims) -> bool:
    """Whether a set has a part, and one of few enough corners; a single cell needs none, since it can be cut."""
    return part is not None and not (aims.strict and aims.corners is not None and len(part) > aims.corners)


def _cost(members: Members, made: dict[Members, Array | None], typical: float, aims: Aims) -> float:
    """The cost of a set: the corners of its part, a typical number if it is not made yet, a high cost if it has none."""
    if members not in made:
        return typical + aims.worth + 0.01 * len(members)
    part = made[members]
    if part is None:
        return 1e4 if len(members) == 1 else 1e6
    if aims.corners is not None and len(part) > aims.corners:
        return 1e3 * (1.0 + len(members))
    return len(part) + aims.worth


def _in_smaller_cells(
    solid: Solid, hulled: HulledCell, aims: Aims, voids: Voids
) -> list[tuple[HulledCell, Array]]:
    """The smaller cells, with parts, into which a cell without a part is cut."""
    epsilon, corners = aims.tolerance, aims.corners
    deepest = MAX_PROOF_CUTS if aims.strict else MAX_CORNER_CUTS
    work, found = [(hulled, 0)], []
    while work:
        current, depth = work.pop()
        part = enclosing_part(solid, current.points, epsilon, voids)
        few = corners is None or part is None or len(part) <= corners or depth >= deepest
        if part is not None and few:
            found.append((current, part))
            continue
        if depth == MAX_PROOF_CUTS:
            raise Undecided
        far = near_or_witness(solid, current.points, CELL_SHARE * epsilon)[1]
        work += [(half, depth + 1) for half in cut_in_two(solid, current, CELL_SHARE * epsilon, far)]
    return found


def _shrunk(
    solid: Solid,
    cells: list[HulledCell],
    live: list[int],
    parts: dict[Members, Array],
    needed: dict[Members, set[int]],
    epsilon: float,
    voids: Voids,
) -> dict[Members, Array]:
    """The parts after removing what other parts cover: dropped if nothing is left, made again if that saves corners."""
    inside = {name: _held(part, cells, live) for name, part in parts.items()}
    for name in sorted(parts, key=lambda name: (-len(parts[name]), name)):
        others: set[int] = set().union(*(held for other, held in inside.items() if other != name))
        left = sorted(inside[name] - others)
        if not left:
            del parts[name], inside[name]
            continue
        if len(left) == len(inside[name] & needed[name]) and set(left) >= needed[name]:
            continue
        part = enclosing_part(solid, np.vstack([cells[i].points for i in left]), epsilon, voids)
        if part is not None and len(part) < len(parts[name]):
            parts[name] = part
            inside[name] = _held(part, cells, live)
    return parts


def _held(part: Array, cells: list[HulledCell], live: list[int]) -> set[int]:
    """The cells that are proven to lie inside a part, with a margin above rounding."""
    planes = hull_of(part).equations
    return {i for i in live if (cells[i].points @ planes[:, :3].T + planes[:, 3] <= -CONTAINMENT_MARGIN).all()}


def _covers(cells: list[HulledCell], live: list[int], parts: list[Array]) -> bool:
    """Whether every cell is proven to lie inside a part."""
    return set(live) == set().union(*(_held(part, cells, live) for part in parts))


__all__ = ["Aims", "TooManyCells", "Undecided", "cells_of", "deviation", "enclosing_union", "proven_cover"]
