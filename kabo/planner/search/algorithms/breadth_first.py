"""Breadth-first search: a shortest path to an end node."""

from collections import deque
from collections.abc import Hashable

from kabo.planner.search.algorithms.graph import Graph, Move, Node, Parents, SearchOutcome, expanded, path_to


def breadth_first(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """The shortest path to an end node; if several are equally short, the first one generated."""
    root = graph.key(start)
    parents: Parents[Move, Node] = {root: None}
    queue, done = deque([(root, start)]), set[Hashable]()
    while queue:
        waiting, node = queue.popleft()
        parent = expanded(waiting, node, graph, parents, done)
        if parent is None:
            continue
        if parent != waiting and graph.is_end(node):
            return SearchOutcome(path_to(parents, parent))
        for key, move, child in graph.successors(node):
            if key not in parents:
                parents[key] = parent, move, child
                if graph.is_end(child):
                    return SearchOutcome(path_to(parents, key))
                queue.append((key, child))
    return SearchOutcome(None, parents.keys())
