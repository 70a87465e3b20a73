"""Weak search: one way to an end, with every sensed outcome as hoped for [K 6.2].

Each algorithm takes a start and a graph and returns the path to an end, or None with everything that it visited
when there is none. All are deterministic: successors are taken in the order in which the graph gives them.
"""

from collections import Counter, deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import count
from typing import Generic, NamedTuple, Protocol, TypeVar

SERIAL_EXPANSIONS = 2000  # for one more conjunct of the goal, before the goal is searched for as a whole
MORE_VISITS = 4  # times as many visits of each state of knowledge, depth-first, whenever fewer were too few
PREFERRED_TURNS = 1000  # for the queue of preferred actions whenever the estimate improves

Node = TypeVar("Node")
Move = TypeVar("Move")
Made = TypeVar("Made")


_Parents = dict[Hashable, tuple[Hashable, Move, Node] | None]


class Graph(Protocol[Node, Made]):
    """What a search needs; `successors` counts the expansion and raises when the budget is spent."""

    def key(self, node: Node) -> Hashable:
        """What tells nodes apart."""
        ...

    def known(self, node: Node) -> Hashable:
        """What is known at a node: nodes that differ only in geometry have it in common."""
        ...

    def settled(self, node: Node) -> Hashable | None:
        """The key of a node that is about to be expanded: geometry is asked now what it was not; None: refused."""
        ...

    def successors(
        self, node: Node, *, among: frozenset[int] | None = None, without: frozenset[int] | None = None
    ) -> Iterable[tuple[Hashable, Made, Node]]:
        """The nodes one move away, each with its key; if so wanted by some actions only, or by all others."""
        ...

    def is_end(self, node: Node) -> bool:
        """Whether the search may stop here."""
        ...

    @property
    def parts(self) -> Sequence[int]:
        """The numbers of the conjuncts of the goal, in the order to see to them."""
        ...

    def holds(self, parts: tuple[int, ...], node: Node) -> bool:
        """Whether these conjuncts of the goal hold."""
        ...

    def estimate(self, node: Node, parts: Sequence[int]) -> "tuple[int | None, frozenset[int]]":
        """How far these conjuncts seem (None: out of reach), and which actions seem to lead there."""
        ...

    def cost(self, move: Made) -> float:
        """What the move costs."""
        ...


class Search(NamedTuple, Generic[Node, Move]):
    """`path` to an end, without the start, or None; `visited` are the keys seen when there is none."""

    path: list[tuple[Move, Node]] | None
    visited: Iterable[Hashable] = ()


Algorithm = Callable[[Node, Graph[Node, Move]], Search[Node, Move]]


def breadth_first(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """The shortest path to an end; of equally short ones the first."""
    root = graph.key(start)
    parents: _Parents[Move, Node] = {root: None}
    queue, done = deque([(root, start)]), set[Hashable]()
    while queue:
        waiting, node = queue.popleft()
        parent = _expanded(waiting, node, graph, parents, done)
        if parent is None:
            continue
        if parent != waiting and graph.is_end(node):
            return Search(_path(parents, parent))
        for key, move, child in graph.successors(node):
            if key not in parents:
                parents[key] = parent, move, child
                if graph.is_end(child):
                    return Search(_path(parents, key))
                queue.append((key, child))
    return Search(None, parents.keys())


def cheapest_first(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """A path of least cost to an end (A* without a heuristic: knowledge that is sensed is not estimated admissibly)."""
    root = graph.key(start)
    parents: _Parents[Move, Node] = {root: None}
    costs: dict[Hashable, float] = {root: 0.0}
    queue: list[tuple[float, int, Hashable, Node]] = [(0.0, 0, root, start)]
    done: set[Hashable] = set()
    numbers = count(1)
    while queue:
        cost, number, waiting, node = heappop(queue)
        key = None if waiting in done else _expanded(waiting, node, graph, parents, done)
        if key is None:
            continue
        if number and graph.is_end(node):
            return Search(_path(parents, key))
        costs[key] = cost
        for child_key, move, child in graph.successors(node):
            total = cost + graph.cost(move)
            if child_key not in costs or total < costs[child_key]:
                costs[child_key], parents[child_key] = total, (key, move, child)
                heappush(queue, (total, next(numbers), child_key, child))
    return Search(None, parents.keys())


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


def iterative_deepening(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """A shortest path, by depth-first searches with growing limits; ends when a limit has cut nothing off."""
    limit = 1
    while True:
        path, depths = _depth_limited(start, graph, limit)
        if path is not None or limit not in depths.values():
            return Search(path, depths.keys())
        limit += 1


def greedy(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """Lazy greedy best-first search: nodes are estimated when they are expanded, by h_FF over knowledge."""
    found = _greedy(start, graph, graph.is_end, graph.parts, None, once=False)
    assert found is not None, "a search without a limit ends with an answer"
    return found


def serial(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
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
        step = _greedy(node, graph, arrived, wanted, SERIAL_EXPANSIONS, kept=reached)
        if step is None or step.path is None:
            step = _greedy(node, graph, arrived, wanted, SERIAL_EXPANSIONS)
        if step is None or step.path is None:
            return greedy(start, graph)
        reached = wanted
        if step.path:
            path += step.path
            node = path[-1][1]
        if graph.is_end(node):
            return Search(path)
    return Search(path) if path and graph.is_end(node) else greedy(start, graph)


def _all_hold(graph: Graph[Node, Move], parts: tuple[int, ...]) -> Callable[[Node], bool]:
    def reached(node: Node) -> bool:
        return graph.holds(parts, node) or graph.is_end(node)

    return reached


def _greedy(
    start: Node,
    graph: Graph[Node, Move],
    is_end: Callable[[Node], bool],
    parts: Sequence[int],
    limit: int | None,
    kept: tuple[int, ...] = (),
    once: bool = True,
) -> Search[Node, Move] | None:
    """Greedy search for some conjuncts of the goal, all those `kept` on the way; None if `limit` expansions did not do.

    Nodes wait with the estimate of their parent in two queues, one for those that preferred actions lead to; it gets
    more turns whenever the estimate improves [Fast Downward, LAMA's first iteration]. Where all other actions lead
    is not even looked at before their turn comes. Whatever is known the same as where the search has been waits one
    step longer for each time, or is left out if so wanted: nodes that only geometry tells apart seem equally far, and
    there is no end of them.
    """
    root = graph.key(start)
    parents: _Parents[Move, Node] = {root: None}
    done: set[Hashable] = set()
    every: _Queue[Node] = _Queue()
    promising: _Queue[Node] = _Queue()
    every.push(0, (root, start, None, 0))
    been: Counter[Hashable] = Counter()
    best: int | None = None
    while every.waiting or promising.waiting:
        first = promising.waiting and (promising.turns < every.turns or not every.waiting)
        queue = promising if first else every
        value, (waiting, node, preferred, counted) = queue.pop()
        known = graph.known(node)
        if preferred is None and been[known] > counted:
            if once:
                continue
            queue.push(value + been[known] - counted, (waiting, node, None, been[known]))
            continue
        key = waiting if preferred is not None else _expanded(waiting, node, graph, parents, done)
        if key is None:
            continue
        if preferred is None:
            if key != waiting and is_end(node):
                return Search(_path(parents, key))
            if limit is not None and len(done) > limit:
                return None
            estimate, preferred = graph.estimate(node, parts)
            if estimate is None:
                continue
            value = estimate + been[known]
            been[known] += 1
            if best is None or value < best:
                best = value
                promising.turns -= PREFERRED_TURNS
            successors = graph.successors(node, among=preferred)
            every.push(value, (key, node, preferred, 0))
            target = promising
        else:
            successors = graph.successors(node, without=preferred)
            target = every
        for child_key, move, child in successors:
            if child_key in parents:
                continue
            if kept and not graph.holds(kept, child):
                continue
            parents[child_key] = key, move, child
            if is_end(child) and graph.settled(child) is not None:
                return Search(_path(parents, child_key))
            target.push(value, (child_key, child, None, 0))
    return Search(None, parents.keys())


_Waiting = tuple[Hashable, Node, frozenset[int] | None, int]


class _Queue(Generic[Node]):
    """Nodes by estimate, the oldest of equals first; `turns` counts what was taken out.

    With a node waits nothing if it is to be expanded, and what was preferred if the rest of its successors is due;
    and how often the search had been where the same is known when the node began to wait.
    """

    def __init__(self) -> None:
        self.waiting: list[tuple[int, int, _Waiting[Node]]] = []
        self._count = 0
        self.turns = 0

    def push(self, value: int, waiting: "_Waiting[Node]") -> None:
        """Puts a node in."""
        self._count += 1
        heappush(self.waiting, (value, self._count, waiting))

    def pop(self) -> "tuple[int, _Waiting[Node]]":
        """Takes the nearest node out, with its estimate."""
        self.turns += 1
        value, _, waiting = heappop(self.waiting)
        return value, waiting


def _depth_first(start: Node, graph: Graph[Node, Move], most: int) -> tuple[Search[Node, Move], bool]:
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


def _expanded(
    waiting: Hashable, node: Node, graph: Graph[Node, Move], parents: "_Parents[Move, Node]", done: set[Hashable]
) -> Hashable | None:
    """The key of a node that is expanded now; None if geometry refuses it, or if that was done before."""
    key = graph.settled(node)
    if key is None or key in done:
        return None
    done.add(key)
    if key != waiting:
        parents[key] = parents[waiting]
    return key


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
            settled = graph.settled(node)
            if settled is None or (settled != key and depths.get(settled, limit + 1) <= depth):
                continue
            depths[settled] = depth
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


def _path(parents: "_Parents[Move, Node]", end: Hashable) -> list[tuple[Move, Node]]:
    path: list[tuple[Move, Node]] = []
    link = parents[end]
    while link is not None:
        parent, move, node = link
        path.append((move, node))
        link = parents[parent]
    return path[::-1]


SEARCHES: dict[str, Algorithm] = {  # type: ignore[type-arg]
    "breadth-first": breadth_first,
    "depth-first": depth_first,
    "iterative-deepening": iterative_deepening,
    "greedy": greedy,
    "astar": cheapest_first,
    "best": serial,
}
