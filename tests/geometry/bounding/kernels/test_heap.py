"""The heap of edges: cheapest first, equal costs by the numbers of the ends, whatever the order of pushing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.bounding.kernels import heap

COSTS = st.sampled_from([0.0, 1e-300, 0.5, 0.5 + 2.0**-53, 7.0, np.inf])  # few, so that many are equal
ENTRIES = st.lists(st.tuples(COSTS, st.integers(0, 5), st.integers(0, 5)), max_size=80)


def empty(room):
    return np.full(room, np.nan), np.full((room, 3), -7)


def filled(entries, push=heap.push):
    """The heap after pushing all entries, each with its place in the list as its stamp."""
    costs, edges = empty(max(1, len(entries)))
    size = 0
    for stamp, (cost, first, second) in enumerate(entries):
        size = push(costs, edges, size, cost, first, second, stamp)
    return costs, edges, size


def drained(costs, edges, size, pop=heap.pop):
    popped = []
    while size:
        popped.append((float(costs[0]), int(edges[0, 0]), int(edges[0, 1]), int(edges[0, 2])))
        size = pop(costs, edges, size)
    return popped


@given(entries=ENTRIES)
def test_entries_come_out_by_cost_then_by_the_numbers_of_the_ends(entries):
    popped = drained(*filled(entries))
    assert [entry[:3] for entry in popped] == sorted(entries)
    assert sorted(stamp for *_, stamp in popped) == list(range(len(entries)))
    assert all(entries[stamp] == tuple(entry) for *entry, stamp in popped)


@given(entries=ENTRIES.map(lambda rows: sorted(set(rows))), data=st.data())
def test_the_order_of_pushing_changes_nothing(entries, data):
    shuffled = data.draw(st.permutations(entries))
    assert [e[:3] for e in drained(*filled(entries))] == [e[:3] for e in drained(*filled(shuffled))]


@given(entries=ENTRIES, pops=st.lists(st.booleans(), max_size=80))
def test_pushes_and_pops_may_alternate(entries, pops):
    costs, edges = empty(max(1, len(entries)))
    size, inside = 0, []
    for stamp, (entry, take) in enumerate(zip(entries, pops, strict=False)):
        size = heap.push(costs, edges, size, *entry, stamp)
        inside.append(entry)
        if take:
            assert (costs[0], edges[0, 0], edges[0, 1]) == min(inside)
            inside.remove(min(inside))
            size = heap.pop(costs, edges, size)
        assert size == len(inside)
    assert [entry[:3] for entry in drained(costs, edges, size)] == sorted(inside)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 40])
def test_compiled_and_original_leave_the_same_arrays(count):
    rng = np.random.default_rng(count)
    entries = [(float(rng.integers(4)), int(rng.integers(4)), int(rng.integers(4))) for _ in range(count)]
    compiled, original = filled(entries), filled(entries, heap.push.py_func)
    assert np.array_equal(compiled[0], original[0], equal_nan=True) and np.array_equal(compiled[1], original[1])
    assert drained(*compiled) == drained(*original, heap.pop.py_func)
