"""The search that does best all round: greedily for one conjunct of the goal after the other."""

from collections.abc import Callable

from kabo import tuning
from kabo.planner.search.algorithms.graph import Graph, Move, Node, SearchOutcome
from kabo.planner.search.algorithms.greedy import best_first, greedy


def best(start: Node, graph: Graph[Node, Move], newest: bool = False) -> SearchOutcome[Node, Move]:
    """Greedy search for one conjunct of the goal after the other, in a fixed order; then for what is left at once.

    What is left of a contingent plan when one conjunct has been reached is then the same in all branches. What has
    been reached is not risked on the way, if that can be; where a conjunct cannot be reached soon without losing an
    earlier one for good, the goal is searched for as a whole.
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
    """As `best`, but of nodes that seem equally far the newest is taken, not the oldest."""
    return best(start, graph, newest=True)


def _all_hold(graph: Graph[Node, Move], parts: tuple[int, ...]) -> Callable[[Node], bool]:
    def reached(node: Node) -> bool:
        return graph.holds(parts, node) or graph.is_end(node)

    return reached
