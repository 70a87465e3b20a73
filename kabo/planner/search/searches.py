"""Weak search: one way to an end, with every sensed outcome as hoped for [K 6.2].

Each algorithm takes a start and a graph and returns the path to an end, or None with everything that it visited
when there is none. All are deterministic: successors are taken in the order in which the graph gives them.
"""

from collections import Counter, deque
from collections.abc import Hashable, Iterator

from kabo import tuning
from kabo.planner.search.astar import cheapest_first
from kabo.planner.search.greedy_search import greedy, serial
from kabo.planner.search.search_graph import (
    Algorithm,
    Graph,
    Move,
    Node,
    Parents,
    SearchOutcome,
    expanded,
    path_to,
)


def breadth_first(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """The shortest path to an end; of equally short ones the first."""
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


def depth_first(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """The first path that following first successors meets.

    A state of knowledge is gone into once, whatever its geometry, and four times as often whenever that was too
    little: so paths do not go round in circles that only geometry tells from standing still [K 6.2.3].
    """
    most = 1
    while True:
        found, whole = _depth_first(start, graph, most)
        if found.path is not None or whole:
            return found
        most *= tuning.VISITS_GROWTH


def iterative_deepening(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """A shortest path, by depth-first searches with growing limits; ends when a limit has cut nothing off."""
    limit = 1
    while True:
        path, depths = _depth_limited(start, graph, limit)
        if path is not None or limit not in depths.values():
            return SearchOutcome(path, depths.keys())
        limit += 1


def _depth_first(start: Node, graph: Graph[Node, Move], most: int) -> tuple[SearchOutcome[Node, Move], bool]:
    """Depth-first search with so many visits of each state of knowledge; and whether nothing more was left out."""
    visited, times, whole = {graph.key(start)}, Counter([graph.known(start)]), True
    stack = [iter(graph.successors(start))]
    path: list[tuple[Move, Node]] = []
    while stack:
        step = _first_new(stack[-1], visited)
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


def _depth_limited(
    start: Node, graph: Graph[Node, Move], limit: int
) -> tuple[list[tuple[Move, Node]] | None, dict[Hashable, int]]:
    """Depth-first search to a limit; a node is met again only where more of the limit is left for it.

    Also returns how far each node is from the start: a node at the limit itself has not been expanded.
    """
    depths: dict[Hashable, int] = {graph.key(start): 0}
    stack = [iter(graph.successors(start))]
    path: list[tuple[Move, Node]] = []
    while stack:
        step = next(stack[-1], None)
        if step is None:
            stack.pop()
            if path:
                path.pop()
            continue
        key, move, node = step
        depth = len(stack)
        if depths.get(key, limit + 1) <= depth:
            continue
        depths[key] = depth
        if graph.is_end(node):
            return [*path, (move, node)], depths
        if depth < limit:
            confirmed_key = graph.confirmed_key(node)
            if confirmed_key is None or (confirmed_key != key and depths.get(confirmed_key, limit + 1) <= depth):
                continue
            depths[confirmed_key] = depth
            path.append((move, node))
            stack.append(iter(graph.successors(node)))
    return None, depths


def _first_new(
    steps: Iterator[tuple[Hashable, Move, Node]], visited: set[Hashable]
) -> tuple[Hashable, Move, Node] | None:
    for key, move, node in steps:
        if key not in visited:
            visited.add(key)
            return key, move, node
    return None


SEARCHES: dict[str, Algorithm] = {  # type: ignore[type-arg]
    "breadth-first": breadth_first,
    "depth-first": depth_first,
    "iterative-deepening": iterative_deepening,
    "greedy": greedy,
    "astar": cheapest_first,
    "best": serial,
}
