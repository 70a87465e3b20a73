"""The three weak searches on small graphs that one can see through."""

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.planner.searches import SEARCHES, breadth_first, depth_first, iterative_deepening


@dataclass
class Arrows:
    """A graph of numbers: `arrows` from each node, in order; expansions are noted."""

    arrows: dict
    ends: set
    expanded: list = field(default_factory=list)

    def key(self, node):
        return node

    def successors(self, node):
        self.expanded.append(node)
        return [(child, f"{node}-{child}", child) for child in self.arrows.get(node, ())]

    def is_end(self, node):
        return node in self.ends


LONG_AND_SHORT = {0: [1, 4], 1: [2], 2: [3], 3: [9], 4: [9]}


def nodes(search):
    return [node for _, node in search.path]


@pytest.mark.parametrize("search", [breadth_first, iterative_deepening])
def test_the_shortest_path_is_found(search):
    assert nodes(search(0, Arrows(LONG_AND_SHORT, {9}))) == [4, 9]


def test_depth_first_takes_the_first_way_that_leads_there():
    assert nodes(depth_first(0, Arrows(LONG_AND_SHORT, {9}))) == [1, 2, 3, 9]


def test_depth_first_leaves_a_dead_end_behind():
    found = depth_first(0, Arrows({0: [1, 4], 1: [2], 4: [9]}, {9}))
    assert [move for move, _ in found.path] == ["0-4", "4-9"]


def test_of_equally_short_paths_the_first_is_taken():
    assert nodes(breadth_first(0, Arrows({0: [1, 2], 1: [9], 2: [9]}, {9}))) == [1, 9]


@pytest.mark.parametrize("search", SEARCHES.values(), ids=SEARCHES)
def test_a_circle_without_an_end_is_exhausted(search):
    found = search(0, Arrows({0: [1], 1: [2], 2: [0, 1]}, {9}))
    assert found.path is None
    assert set(found.visited) == {0, 1, 2}


@pytest.mark.parametrize("search", [breadth_first, depth_first])
def test_no_node_is_expanded_twice(search):
    graph = Arrows({n: [m for m in range(6) if m != n] for n in range(6)}, set())
    search(0, graph)
    assert sorted(graph.expanded) == list(range(6))


@given(
    st.dictionaries(st.integers(0, 7), st.lists(st.integers(0, 7), max_size=4)),
    st.sets(st.integers(1, 9), max_size=2),
)
def test_all_agree_on_whether_an_end_can_be_reached(arrows, ends):
    """And breadth-first and iterative deepening on how far it is."""
    found = {name: search(0, Arrows(arrows, ends)) for name, search in SEARCHES.items()}
    assert len({result.path is None for result in found.values()}) == 1
    if found["breadth-first"].path is not None:
        assert len(found["breadth-first"].path) == len(found["iterative-deepening"].path)
    else:
        assert len({frozenset(result.visited) for result in found.values()}) == 1


def test_a_path_of_thousands_of_steps_needs_no_deep_stack():
    chain = {n: [n + 1] for n in range(3000)}
    assert len(depth_first(0, Arrows(chain, {3000})).path) == 3000
