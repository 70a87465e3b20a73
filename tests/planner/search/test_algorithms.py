"""The weak searches on small graphs that one can see through."""

import math
import random
from collections import deque
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo import tuning
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.algorithms.astar import astar as cheapest_first
from kabo.planner.search.algorithms.best import best as serial
from kabo.planner.search.algorithms.best import newest_first
from kabo.planner.search.algorithms.breadth_first import breadth_first
from kabo.planner.search.algorithms.depth_first import depth_first
from kabo.planner.search.algorithms.greedy import greedy
from kabo.planner.search.algorithms.iterative_deepening import iterative_deepening
from tests.conftest import PROPERTY_SCALE


@dataclass
class Arrows:
    """A graph of numbers: `arrows` from each node, in order; expansions are noted.

    The move from a to b is a pair and its action's number is b. `far` says how far a node seems (None: hopeless),
    `preferred` what seems to lead on; `goals` are the conjuncts, each the set of nodes where it holds. Of nodes that
    are the `same` (which number) only geometry differs; it has `refused` some, and others it `turns_out` are another.
    """

    arrows: dict
    ends: set
    far: dict = field(default_factory=dict)
    preferred: dict = field(default_factory=dict)
    costs: dict = field(default_factory=dict)
    bounds: dict = field(default_factory=dict)
    goals: list = field(default_factory=list)
    expanded: list = field(default_factory=list)
    estimated: list = field(default_factory=list)
    same: dict = field(default_factory=dict)
    refused: set = field(default_factory=set)
    turns_out: dict = field(default_factory=dict)
    asked: list = field(default_factory=list)

    def key(self, node):
        return node

    def known(self, node):
        return self.same.get(node, node)

    def confirmed_key(self, node):
        self.asked.append(node)
        return None if node in self.refused else self.turns_out.get(node, node)

    def successors(self, node, *, among=None, without=frozenset()):
        if not without:
            self.expanded.append(node)
        children = [child for child in self.arrows.get(node, ()) if child not in without]
        return [(child, (node, child), child) for child in children if among is None or child in among]

    def is_end(self, node):
        return node in self.ends and node not in self.refused

    @property
    def parts(self):
        return range(len(self.goals))

    def holds(self, parts, node):
        return all(node in self.goals[part] for part in parts)

    def estimate(self, node, parts):
        self.estimated.append((node, tuple(parts)))
        return self.far.get(node, 0), frozenset(self.preferred.get(node, ()))

    def cost(self, move):
        return self.costs.get(move, 1.0)

    def bound(self, node):
        return self.bounds.get(node, 0.0)


LONG_AND_SHORT = {0: [1, 4], 1: [2], 2: [3], 3: [9], 4: [9]}


def nodes(search):
    return [node for _, node in search.path]


@pytest.mark.parametrize("search", [breadth_first, iterative_deepening, cheapest_first])
def test_the_shortest_path_is_found(search):
    assert nodes(search(0, Arrows(LONG_AND_SHORT, {9}))) == [4, 9]


def test_depth_first_takes_the_first_way_that_leads_there():
    assert nodes(depth_first(0, Arrows(LONG_AND_SHORT, {9}))) == [1, 2, 3, 9]


def test_depth_first_leaves_a_dead_end_behind():
    found = depth_first(0, Arrows({0: [1, 4], 1: [2], 4: [9]}, {9}))
    assert [move for move, _ in found.path] == [(0, 4), (4, 9)]


CIRCLES = {n: [n + 1, 100 + n] for n in range(40)}  # 0, 2, 4 … differ in geometry only, and so do 1, 3, 5 …


def test_depth_first_does_not_go_round_in_circles_that_only_geometry_tells_apart():
    same = {n: n % 2 for n in range(41)}
    assert nodes(depth_first(0, Arrows(CIRCLES, {101}, same=same))) == [1, 101]


def test_depth_first_goes_round_as_often_as_it_must():
    same = {n: n % 2 for n in range(41)}
    assert nodes(depth_first(0, Arrows(CIRCLES, {111}, same=same))) == [*range(1, 12), 111]
    assert depth_first(0, Arrows(CIRCLES, {999}, same=same)).path is None


@pytest.mark.parametrize("search", [breadth_first, depth_first, iterative_deepening, cheapest_first, greedy])
def test_what_geometry_refuses_is_not_gone_through(search):
    assert nodes(search(0, Arrows({0: [1, 2], 1: [9], 2: [3], 3: [9]}, {9}, refused={1}))) == [2, 3, 9]
    assert search(0, Arrows({0: [1], 1: [9]}, {9}, refused={9})).path is None


@pytest.mark.parametrize("search", [breadth_first, depth_first, iterative_deepening, cheapest_first, greedy])
def test_what_turns_out_to_be_known_is_not_expanded_again(search):
    graph = Arrows({0: [1, 2], 1: [3], 2: [4]}, {9}, turns_out={2: 1})
    assert search(0, graph).path is None
    assert len({3, 4}.intersection(graph.asked)) == 1


def test_geometry_is_not_asked_about_what_is_never_expanded():
    graph = Arrows({0: [1, 2, 3], 1: [9], 2: [4], 3: [5]}, {9}, far={0: 3, 1: 1}, preferred={0: [1], 1: [9]})
    assert nodes(greedy(0, graph)) == [1, 9]
    assert not {2, 3} & set(graph.asked)


def test_greedy_search_leaves_for_later_what_only_geometry_tells_from_where_it_was():
    same = dict.fromkeys(range(1, 41), 1)
    graph = Arrows({n: [n + 1] for n in range(1, 40)} | {0: [1, 50], 50: [9]}, {9}, far={50: 2}, same=same)
    assert nodes(greedy(0, graph)) == [50, 9]
    assert len(graph.expanded) < 20


def test_of_equally_short_paths_the_first_is_taken():
    assert nodes(breadth_first(0, Arrows({0: [1, 2], 1: [9], 2: [9]}, {9}))) == [1, 9]


@pytest.mark.parametrize("search", ALGORITHMS.values(), ids=ALGORITHMS)
def test_a_circle_without_an_end_is_exhausted(search):
    found = search(0, Arrows({0: [1], 1: [2], 2: [0, 1]}, {9}))
    assert found.path is None
    assert set(found.visited) == {0, 1, 2}


@pytest.mark.parametrize("search", [breadth_first, depth_first, cheapest_first])
def test_no_node_is_expanded_twice(search):
    graph = Arrows({n: [m for m in range(6) if m != n] for n in range(6)}, set())
    search(0, graph)
    assert sorted(graph.expanded) == list(range(6))


ARROWS = st.dictionaries(st.integers(0, 7), st.lists(st.integers(0, 7), max_size=4))
ENDS = st.sets(st.integers(1, 9), max_size=2)


@given(
    ARROWS,
    ENDS,
    st.dictionaries(st.integers(0, 7), st.integers(0, 4)),
    st.dictionaries(st.integers(0, 7), st.sets(st.integers(0, 9))),
    st.lists(st.sets(st.integers(0, 9)), max_size=2),
)
def test_all_agree_on_whether_an_end_can_be_reached(arrows, ends, far, preferred, goals):
    """Whatever is estimated and preferred; and some agree on how far it is."""
    goals = [goal | ends for goal in goals]
    found = {
        name: search(0, Arrows(arrows, ends, far, preferred, goals=goals)) for name, search in ALGORITHMS.items()
    }
    assert len({result.path is None for result in found.values()}) == 1
    if found["breadth-first"].path is not None:
        shortest = ("breadth-first", "iterative-deepening", "astar")
        assert len({len(found[name].path) for name in shortest}) == 1
        for result in found.values():
            assert result.path[-1][1] in ends
            steps = [0, *nodes(result)]
            assert [move for move, _ in result.path] == list(zip(steps, steps[1:], strict=False))
            assert all(child in arrows[node] for node, child in zip(steps, steps[1:], strict=False))
    else:
        assert len({frozenset(result.visited) for result in found.values()}) == 1


def test_a_path_of_thousands_of_steps_needs_no_deep_stack():
    chain = {n: [n + 1] for n in range(3000)}
    assert len(depth_first(0, Arrows(chain, {3000})).path) == 3000


# ---------------------------------------------------------------------------------------------------- by their cost
def test_a_dear_short_way_is_not_taken_where_a_long_one_is_cheap():
    found = cheapest_first(0, Arrows(LONG_AND_SHORT, {9}, costs={(0, 4): 3.5}))
    assert nodes(found) == [1, 2, 3, 9]


def test_what_costs_nothing_is_no_reason_to_stop_early():
    """The end is met at once over a dear move; it counts when its turn comes."""
    found = cheapest_first(
        0, Arrows({0: [9, 1], 1: [2], 2: [9]}, {9}, costs={(0, 9): 2.0, (0, 1): 0.0, (1, 2): 0.0})
    )
    assert nodes(found) == [1, 2, 9]


@given(ARROWS, ENDS, st.dictionaries(st.tuples(st.integers(0, 7), st.integers(0, 7)), st.integers(0, 5)))
def test_no_path_is_cheaper(arrows, ends, costs):
    """Compared with relaxing all arrows until nothing changes."""
    graph = Arrows(arrows, ends, costs=costs)
    found = cheapest_first(0, graph)
    least = {child: graph.cost((0, child)) for child in arrows.get(0, ())}
    waiting = deque(least)
    while waiting:
        node = waiting.popleft()
        for child in arrows.get(node, ()):
            total = least[node] + graph.cost((node, child))
            if total < least.get(child, float("inf")):
                least[child] = total
                waiting.append(child)
    best = min((least[end] for end in ends if end in least), default=None)
    assert (None if found.path is None else sum(graph.cost(move) for move, _ in found.path)) == best


# ------------------------------------------------------------------------------------------------------ by estimate
def test_what_seems_nearer_comes_first():
    arrows = {0: [1, 2], 1: [3], 2: [4], 3: [9], 4: [9]}
    graph = Arrows(arrows, {9}, far={0: 3, 1: 5, 2: 2, 4: 1})
    assert nodes(greedy(0, graph)) == [2, 4, 9]
    assert 3 not in graph.expanded


def test_what_seems_hopeless_is_not_followed():
    graph = Arrows({0: [1, 2], 1: [9], 2: [3], 3: [9]}, {9}, far={1: None})
    assert nodes(greedy(0, graph)) == [2, 3, 9]
    assert 1 not in graph.expanded


def test_the_start_may_be_hopeless():
    found = greedy(0, Arrows({0: [9]}, {9}, far={0: None}))
    assert found.path is None


def test_what_is_preferred_comes_first_and_the_rest_is_not_forgotten():
    arrows = {0: [1, 2], 1: [9], 2: [3], 3: []}
    graph = Arrows(arrows, {9}, preferred={0: {2}, 2: {3}})
    assert nodes(greedy(0, graph)) == [1, 9]
    expanded = graph.expanded
    assert expanded.index(2) < expanded.index(1)


def test_whenever_it_gets_nearer_what_is_preferred_gets_more_turns():
    """A chain of preferred moves is followed to its end, though every node has other successors that seem as near."""
    arrows = {n: [n + 1, 100 + n] for n in range(20)} | {20: [9999]}
    preferred = {n: {n + 1} for n in range(20)} | {100 + n: {0} for n in range(20)}
    graph = Arrows(arrows, {9999}, far={0: 9} | dict.fromkeys(range(1, 200), 1), preferred=preferred)
    assert nodes(greedy(0, graph)) == [*range(1, 21), 9999]
    assert not [node for node in graph.expanded if 100 <= node < 200]


def test_the_rest_of_a_node_is_no_second_expansion():
    graph = Arrows({0: [1, 2], 1: [2], 2: [0]}, {9}, preferred={0: {1}, 1: {2}, 2: {0}})
    greedy(0, graph)
    assert sorted(graph.expanded) == [0, 1, 2]


# --------------------------------------------------------------------------------- one conjunct after the other
def test_conjuncts_are_reached_one_after_the_other_in_their_order():
    """First wherever the second holds? No: the first conjunct is seen to first."""
    arrows = {0: [1, 2], 1: [3], 2: [3], 3: []}
    first, second = {2, 3}, {1, 3}
    graph = Arrows(arrows, {3}, goals=[first, second])
    assert nodes(serial(0, graph)) == [2, 3]
    assert {parts for _, parts in graph.estimated} == {(0,), (1, 0)}


def test_conjuncts_that_were_reached_are_kept_or_reached_again():
    """From where the first holds, the second cannot be had without losing it: both are sought at once."""
    arrows = {0: [1, 2], 1: [], 2: [9]}
    graph = Arrows(arrows, {9}, goals=[{1, 9}, {9}])
    assert nodes(serial(0, graph)) == [2, 9]


def test_a_conjunct_that_is_far_away_is_given_up_for_the_goal_as_a_whole():
    length = tuning.MAX_SERIAL_EXPANSIONS + 10
    arrows = {n: [n + 1] for n in range(length)}
    found = serial(0, Arrows(arrows, {length}, goals=[{length}]))
    assert len(found.path) == length


def test_a_goal_that_needs_no_conjunct_is_searched_as_a_whole():
    assert nodes(serial(0, Arrows({0: [1], 1: [9]}, {9}, goals=[{0, 1, 9}]))) == [1, 9]


def test_an_end_on_the_way_is_an_end():
    """What is solved already need not fulfil any conjunct."""
    graph = Arrows({0: [5], 5: [6], 6: [9]}, {5, 9}, goals=[{9}])
    assert nodes(serial(0, graph)) == [5]


# ----------------------------------------------------------------------------------------------------------------- A*
def bounded_arrows(seed):
    """A random graph with costs, and bounds that are never too high, but may fall and rise along a way."""
    draw = random.Random(seed)
    size = draw.randint(2, 14)
    arrows = {n: draw.sample(range(size), draw.randint(0, min(3, size))) for n in range(size)}
    costs = {(n, child): draw.choice([0.0, 1.0, 1.0, 3.0]) for n, children in arrows.items() for child in children}
    ends = set(draw.sample(range(1, size), draw.randint(1, min(2, size - 1))))
    rest = {n: 0.0 if n in ends else math.inf for n in range(size)}
    for _ in range(size):
        for (n, child), cost in costs.items():
            rest[n] = min(rest[n], cost + rest[child])
    bounds = {}
    for n, left in rest.items():
        bounds[n] = draw.choice([None, 0.0]) if left == math.inf else draw.choice([0.0, draw.random(), 1.0]) * left
    return Arrows(arrows, ends, costs=costs, bounds=bounds), rest[0]


@pytest.mark.parametrize("plain", [0, 3])
def test_astar_finds_the_least_cost_whatever_the_bounds(monkeypatch, plain):
    monkeypatch.setattr(tuning, "EXPANSIONS_WITHOUT_BOUNDS", plain)
    found = 0
    for seed in range(max(200, round(5000 * PROPERTY_SCALE))):
        graph, least = bounded_arrows(seed)
        path = cheapest_first(0, graph).path
        if 0 in graph.ends:
            continue
        assert (path is None) == (least == math.inf), seed
        if path is not None:
            found += 1
            assert sum(graph.cost(move) for move, _ in path) == least, seed
            assert path[-1][1] in graph.ends
    assert found > 60


def test_bounds_spare_expansions(monkeypatch):
    monkeypatch.setattr(tuning, "EXPANSIONS_WITHOUT_BOUNDS", 0)
    grid = {(x, y): [(x + 1, y), (x, y + 1)] for x in range(9) for y in range(9)}
    blind = Arrows(grid, {(8, 0)})
    told = Arrows(grid, {(8, 0)}, bounds={(x, y): 8.0 - x if y == 0 else None for x, y in grid})
    assert nodes(cheapest_first((0, 0), blind)) == nodes(cheapest_first((0, 0), told))
    assert len(told.expanded) == 8 < len(blind.expanded) // 3


def test_of_nodes_that_seem_equally_far_the_newest_is_taken_if_so_wanted():
    """Two ways of equal estimates: the one is walked to its end, the other step by step beside it."""
    arrows = {0: [1, 11], 1: [2], 2: [3], 3: [9], 11: [12], 12: [13], 13: [9]}
    oldest, newest = (Arrows(arrows, {9}, preferred=arrows, goals=[{9}]) for _ in range(2))
    assert nodes(serial(0, oldest)) == [1, 2, 3, 9] and oldest.expanded == [0, 1, 11, 2, 12, 3]
    assert nodes(newest_first(0, newest)) == [11, 12, 13, 9] and newest.expanded == [0, 11, 12, 13]
