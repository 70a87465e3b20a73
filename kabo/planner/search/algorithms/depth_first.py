"""Depth-first search: the first way to an end that following first successors meets."""

from collections import Counter
from collections.abc import Hashable, Iterator

from kabo.planner.search.algorithms.graph import Graph, Move, Node, Search

MORE_VISITS = 4  # times as many visits of each state of knowledge, whenever fewer were too few


def depth_first(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """The first path that following first successors meets.

    A state of knowledge is gone into once, whatever its geometry, and four times as often whenever that was too
    little: so paths do not go round in circles that only geometry tells from standing still [K 6.2.3].
    """
    most = 1
    while True:
        found, whole = _depth_first(start, graph, most)
        if found.path is not None or whole:
            return found
        most *= MORE_VISITS


def _depth_first(start: Node, graph: Graph[Node, Move], most: int) -> tuple[Search[Node, Move], bool]:
    """Depth-first search with so many visits of each state of knowledge; and whether nothing more was left out."""
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
            return Search([*path, (move, node)]), True
        known = graph.known(node)
        if times[known] >= most:
            whole = False
            continue
        settled = graph.settled(node)
        if settled is None or (settled != key and settled in visited):
            continue
        visited.add(settled)
        times[known] += 1
        path.append((move, node))
        stack.append(iter(graph.successors(node)))
    return Search(None, visited), whole


def first_new(
    steps: Iterator[tuple[Hashable, Move, Node]], visited: set[Hashable]
) -> tuple[Hashable, Move, Node] | None:
    """The first step to a node that was not visited, which now is; None if there is none."""
    for key, move, node in steps:
        if key not in visited:
            visited.add(key)
            return key, move, node
    return None
