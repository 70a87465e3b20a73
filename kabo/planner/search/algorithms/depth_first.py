"""Depth-first search; the successors of a node are visited in their given order."""

from collections import Counter
from collections.abc import Hashable, Iterator

from kabo import tuning
from kabo.planner.search.algorithms.graph import Graph, Move, Node, SearchOutcome


def depth_first(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """The first path to an end node in depth-first order.

    At first, each knowledge state is visited at most once, whatever its geometry. If no path is found, the search
    restarts and permits more visits. This avoids cycles along which only the geometry changes [K 6.2.3].
    """
    most = 1
    while True:
        found, whole = _depth_first(start, graph, most)
        if found.path is not None or whole:
            return found
        most *= tuning.VISITS_GROWTH


def _depth_first(start: Node, graph: Graph[Node, Move], most: int) -> tuple[SearchOutcome[Node, Move], bool]:
    """Depth-first search with at most `most` visits of each state of knowledge; and whether nothing was left out."""
    visited, times, whole = {graph.key(start)}, Counter([graph.known(start)]), True
    stack = [iter(graph.successors(start))]
    path: list[tuple[Move, Node]] = []
    while stack:
        step = first_new(stack[-1], visited)
        if step is None:
            stack.pop()
            if path:
                path.pop()
            continue
        key, move, node = step
        if graph.is_end(node):
            return SearchOutcome([*path, (move, node)]), True
        known = graph.known(node)
        if times[known] >= most:
            whole = False
            continue
        confirmed_key = graph.confirmed_key(node)
        if confirmed_key is None or (confirmed_key != key and confirmed_key in visited):
            continue
        visited.add(confirmed_key)
        times[known] += 1
        path.append((move, node))
        stack.append(iter(graph.successors(node)))
    return SearchOutcome(None, visited), whole


def first_new(
    steps: Iterator[tuple[Hashable, Move, Node]], visited: set[Hashable]
) -> tuple[Hashable, Move, Node] | None:
    """The first step that leads to an unvisited node, now marked as visited; None if there is no such step."""
    for key, move, node in steps:
        if key not in visited:
            visited.add(key)
            return key, move, node
    return None
