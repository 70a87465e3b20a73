"""Inputs and outputs of the search: limits, the interface to geometry, skeletons and results.

A skeleton is a contingent plan without motions: a DAG whose equal continuations are one object, shared from the
leaves, with a single goal node [docs/plans.md#sharing].
"""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

from kabo.budgets import Spent
from kabo.knowledge import GroundAction
from kabo.language.formulas import GroundCall
from kabo.options import Search

Trace = Any  # opaque to the search, and hashable: which procedures made the present geometric components
# A component, and the number of the derivation that made its value; 0: as at the start.
Provenance = tuple[int, int]
Pattern = frozenset[Provenance]


@dataclass(frozen=True)
class Origin:
    """The origin of a component's value: an attempt at a call, and the provenances of the components it depended on."""

    call: GroundCall
    attempt: int
    reads: Pattern


@dataclass(frozen=True)
class LearntRefusals:
    """The nogoods of lazy geometry: for each call the attempt from which on it is refused, and in which situations.

    `named` are the provenances that refusals and suspicions name, and those from which they derive; `origins` says
    which calls make them. `suspicions`: patterns in which something was in the way of a call, all else left open.
    `moves`: the components that a call moves. `attempts`: the greatest number of attempts at one call.
    """

    named: tuple[Provenance, ...]
    origins: Mapping[Provenance, Sequence[Origin]]
    refusals: Mapping[GroundCall, Sequence[tuple[int, Pattern]]]
    suspicions: Mapping[GroundCall, Sequence[Pattern]]
    moves: Callable[[GroundCall], tuple[int, ...]]
    attempts: int


class Geometry(Protocol):
    """The interface of geometry to the search: known answers are looked up, calls not yet made are assumed to succeed."""

    @property
    def start(self) -> Trace:
        """The trace of the initial state."""
        ...

    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """The attempts at a call that may succeed, each with the trace after it; empty if the call is refused."""
        ...

    def key(self, trace: Trace) -> Hashable:
        """The part of a trace that distinguishes search nodes: equal keys have equal options and equal tests."""
        ...

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """The answer of a geometric test inside a formula; True where it is unknown."""
        ...

    def confirm(self, trace: Trace) -> bool:
        """Whether the call that led to a trace succeeds, as far as is known; called before a node is expanded."""
        ...

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The calls that are refused in every situation, and whether these are all refusals."""
        ...

    def learnt(self) -> LearntRefusals | None:
        """The refusals to compile into a finite-domain task; None if impossible or all in `refused_everywhere`."""
        ...

    def most_expansions(self, search: Search) -> float:
        """The number of expansions after which the search should stop and geometry offer more answers."""
        ...


@dataclass(frozen=True)
class SearchLimits:
    """The budget of a search: the number of expansions, and a function that returns True when time is up."""

    expansions: int | None = None
    deadline: Callable[[], bool] | None = None


@dataclass(frozen=True)
class SearchStatistics:
    """The figures of a search; `solved` counts the nodes for which a continuation was found."""

    expanded: int = 0
    generated: int = 0
    weak_searches: int = 0
    solved: int = 0

    def __add__(self, other: "SearchStatistics") -> "SearchStatistics":
        """The sum of two counts."""
        counts = ((getattr(self, each.name), getattr(other, each.name)) for each in fields(self))
        return SearchStatistics(*(one + more for one, more in counts))


@dataclass(frozen=True, eq=False)
class SkeletonNode:
    """A node of a skeleton; nodes of one skeleton are equal only if they are the same object.

    goal: nothing set. Action: `action`, `attempt` (which sample of its procedure) and `next`. Sensing action:
    `action` and either `on` with `outcomes`, or `delivers` with `next`. Branch on what was delivered before:
    `on` and `outcomes` without `action`. Outcomes stand in plan order: `false` before `true`, values as declared.
    """

    action: GroundAction | None = None
    attempt: int = 0
    on: str | None = None
    outcomes: tuple[tuple[str, "SkeletonNode"], ...] = ()
    next: "SkeletonNode | None" = None
    delivers: tuple[str, ...] = ()

    @property
    def is_goal(self) -> bool:
        """Whether the node is the goal node, at which execution stops."""
        return self.next is None and not self.outcomes

    @property
    def successors(self) -> tuple["SkeletonNode", ...]:
        """The nodes that may follow, in plan order."""
        return tuple(node for _, node in self.outcomes) if self.next is None else (self.next,)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A contingent plan without motions. Every leaf is the one goal node."""

    root: SkeletonNode

    def nodes(self) -> Iterator[SkeletonNode]:
        """All nodes once, breadth-first from the root; the goal comes last."""
        seen, queue, goal = {id(self.root)}, [self.root], None
        for node in queue:
            if node.is_goal:
                goal = node
                continue
            yield node
            for successor in node.successors:
                if id(successor) not in seen:
                    seen.add(id(successor))
                    queue.append(successor)
        if goal is not None:
            yield goal


@dataclass(frozen=True)
class FoundSkeleton:
    """A contingent plan in which every leaf fulfils the goal."""

    skeleton: Skeleton
    statistics: SearchStatistics


@dataclass(frozen=True)
class Unreachable:
    """Proven: there is no strong acyclic plan. `goals` are conjuncts that even the delete relaxation cannot reach."""

    statistics: SearchStatistics
    goals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exhausted:
    """The search ended without an answer because this budget was spent."""

    statistics: SearchStatistics
    budget: Spent


SearchResult = FoundSkeleton | Unreachable | Exhausted


@dataclass
class SkeletonBuilder:
    """Makes skeleton nodes, from the leaves to the root; equal nodes are the same object."""

    goal: SkeletonNode = field(default_factory=SkeletonNode)
    _nodes: dict[Hashable, SkeletonNode] = field(default_factory=dict)

    def act(
        self, action: GroundAction, attempt: int, delivered: tuple[str, ...], following: SkeletonNode
    ) -> SkeletonNode:
        """The node of an action before a continuation; a branch on what it delivers becomes part of this node."""
        if following.action is None and following.on in delivered:
            node = SkeletonNode(action, attempt, following.on, following.outcomes)
        else:
            node = SkeletonNode(action, attempt, next=following, delivers=delivered)
        return self._shared(node)

    def branch(self, fact: str, outcomes: tuple[tuple[str, SkeletonNode], ...]) -> SkeletonNode:
        """The node of a branch on a fact that was delivered before."""
        return self._shared(SkeletonNode(on=fact, outcomes=outcomes))

    def _shared(self, node: SkeletonNode) -> SkeletonNode:
        action = None if node.action is None else node.action.index
        followers = tuple((outcome, id(child)) for outcome, child in node.outcomes)
        identity = (action, node.attempt, node.on, followers, id(node.next), node.delivers)
        return self._nodes.setdefault(identity, node)
