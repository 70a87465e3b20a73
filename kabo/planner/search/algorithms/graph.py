"""The graph that weak searches explore for a path to an end node, and the outcome that they return."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, Protocol, TypeVar

Node = TypeVar("Node")
Move = TypeVar("Move")
Made = TypeVar("Made")


Parents = dict[Hashable, tuple[Hashable, Move, Node] | None]


class HeuristicValue(NamedTuple):
    """The estimated cost of a goal (None if unreachable), and the indices of preferred actions."""

    value: int | None
    preferred: frozenset[int]


class Graph(Protocol[Node, Made]):
    """The interface of graphs to searches; `successors` counts expansions and raises when the budget is spent."""

    def key(self, node: Node) -> Hashable:
        """The identity of a node."""
        ...

    def known(self, node: Node) -> Hashable:
        """The state of knowledge at a node; nodes that differ only in geometry share it."""
        ...

    def confirmed_key(self, node: Node) -> Hashable | None:
        """The key of a node about to be expanded, after its pending procedure calls were made; None if one is refused."""
        ...

    def successors(
        self, node: Node, *, among: frozenset[int] | None = None, without: frozenset[int] | None = None
    ) -> Iterable[tuple[Hashable, Made, Node]]:
        """The nodes one move away, each with its key; only by actions `among` these, or by all `without` these."""
        ...

    def is_end(self, node: Node) -> bool:
        """Whether the search may stop here."""
        ...

    @property
    def parts(self) -> Sequence[int]:
        """The numbers of the conjuncts of the goal, in the order in which to plan for them."""
        ...

    def holds(self, parts: tuple[int, ...], node: Node) -> bool:
        """Whether these conjuncts of the goal hold."""
        ...

    def estimate(self, node: Node, parts: Sequence[int]) -> HeuristicValue:
        """The estimated cost of these conjuncts of the goal, and the preferred actions."""
        ...

    def cost(self, move: Made) -> float:
        """The cost of the move."""
        ...

    def bound(self, node: Node) -> float | None:
        """A lower bound of the cost from a node to an end node; None if there is no path."""
        ...


@dataclass(frozen=True)  # no NamedTuple: before Python 3.11 these cannot be generic
class SearchOutcome(Generic[Node, Move]):
    """`path` to an end, without the start, or None; `visited` are the keys seen when there is none."""

    path: list[tuple[Move, Node]] | None
    visited: Iterable[Hashable] = ()


Algorithm = Callable[[Node, Graph[Node, Move]], SearchOutcome[Node, Move]]


def expanded(
    waiting: Hashable, node: Node, graph: Graph[Node, Move], parents: Parents[Move, Node], done: set[Hashable]
) -> Hashable | None:
    """The key of a node to be expanded now; None if geometry refuses it, or if it was expanded before."""
    key = graph.confirmed_key(node)
    if key is None or key in done:
        return None
    done.add(key)
    if key != waiting:
        parents[key] = parents[waiting]
    return key


def path_to(parents: Parents[Move, Node], end: Hashable) -> list[tuple[Move, Node]]:
    """The moves from the start to the node of a key, and where each leads."""
    path: list[tuple[Move, Node]] = []
    link = parents[end]
    while link is not None:
        parent, move, node = link
        path.append((move, node))
        link = parents[parent]
    return path[::-1]
