"""Skeletons of tasks without sensing, found by the packed searches of `kabo.finite_domain`."""

from functools import cached_property
from typing import TYPE_CHECKING

from kabo.knowledge import Task, unreachable_goals
from kabo.planner.skeleton import (
    Exhausted,
    Found,
    Geometry,
    Limits,
    SearchResult,
    Skeleton,
    SkeletonBuilder,
    SkeletonNode,
    Statistics,
    Unreachable,
)

if TYPE_CHECKING:  # loaded where a task without sensing needs them
    from kabo.finite_domain import CompiledTask
    from kabo.finite_domain import SearchResult as PackedResult


class PackedTask:
    """A task prepared for packed searches when one is first asked for."""

    def __init__(self, task: Task) -> None:
        self.task = task

    @cached_property
    def compiled(self) -> "CompiledTask | None":
        """The task in finite domains, its operators owned by the actions; None if it cannot be said so."""
        from kabo.planner.classical import classical_task

        return classical_task(self.task)

    def skeleton(self, search: str, geometry: Geometry | None, limits: Limits) -> SearchResult | None:
        """The answer of a packed search.

        None if the task cannot be said in finite domains, or if geometry has refused something in some situations only.

        Args:
            search: `best`, `astar` or `breadth-first`.
            geometry: what is refused.
            limits: the budget.
        """
        task, compiled = self.task, self.compiled
        if compiled is None:
            return None
        forbidden = None
        if geometry is not None:
            refused, is_all = geometry.refused_everywhere()
            if not is_all:
                return None
            calls = [task.actions[operator.owner].call for operator in compiled.task.operators]
            forbidden = [int(call in refused) for call in calls]
        found = _searched(compiled, search, forbidden, limits)
        statistics = Statistics(found.expanded, found.generated, 1, 1)
        if found.status == "unsolvable":
            return Unreachable(statistics, tuple(unreachable_goals(task)))
        if found.plan is None:
            return Exhausted(statistics, "time" if found.status == "stopped" else "expansions")
        builder = SkeletonBuilder()
        node: SkeletonNode = builder.goal
        for number in reversed(found.plan):
            node = builder.act(task.actions[compiled.task.operators[number].owner], 0, (), node)
        return Found(Skeleton(node), statistics)


def _searched(
    compiled: "CompiledTask", search: str, forbidden: "list[int] | None", limits: Limits
) -> "PackedResult":
    from kabo.finite_domain import Budget, astar, bfws, breadth_first

    budget = Budget(expansions=limits.expansions, stop=limits.deadline)
    if search == "best":
        return bfws(compiled, forbidden=forbidden, budget=budget)
    run = astar if search == "astar" else breadth_first
    return run(compiled, forbidden=forbidden, budget=budget)
