"""What the symbolic search gives and takes: skeletons, limits, results, and geometry as the search may see it.

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
Provenance = tuple[int, int]  # a component, by its number, and which lineage its value has; 0: as at the start
Pattern = frozenset[Provenance]


@dataclass(frozen=True)
class Origin:
    """What made a lineage: an attempt at a call, where these lineages were what its samples depended on."""

    call: GroundCall
    attempt: int
    reads: Pattern


@dataclass(frozen=True)
class LearntRefusals:
    """All that lazy geometry has learnt: by call, the attempt from which on it is refused, and where.

    `named` are the lineages that refusals and suspicions name, and those that these come from; `origins` says which
    calls make them. `suspicions`: where something was in the way of a call, whatever else was so. `attempts`: how many
    there are of one call at most. `moves`: the components that a call moves.
    """

    named: tuple[Provenance, ...]
    origins: Mapping[Provenance, Sequence[Origin]]
    refusals: Mapping[GroundCall, Sequence[tuple[int, Pattern]]]
    suspicions: Mapping[GroundCall, Sequence[Pattern]]
    moves: Callable[[GroundCall], tuple[int, ...]]
    attempts: int


class Geometry(Protocol):
    """Geometry as the search sees it: bookkeeping only, and optimistic where nothing has been evaluated."""

    @property
    def start(self) -> Trace:
        """The trace of the initial state."""
        ...

    def options(self, call: GroundCall, trace: Trace) -> Sequence[tuple[int, Trace]]:
        """The attempts that may succeed, each with the trace after it; empty means refused."""
        ...

    def key(self, trace: Trace) -> Hashable:
        """What of the trace tells search nodes apart: equal keys have equal options and equal tests."""
        ...

    def test(self, call: GroundCall, trace: Trace) -> bool:
        """A geometric test inside a formula; True where unknown."""
        ...

    def confirm(self, trace: Trace) -> bool:
        """Whether what a trace comes from has succeeded, for all that is known when a node is about to be expanded."""
        ...

    def refused_everywhere(self) -> "tuple[frozenset[GroundCall], bool]":
        """The calls that are refused whatever was done before, and whether nothing else is refused."""
        ...

    def learnt(self) -> LearntRefusals | None:
        """All that is known of geometry, for compiling it into the task; None if that is not possible."""
        ...

    def most_expansions(self, search: Search) -> float:
        """The number of expansions after which the search should stop and geometry offer more answers."""
        ...


@dataclass(frozen=True)
class SearchLimits:
    """The budget of a search: `expansions` are counted, `deadline` says when to give up (it only cuts off)."""

    expansions: int | None = None
    deadline: Callable[[], bool] | None = None


@dataclass(frozen=True)
class SearchStatistics:
    """What a search did; `solved` counts the nodes for which a continuation was found."""

    expanded: int = 0
    generated: int = 0
    weak_searches: int = 0
    solved: int = 0

    def __add__(self, other: "SearchStatistics") -> "SearchStatistics":
        """What two searches did."""
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
        """Whether execution stops here."""
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
    """Proven: no strong acyclic plan. `goals` are conjuncts out of reach even if nothing were ever lost."""

    statistics: SearchStatistics
    goals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exhausted:
    """Nothing is known: the budget named ended the search."""

    statistics: SearchStatistics
    budget: Spent


SearchResult = FoundSkeleton | Unreachable | Exhausted


@dataclass
class SkeletonBuilder:
    """Makes skeleton nodes, from the leaves; asked for an equal node it gives the same object."""

    goal: SkeletonNode = field(default_factory=SkeletonNode)
    _nodes: dict[Hashable, SkeletonNode] = field(default_factory=dict)

    def act(
        self, action: GroundAction, attempt: int, delivered: tuple[str, ...], following: SkeletonNode
    ) -> SkeletonNode:
        """The action before a continuation; a branch on what it delivers becomes part of its node."""
        if following.action is None and following.on in delivered:
            node = SkeletonNode(action, attempt, following.on, following.outcomes)
        else:
            node = SkeletonNode(action, attempt, next=following, delivers=delivered)
        return self._shared(node)

    def branch(self, fact: str, outcomes: tuple[tuple[str, SkeletonNode], ...]) -> SkeletonNode:
        """A decision on a fact that was delivered before."""
        return self._shared(SkeletonNode(on=fact, outcomes=outcomes))

    def _shared(self, node: SkeletonNode) -> SkeletonNode:
        action = None if node.action is None else node.action.index
        followers = tuple((outcome, id(child)) for outcome, child in node.outcomes)
        identity = (action, node.attempt, node.on, followers, id(node.next), node.delivers)
        return self._nodes.setdefault(identity, node)
