"""Finds skeletons of tasks without sensing by the packed searches of `kabo.finite_domain`."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

from kabo import finite_domain, tuning
from kabo.budgets import Spent
from kabo.knowledge import GroundedTask, unreachable_goals
from kabo.knowledge.facts import open_entries
from kabo.options import Search
from kabo.planner.search.delete_relaxation import Relaxation
from kabo.planner.search.skeleton import (
    Exhausted,
    FoundSkeleton,
    Geometry,
    LearntRefusals,
    SearchLimits,
    SearchResult,
    SearchStatistics,
    Skeleton,
    SkeletonBuilder,
    SkeletonNode,
    Unreachable,
)


class PackedTask:
    """A task prepared for the packed searches of `kabo.finite_domain`; it is compiled at the first use."""

    def __init__(self, task: GroundedTask) -> None:
        self.task = task

    @cached_property
    def compiled(self) -> "finite_domain.CompiledTask | None":
        """The compiled finite-domain task, or None if finite domains cannot express the task.

        Of a task with sensing only the actions that sense nothing are compiled, if the goal may be reached with them.
        """
        # Loads the searches in finite domains (20 files), which a task that needs sensing never needs.
        from kabo.planner.search.to_finite_domain import classical_task

        task = self.task if not self.task.branchings else _without_sensing(self.task)
        return None if task is None else classical_task(task)

    def linear(self, geometry: Geometry | None, limits: SearchLimits) -> FoundSkeleton | None:
        """A skeleton of a task with sensing that senses nothing; None if none is found with a limited effort.

        The effort is a number of expansions, so the answer does not depend on the speed of the machine.
        """
        most = tuning.MAX_LINEAR_EXPANSIONS
        most = most if limits.expansions is None else min(most, limits.expansions)
        found = self.skeleton("best", geometry, SearchLimits(most, limits.deadline, limits.told))
        return found if isinstance(found, FoundSkeleton) else None

    def skeleton(self, search: Search, geometry: Geometry | None, limits: SearchLimits) -> SearchResult | None:
        """The result of a packed search; None if finite domains cannot express the task or its refused calls.

        Args:
            search: `best`, `astar` or `breadth-first`.
            geometry: the refused calls; None for purely symbolic planning.
            limits: the budget.
        """
        compiled = self.compiled
        if compiled is None:
            return None
        if geometry is None:
            return self._result(_searched(compiled, search, None, limits), compiled, None, limits)
        refused, is_all = geometry.refused_everywhere()
        learnt_refusals = geometry.learnt()
        if is_all and (learnt_refusals is None or not learnt_refusals.suspicions):
            calls = [self.task.actions[operator.owner].call for operator in compiled.task.operators]
            forbidden = [int(call in refused) for call in calls]
            return self._result(
                _searched(compiled, search, forbidden, limits, learnt_refusals), compiled, None, limits
            )
        if learnt_refusals is None:
            return None
        from kabo.planner.search.compiled_refusals import learnt_task  # only a task with refusals needs it

        learnt = learnt_task(compiled.task, self.task.actions, learnt_refusals)
        found = _searched(learnt.compiled, search, None, limits, learnt_refusals)
        if found.status == "unsolvable" and not learnt.whole:
            return None
        return self._result(found, learnt.compiled, learnt.attempts, limits)

    def _result(
        self,
        found: "finite_domain.SearchResult",
        compiled: "finite_domain.CompiledTask",
        attempts: Sequence[int] | None,
        limits: SearchLimits,
    ) -> SearchResult:
        statistics = SearchStatistics(found.expanded, found.generated, 1, 1)
        if found.status == "unsolvable":
            return Unreachable(statistics, tuple(unreachable_goals(self.task)))
        if found.plan is None:
            return Exhausted(statistics, _spent(found, limits))
        builder = SkeletonBuilder()
        node: SkeletonNode = builder.goal
        for number in reversed(found.plan):
            action = self.task.actions[compiled.task.operators[number].owner]
            node = builder.act(action, 0 if attempts is None else attempts[number], (), node)
        return FoundSkeleton(Skeleton(node), statistics)


def _without_sensing(task: GroundedTask) -> GroundedTask | None:
    """The task without what it may sense; None if its goal is out of reach then, even under delete relaxation."""
    if open_entries(task.initial, task.pending):
        return None  # these are branched on at once
    opened = {
        id(update): open_entries(update.make, task.pending)
        for action in task.actions
        for update in action.effects.updates
    }
    kept = tuple(
        action
        for action in task.actions
        if not action.sense and not any(opened[id(update)] for update in action.effects.updates)
    )
    plain = replace(task, actions=kept, branchings={}, pending=0)
    found = Relaxation(plain).estimate(task.initial, range(len(task.goal)))
    return None if found.value is None else plain


def _spent(found: "finite_domain.SearchResult", limits: SearchLimits) -> Spent:
    """What ended a search without an answer: the deadline, the number of expansions, or the bytes for its states."""
    if found.status == "stopped":
        return "time"
    return "expansions" if limits.expansions is not None and found.expanded >= limits.expansions else "memory"


def _searched(
    compiled: "finite_domain.CompiledTask",
    search: Search,
    forbidden: list[int] | None,
    limits: SearchLimits,
    learnt_refusals: LearntRefusals | None = None,
) -> "finite_domain.SearchResult":
    """The answer of a search by its name; where refusals were learnt, `best` first tries A* for a limited time."""
    budget = finite_domain.SearchBudget(expansions=limits.expansions, stop=limits.deadline, told=limits.told)
    if search == "best" and learnt_refusals is not None:
        most = tuning.MAX_CHEAPEST_EXPANSIONS
        most = most if limits.expansions is None else min(most, limits.expansions)
        found = finite_domain.astar(compiled, forbidden=forbidden, budget=replace(budget, expansions=most))
        if found.status in ("solved", "unsolvable"):
            return found
    if search == "best":
        return finite_domain.bfws(compiled, forbidden=forbidden, budget=budget)
    run = finite_domain.astar if search == "astar" else finite_domain.breadth_first
    return run(compiled, forbidden=forbidden, budget=budget)
