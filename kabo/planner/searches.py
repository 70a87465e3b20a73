"""Weak search: one way to an end, with every sensed outcome as hoped for [K 6.2].

Each algorithm takes a start and a graph and returns the path to an end, or None with everything that it visited
when there is none. All are deterministic: successors are taken in the order in which the graph gives them.
"""

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

Node = TypeVar("Node")
Move = TypeVar("Move")
Made_co = TypeVar("Made_co", covariant=True)


class Graph(Protocol[Node, Made_co]):
    """What a search needs; `successors` counts the expansion and raises when the budget is spent."""

    def key(self, node: Node) -> Hashable:
        """What tells nodes apart."""
        ...

    def successors(self, node: Node) -> Iterable[tuple[Hashable, Made_co, Node]]:
        """The nodes one move away, each with its key."""
        ...

    def is_end(self, node: Node) -> bool:
        """Whether the search may stop here."""
        ...


@dataclass(frozen=True)
class Search(Generic[Node, Move]):
    """`path` to an end, without the start, or None; `visited` are the keys seen when there is none."""

    path: list[tuple[Move, Node]] | None
    visited: Iterable[Hashable] = ()


Algorithm = Callable[[Node, Graph[Node, Move]], Search[Node, Move]]


def breadth_first(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """The shortest path to an end; of equally short ones the first."""
    root = graph.key(start)
    parents: dict[Hashable, tuple[Hashable, Move, Node] | None] = {root: None}
    queue = deque([(root, start)])
    while queue:
        parent, node = queue.popleft()
        for key, move, child in graph.successors(node):
            if key not in parents:
                parents[key] = parent, move, child
                if graph.is_end(child):
                    return Search(_path(parents, key))
                queue.append((key, child))
    return Search(None, parents.keys())


def depth_first(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """The first path that following first successors meets; no node is expanded twice."""
    visited = {graph.key(start)}
    stack = [iter(graph.successors(start))]
    path: list[tuple[Move, Node]] = []
    while stack:
        step = _first_new(stack[-1], visited)
        if step is None:
            stack.pop()
            if path:
                path.pop()
            continue
        path.append(step)
        if graph.is_end(step[1]):
            return Search(path)
        stack.append(iter(graph.successors(step[1])))
    return Search(None, visited)


def iterative_deepening(start: Node, graph: Graph[Node, Move]) -> Search[Node, Move]:
    """A shortest path, by depth-first searches with growing limits; ends when a limit has cut nothing off."""
    limit = 1
    while True:
        path, depths = _depth_limited(start, graph, limit)
        if path is not None or limit not in depths.values():
            return Search(path, depths.keys())
        limit += 1


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
            path.append((move, node))
            stack.append(iter(graph.successors(node)))
    return None, depths


def _first_new(steps: Iterator[tuple[Hashable, Move, Node]], visited: set[Hashable]) -> tuple[Move, Node] | None:
    for key, move, node in steps:
        if key not in visited:
            visited.add(key)
            return move, node
    return None


def _path(parents: dict[Hashable, tuple[Hashable, Move, Node] | None], end: Hashable) -> list[tuple[Move, Node]]:
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
}
