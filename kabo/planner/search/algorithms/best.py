"""The default search: greedy best-first search for one goal conjunct after the other."""

from collections.abc import Callable

from kabo import tuning
from kabo.planner.search.algorithms.graph import Graph, Move, Node, SearchOutcome
from kabo.planner.search.algorithms.greedy import best_first, greedy


def best(start: Node, graph: Graph[Node, Move], newest: bool = False) -> SearchOutcome[Node, Move]:
    """Greedy search for one goal conjunct after the other, in a fixed order; if that fails, for all at once.

    Because of the fixed order, what remains of a contingent plan after one conjunct is the same in all branches.
    Conjuncts that already hold are protected where possible. If a further conjunct cannot be reached soon together
    with them, the search restarts for all conjuncts at once.
    """
    node, path, reached = start, [], tuple(part for part in graph.parts if graph.holds((part,), start))
    for part in graph.parts:
        wanted = (part, *reached) if part not in reached else reached
        if graph.holds(wanted, node):
            continue
        arrived = _all_hold(graph, wanted)
        step = best_first(node, graph, arrived, wanted, tuning.MAX_SERIAL_EXPANSIONS, kept=reached, newest=newest)
        if step is None or step.path is None:
            step = best_first(node, graph, arrived, wanted, tuning.MAX_SERIAL_EXPANSIONS, newest=newest)
        if step is None or step.path is None:
            return greedy(start, graph)
        reached = wanted
        if step.path:
            path += step.path
            node = path[-1][1]
        if graph.is_end(node):
            return SearchOutcome(path)
    return SearchOutcome(path) if path and graph.is_end(node) else greedy(start, graph)


def newest_first(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """Greedy search like `best`, except that among nodes with equal estimates the newest is expanded first."""
    return best(start, graph, newest=True)


def _all_hold(graph: Graph[Node, Move], parts: tuple[int, ...]) -> Callable[[Node], bool]:
    def reached(node: Node) -> bool:
        return graph.holds(parts, node) or graph.is_end(node)

    return reached
