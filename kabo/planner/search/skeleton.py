"""Inputs and outputs of the search: limits, the interface to geometry, skeletons and results.

A skeleton is a contingent plan without motions: a directed acyclic graph with a single goal node, in which equal
continuations are one shared object [docs/reference/plans.md#sharing].
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
    """The origin of a component's value: an attempt at a call, and the provenances that the call depended on."""

    call: GroundCall
    attempt: int
    reads: Pattern


@dataclass(frozen=True)
class LearntRefusals:
    """The nogoods of lazy geometry: for each call, the attempts that are refused, and in which situations.

    `named`: the provenances that refusals and suspicions name, and those from which these derive. `origins`: the
    calls that make these provenances. `refusals`: for each call, the number of the first refused attempt and the
    provenances under which it is refused. `suspicions`: for each call, the provenances of components that blocked
    it. `moves`: a function that returns the components that a call moves. `attempts`: the greatest number of
    attempts at one call.
    """

    named: tuple[Provenance, ...]
    origins: Mapping[Provenance, Sequence[Origin]]
    refusals: Mapping[GroundCall, Sequence[tuple[int, Pattern]]]
    suspicions: Mapping[GroundCall, Sequence[Pattern]]
    moves: Callable[[GroundCall], tuple[int, ...]]
    attempts: int


class Geometry(Protocol):
    """The interface of geometry to the search: calls whose answer is not known are assumed to succeed."""

    @property
    def start(self) -> Trace:
        """The trace (the geometric part of a search node) of the initial state."""
        ...

    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """The attempts at a call that may succeed, each with the trace after it; none if the call is refused."""
        ...

    def key(self, trace: Trace) -> Hashable:
        """The part of a trace that distinguishes search nodes.

        Traces with equal keys have equal options and equal answers to tests.
        """
        ...

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """Whether a geometric test inside a formula succeeds at a trace; True if that is unknown."""
        ...

    def confirm(self, trace: Trace) -> bool:
        """Whether the call that led to a trace succeeds; asked just before a node is expanded."""
        ...

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The calls that are refused in every situation, and whether there are no other refusals."""
        ...

    def learnt(self) -> LearntRefusals | None:
        """The refusals to compile into a finite-domain task; None if that is impossible or not needed.

        It is not needed if `refused_everywhere` contains all refusals.
        """
        ...

    def most_expansions(self, search: Search) -> float:
        """The number of expansions after which the search should stop, so that geometry can offer more answers."""
        ...


@dataclass(frozen=True)
class SearchLimits:
    """The budget of a search: the greatest number of expansions, and a function that says when time is up.

    `told` is called with the number of expansions so far, often.
    """

    expansions: int | None = None
    deadline: Callable[[], bool] | None = None
    told: Callable[[int], None] | None = None


@dataclass(frozen=True)
class SearchStatistics:
    """The counts of a search; `solved` is the number of nodes for which a continuation was found."""

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
    """A node of a skeleton; nodes are compared by identity.

    A goal node has no field set. An action node has `action`, `attempt` (the index of the attempt at its procedure
    call) and `next`. A sensing action has `action`, and either `on` with `outcomes` (it branches at once) or
    `delivers` with `next` (a later node branches). A node that branches on a fact sensed earlier has `on` and
    `outcomes` without `action`. Outcomes are ordered: `false` before `true`, values as declared.
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
        """The nodes that may come next, in the order that plans use."""
        return tuple(node for _, node in self.outcomes) if self.next is None else (self.next,)


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A contingent plan without motions, in which every branch ends at the one goal node."""

    root: SkeletonNode

    def nodes(self) -> Iterator[SkeletonNode]:
        """Every node once, breadth-first from the root, except that the goal comes last."""
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
    """The proof that there is no strong acyclic plan.

    `goals`: the goal conjuncts that even the delete relaxation cannot reach.
    """

    statistics: SearchStatistics
    goals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exhausted:
    """The result of a search that ended without an answer because the named budget was spent."""

    statistics: SearchStatistics
    budget: Spent


SearchResult = FoundSkeleton | Unreachable | Exhausted


@dataclass
class SkeletonBuilder:
    """Builds a skeleton from the goal to the root, so that equal nodes are one object."""

    goal: SkeletonNode = field(default_factory=SkeletonNode)
    _nodes: dict[Hashable, SkeletonNode] = field(default_factory=dict)

    def act(
        self, action: GroundAction, attempt: int, delivered: tuple[str, ...], following: SkeletonNode
    ) -> SkeletonNode:
        """The node of an action before `following`; a branch on a fact in `delivered` becomes part of the node."""
        if following.action is None and following.on in delivered:
            node = SkeletonNode(action, attempt, following.on, following.outcomes)
        else:
            node = SkeletonNode(action, attempt, next=following, delivers=delivered)
        return self._shared(node)

    def branch(self, fact: str, outcomes: tuple[tuple[str, SkeletonNode], ...]) -> SkeletonNode:
        """The node that branches on a fact that was sensed earlier."""
        return self._shared(SkeletonNode(on=fact, outcomes=outcomes))

    def _shared(self, node: SkeletonNode) -> SkeletonNode:
        action = None if node.action is None else node.action.index
        followers = tuple((outcome, id(child)) for outcome, child in node.outcomes)
        identity = (action, node.attempt, node.on, followers, id(node.next), node.delivers)
        return self._nodes.setdefault(identity, node)
