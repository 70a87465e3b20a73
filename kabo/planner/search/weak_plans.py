"""The graph for weak searches: each sensed outcome may be assumed; choices known to fail are left out."""

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from kabo.knowledge import GroundAction
from kabo.planner.search.algorithms.graph import HeuristicValue
from kabo.planner.search.nodes import Act, Assume, Node, SearchSpace, Step
from kabo.planner.search.nogoods import Choice, Nogoods
from kabo.planner.search.skeleton import SearchLimits, SearchStatistics, Trace

DEADLINE_EVERY = 64  # expansions between two looks at the deadline
PROGRESS_EVERY = 4096  # expansions between two reports

OnProgress = Callable[[SearchStatistics], None]
# An action, the attempt at its call and the trace after it; None: only an open branching.
Try = tuple[GroundAction, int, Trace] | None
Move = tuple[Try, tuple[Assume, ...]]  # what is tried, and the outcomes that are assumed of what it senses


class BudgetSpent(Exception):
    """Raised when the budget of a search is spent; caught in `find_skeleton`."""

    def __init__(self, budget: Literal["expansions", "time"]) -> None:
        self.budget = budget
        super().__init__(budget)


@dataclass
class Counter:
    """Counts the expansions and other work of a search, and ends the search when its budget is spent."""

    limits: SearchLimits
    on_progress: OnProgress | None = None
    expanded: int = 0
    generated: int = 0
    weak_searches: int = 0
    solved: int = 0

    @property
    def statistics(self) -> SearchStatistics:
        """The counts so far."""
        return SearchStatistics(self.expanded, self.generated, self.weak_searches, self.solved)

    def add(self, other: "Counter") -> None:
        """Adds the counts of another counter to this one."""
        self.expanded += other.expanded
        self.generated += other.generated
        self.weak_searches += other.weak_searches
        self.solved += other.solved

    def expand(self) -> None:
        """Counts one expansion.

        Raises:
            BudgetSpent: the limit of expansions is exceeded, or time is up.
        """
        if self.limits.expansions is not None and self.expanded >= self.limits.expansions:
            raise BudgetSpent("expansions")
        if self.expanded % DEADLINE_EVERY == 0:
            self.look_at_the_clock()
        self.expanded += 1
        if self.on_progress is not None and self.expanded % PROGRESS_EVERY == 0:
            self.on_progress(self.statistics)

    def look_at_the_clock(self) -> None:
        """Checks whether time is up.

        Raises:
            BudgetSpent: time is up.
        """
        if self.limits.told is not None:
            self.limits.told(self.expanded)
        deadline = self.limits.deadline
        if deadline is not None and deadline():
            raise BudgetSpent("time")


class WeakGraph:
    """The graph that a weak search explores.

    `blocked` collects the ancestors that the search would have had to visit again.
    """

    def __init__(
        self,
        space: SearchSpace,
        nogoods: Nogoods,
        counter: Counter,
        is_end: Callable[[Node], bool],
        first: Sequence[int] = (),
        *,
        only_goals_end: bool = False,
    ) -> None:
        others = (number for number in range(len(space.task.goal)) if number not in first)
        # The numbers of the conjuncts of the goal, in the order in which they are planned for.
        self.parts = [*first, *others]
        self.holds = space.holds
        self.blocked: set[Hashable] = set()
        self.key, self.known, self.confirmed_key = space.key, space.known, space.confirmed_key
        self._is_end = is_end
        self._only_goals_end = only_goals_end
        self._space, self._nogoods, self._counter = space, nogoods, counter

    def successors(
        self, node: Node, *, among: frozenset[int] | None = None, without: frozenset[int] | None = None
    ) -> Iterator[tuple[Hashable, Move, Node]]:
        """The nodes that one action leads to, for every combination of assumed outcomes of what it senses.

        Args:
            node: the node to expand.
            among: if given, only actions with these indices are used, besides branching.
            without: skip the actions with these indices; the expansion is then not counted again.
        """
        if without is None:
            self._counter.expand()
        key = self.key(node)
        for tried, after in self._moves(node, among, without):
            if tried is not None and self._is_banned(key, (tried[0].index, tried[1])):
                continue
            for decided, leaf in self._space.leaves(after):
                if tried is None and (not decided or self._is_banned(key, choice_of(decided[0]))):
                    continue
                self._counter.generated += 1
                leaf_key = self.key(leaf)
                failure = self._nogoods.of_node(leaf_key, leaf[0])
                if failure is None:
                    yield leaf_key, (tried, decided), leaf
                else:
                    self.blocked |= failure.blocked

    def is_end(self, node: Node) -> bool:
        """Whether the search may stop at a node; pending procedure calls are made first, and may be refused."""
        return self._is_end(node) and self.confirmed_key(node) is not None

    def _is_banned(self, key: Hashable, choice: Choice) -> bool:
        """Whether a choice has failed at a node; the ancestors that it depended on are then added to `blocked`."""
        failure = self._nogoods.of_choice(key, choice)
        if failure is not None:
            self.blocked |= failure.blocked
        return failure is not None

    def estimate(self, node: Node, parts: Sequence[int]) -> HeuristicValue:
        """The cost of a relaxed plan to some goal conjuncts, and the actions with which it can begin."""
        return self._space.heuristic.estimate(node[0], parts)

    def cost(self, move: Move) -> float:
        """The cost of a move's action; 0 for a move that only branches."""
        return 0.0 if move[0] is None else move[0][0].cost

    def bound(self, node: Node) -> float | None:
        """A lower bound of the cost from a node to an end node; None if no end node can be reached.

        The bound is 0 if solved nodes count as end nodes as well, since one of them may be near.
        """
        return self._space.heuristic.lower_bound(node[0]) if self._only_goals_end else 0.0

    def _moves(
        self, node: Node, among: frozenset[int] | None, without: frozenset[int] | None
    ) -> Iterator[tuple[Try, Node]]:
        if self._space.task.open_branching(node[0]) is not None:
            if without is None:
                yield None, node
            if not self._space.may_wait:
                return
        for action, attempt, after in self._space.moves(node, among, without or frozenset()):
            yield (action, attempt, after[1]), after


def steps_of(path: list[tuple[Move, Node]]) -> list[Step]:
    """The path of a weak search as a list of steps: each action, followed by the outcomes assumed after it."""
    steps: list[Step] = []
    for (tried, decided), _ in path:
        if tried is not None:
            steps.append(Act(*tried))
        steps += decided
    return steps


def choice_of(step: Step) -> Choice:
    """The choice that a step makes at its node: the entry it branches on, or the action and attempt."""
    return step.branching.entry if isinstance(step, Assume) else (step.action.index, step.attempt)
