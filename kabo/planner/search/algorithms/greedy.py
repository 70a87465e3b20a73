"""Greedy best-first search with heuristic estimates over knowledge states."""

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from typing import Generic

from kabo import tuning
from kabo.planner.search.algorithms.graph import Graph, Move, Node, Parents, SearchOutcome, expanded, path_to


def greedy(start: Node, graph: Graph[Node, Move]) -> SearchOutcome[Node, Move]:
    """Lazy greedy best-first search: nodes are estimated when they are expanded, by h_FF over knowledge."""
    found = best_first(start, graph, graph.is_end, graph.parts, None, once=False)
    assert found is not None, "a search without a limit ends with an answer"
    return found


def best_first(
    start: Node,
    graph: Graph[Node, Move],
    is_end: Callable[[Node], bool],
    parts: Sequence[int],
    limit: int | None,
    kept: tuple[int, ...] = (),
    once: bool = True,
    newest: bool = False,
) -> SearchOutcome[Node, Move] | None:
    """Greedy search for some goal conjuncts that keeps those in `kept`; None if `limit` expansions do not suffice.

    Nodes wait in two queues, ordered by the estimate of their parent. One queue holds only nodes reached by
    preferred actions; it gets more turns whenever the estimate improves [Fast Downward, LAMA's first iteration].
    Successors by other actions are generated only when their turn comes. With `once`, a node whose knowledge state
    was expanded before is left out; otherwise its estimate is increased by one step for each earlier expansion.
    The reason is that nodes which differ only in geometry have equal estimates, and there may be infinitely many
    of them.
    """
    root = graph.key(start)
    parents: Parents[Move, Node] = {root: None}
    done: set[Hashable] = set()
    every, promising = _Queue[Node](newest), _Queue[Node](newest)
    every.push(0, (root, start, None, 0))
    been: Counter[Hashable] = Counter()
    best: int | None = None
    while every.waiting or promising.waiting:
        queue = _whose_turn(promising, every)
        value, (waiting, node, preferred, counted) = queue.pop()
        known = graph.known(node)
        if preferred is None and been[known] > counted:
            if not once:
                queue.push(value + been[known] - counted, (waiting, node, None, been[known]))
            continue
        key = waiting if preferred is not None else expanded(waiting, node, graph, parents, done)
        if key is None:
            continue
        if preferred is None:
            if key != waiting and is_end(node):
                return SearchOutcome(path_to(parents, key))
            if limit is not None and len(done) > limit:
                return None
            estimate, preferred = graph.estimate(node, parts)
            if estimate is None:
                continue
            value = estimate + been[known]
            been[known] += 1
            if best is None or value < best:
                best = value
                promising.turns -= tuning.PREFERRED_QUEUE_TURNS
            successors, target = graph.successors(node, among=preferred), promising
            every.push(value, (key, node, preferred, 0))
        else:
            successors, target = graph.successors(node, without=preferred), every
        for child_key, child in _entered(successors, graph, key, parents, kept):
            if is_end(child) and graph.confirmed_key(child) is not None:
                return SearchOutcome(path_to(parents, child_key))
            target.push(value, (child_key, child, None, 0))
    return SearchOutcome(None, parents.keys())


def _entered(
    successors: Iterable[tuple[Hashable, Move, Node]],
    graph: Graph[Node, Move],
    key: Hashable,
    parents: Parents[Move, Node],
    kept: tuple[int, ...],
) -> Iterator[tuple[Hashable, Node]]:
    """The successors that are new and keep what is to be `kept`, each entered in `parents` when it is asked for."""
    for child_key, move, child in successors:
        if child_key in parents or (kept and not graph.holds(kept, child)):
            continue
        parents[child_key] = key, move, child
        yield child_key, child


_Waiting = tuple[Hashable, Node, frozenset[int] | None, int]


class _Queue(Generic[Node]):
    """Nodes by estimate, the oldest (or the newest) of equals first; `turns` counts what was taken out.

    With a node waits nothing if it is to be expanded, and what was preferred if the rest of its successors is due;
    and how often the search had been where the same is known when the node began to wait.
    """

    def __init__(self, newest: bool) -> None:
        self.waiting: list[tuple[int, int, _Waiting[Node]]] = []
        self._count, self._step = 0, -1 if newest else 1
        self.turns = 0

    def push(self, value: int, waiting: "_Waiting[Node]") -> None:
        """Puts a node in."""
        self._count += self._step
        heappush(self.waiting, (value, self._count, waiting))

    def pop(self) -> "tuple[int, _Waiting[Node]]":
        """Takes the nearest node out, with its estimate."""
        self.turns += 1
        value, _, waiting = heappop(self.waiting)
        return value, waiting


def _whose_turn(promising: _Queue[Node], every: _Queue[Node]) -> _Queue[Node]:
    """The queue to take the next node from: the one with fewer turns so far, `every` if equal; never an empty one."""
    if promising.waiting and (promising.turns < every.turns or not every.waiting):
        return promising
    return every
