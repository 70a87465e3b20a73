"""The interface of the graph in which weak searches look for a path, and the type of their outcome."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

Node = TypeVar("Node")
Move = TypeVar("Move")
Made = TypeVar("Made")


Parents = dict[Hashable, tuple[Hashable, Move, Node] | None]


class HeuristicValue(NamedTuple):
    """The estimated cost to reach a goal (None if unreachable), and the indices of the preferred actions."""

    value: int | None
    preferred: frozenset[int]


class Graph(Protocol[Node, Made]):
    """The graph that a search explores; `successors` counts expansions and raises when the budget is spent."""

    def key(self, node: Node) -> Hashable:
        """The key of a node; nodes with equal keys are the same to the search."""
        ...

    def known(self, node: Node) -> Hashable:
        """The knowledge state of a node; nodes that differ only in geometry have the same."""
        ...

    def confirmed_key(self, node: Node) -> Hashable | None:
        """The key of a node after its pending procedure calls were made; None if one of them is refused.

        Searches call this when a node is about to be expanded.
        """
        ...

    def successors(
        self, node: Node, *, among: frozenset[int] | None = None, without: frozenset[int] | None = None
    ) -> Iterable[tuple[Hashable, Made, Node]]:
        """The nodes one move away, each with its key and the move.

        `among`: if given, only actions with these indices are used. `without`: actions with these indices are
        skipped.
        """
        ...

    def is_end(self, node: Node) -> bool:
        """Whether the node is an end node, at which the search may stop."""
        ...

    @property
    def parts(self) -> Sequence[int]:
        """The indices of the goal conjuncts, in the order in which to plan for them."""
        ...

    def holds(self, parts: tuple[int, ...], node: Node) -> bool:
        """Whether the goal conjuncts with these indices hold at a node."""
        ...

    def estimate(self, node: Node, parts: Sequence[int]) -> HeuristicValue:
        """The estimated cost to reach the goal conjuncts with these indices, and the preferred actions."""
        ...

    def cost(self, move: Made) -> float:
        """The cost of a move."""
        ...

    def bound(self, node: Node) -> float | None:
        """A lower bound of the cost from a node to an end node; None if there is no path."""
        ...


@dataclass(frozen=True)  # no NamedTuple: before Python 3.11 these cannot be generic
class SearchOutcome(Generic[Node, Move]):
    """The outcome of a search: the path to an end node, without the start, or the visited keys.

    `path` is None if there is no path; only then `visited` holds the keys of the nodes that the search visited.
    """

    path: list[tuple[Move, Node]] | None
    visited: Iterable[Hashable] = ()


Algorithm = Callable[[Node, Graph[Node, Move]], SearchOutcome[Node, Move]]


def expanded(
    waiting: Hashable, node: Node, graph: Graph[Node, Move], parents: Parents[Move, Node], done: set[Hashable]
) -> Hashable | None:
    """The key of a node that is to be expanded now, marked as done; None if it is refused or already done."""
    key = graph.confirmed_key(node)
    if key is None or key in done:
        return None
    done.add(key)
    if key != waiting:
        parents[key] = parents[waiting]
    return key


def path_to(parents: Parents[Move, Node], end: Hashable) -> list[tuple[Move, Node]]:
    """The path from the start to the node with the key `end`: each move with the node that it leads to."""
    path: list[tuple[Move, Node]] = []
    link = parents[end]
    while link is not None:
        parent, move, node = link
        path.append((move, node))
        link = parents[parent]
    return path[::-1]
