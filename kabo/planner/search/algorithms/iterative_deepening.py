"""Iterative deepening: a shortest path to an end node, by depth-first searches with growing depth limits."""

from collections.abc import Hashable

from kabo.planner.search.algorithms.graph import Graph, Move, Node, SearchOutcome


def iterative_deepening(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """A shortest path to an end node, by depth-first searches with growing depth limits.

    There is no path if a depth-first search ends without having been cut off by its limit.
    """
    limit = 1
    while True:
        path, depths = _depth_limited(start, graph, limit)
        if path is not None or limit not in depths.values():
            return SearchOutcome(path, depths.keys())
        limit += 1


def _depth_limited(
    start: Node, graph: Graph[Node, Move], limit: int
) -> tuple[list[tuple[Move, Node]] | None, dict[Hashable, int]]:
    """Depth-first search to a limit; a node is visited again only at a smaller depth than before.

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
