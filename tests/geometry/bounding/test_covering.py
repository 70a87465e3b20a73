"""Choosing sets of cells: what cells are worth, and long cells cut across."""

import numpy as np
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from kabo.geometry.bounding import enclosing_union as unions
from kabo.geometry.bounding.covering import fewest_sets, prices_of
from kabo.geometry.triangles.solids import Solid

CELLS = 7
SETS = st.lists(st.sets(st.integers(0, CELLS - 1), min_size=1).map(lambda held: tuple(sorted(held))), max_size=12)


@given(sets=SETS, data=st.data())
def test_no_set_is_worth_more_than_it_costs_nor_all_cells_more_than_the_cover(sets, data):
    sets = sorted({*sets, *((i,) for i in range(CELLS))})
    costs = data.draw(st.lists(st.floats(0.5, 9.0), min_size=len(sets), max_size=len(sets)))
    prices = prices_of(CELLS, sets, costs)
    assert (prices >= 0.0).all()
    assert all(prices[list(held)].sum() <= cost + 1e-6 for held, cost in zip(sets, costs, strict=True))
    cover = fewest_sets(CELLS, sets, costs)
    assert set().union(*(sets[i] for i in cover)) == set(range(CELLS))
    assert 0.0 < prices.sum() <= sum(costs[i] for i in cover) + 1e-6


def test_cells_that_each_set_holds_alone_cost_their_set():
    assert prices_of(3, [(0, 1), (1, 2)], [2.0, 3.0]).tolist() == [2.0, 0.0, 3.0]


def test_long_cells_are_cut_across_and_still_hold_all_of_the_solid(monkeypatch):
    box = trimesh.creation.box((0.4, 0.1, 0.05))
    solid = Solid(np.array(box.vertices, np.float64), np.array(box.faces, np.int64))
    whole = unions.cells_of(solid, unions.Aims(0.005))
    assert len(whole) == 1
    cells = unions._shorter(solid, whole, 0.005)
    assert 8 <= len(cells) < unions.MANY_CELLS
    lengths = [float(np.ptp(cell.points, axis=0).max()) for cell in cells]
    assert max(lengths) <= unions.LONG_CELL_EPSILONS * 0.005 + 1e-3  # flat cells are made a little thicker
    assert sum(ConvexHull(cell.points).volume for cell in cells) >= 0.4 * 0.1 * 0.05 * (1 - 1e-9)
    monkeypatch.setattr(unions, "MANY_CELLS", 3)
    assert len(unions._shorter(solid, whole, 0.005)) == 3
