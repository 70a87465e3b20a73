"""A*: a path of least cost to an end node."""

from collections.abc import Hashable
from heapq import heappop, heappush
from itertools import count
from math import inf

from kabo import tuning
from kabo.planner.search.algorithms.graph import Graph, Move, Node, Parents, SearchOutcome, path_to

# A node that waits, by what a way through it costs at least, then by how near an end seems, then the latest first:
# both bounds, its order, whether it is bounded by itself and not by its parent, its cost, its key, the node.
_Waiting = tuple[float, float, int, bool, float, Hashable, Node]


def astar(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """A path of least cost to an end node.

    Evaluation is lazy: until a node is taken from the queue, its bound is the bound of its parent minus the cost
    of the move, as in the packed search of tasks without sensing. A node that is reached again at lower cost is
    reopened, since the bounds need not be consistent.
    """
    root, numbers = graph.key(start), count(1)
    parents: Parents[Move, Node] = {root: None}
    costs: dict[Hashable, float] = {root: 0.0}
    closed: dict[Hashable, float] = {}
    queue: list[_Waiting[Node]] = [(0.0, 0.0, 0, False, 0.0, root, start)]
    while queue:
        _, bound, order, bounded, cost, waiting, node = heappop(queue)
        if cost > costs[waiting]:
            continue
        if not bounded and len(closed) >= tuning.EXPANSIONS_WITHOUT_BOUNDS:
            own = graph.bound(node)
            if own is None:
                continue
            if own > bound:
                heappush(queue, (cost + own, own, order, True, cost, waiting, node))
                continue
        key = graph.confirmed_key(node)
        if key is None or closed.get(key, inf) <= cost:
            continue
        closed[key] = costs[key] = cost
        if key != waiting:
            parents[key] = parents[waiting]
        if order and graph.is_end(node):
            return SearchOutcome(path_to(parents, key))
        for child_key, move, child in graph.successors(node):
            price = graph.cost(move)
            total = cost + price
            if total < costs.get(child_key, inf):
                costs[child_key], parents[child_key] = total, (key, move, child)
                left = max(0.0, bound - price)
                heappush(queue, (total + left, left, -next(numbers), False, total, child_key, child))
    return SearchOutcome(None, parents.keys())
