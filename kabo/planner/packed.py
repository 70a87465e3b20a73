"""Skeletons of tasks without sensing, found by the packed searches of `kabo.finite_domain`."""

from collections.abc import Callable

from kabo.finite_domain import Budget, CompiledTask, SearchResult, astar, bfws, breadth_first
from kabo.knowledge import Task, unreachable_goals
from kabo.planner.skeleton import (
    Exhausted,
    Found,
    Geometry,
    Limits,
    Skeleton,
    SkeletonBuilder,
    SkeletonNode,
    Statistics,
    Unreachable,
)
from kabo.planner.skeleton import (
    SearchResult as Answer,
)

PLAIN_PAIRS = (
    200_000  # pairs of facts that novelty search looks at in plain Python before it goes over to a kernel
)

PackedSearch = Callable[[CompiledTask, "list[int] | None", Budget], SearchResult]


def _bfws(compiled: CompiledTask, forbidden: "list[int] | None", budget: Budget) -> SearchResult:
    work = PLAIN_PAIRS // max(1, len(compiled.task.variables) ** 2)
    return bfws(compiled, forbidden=forbidden, budget=budget, plain_work=min(work, 3000))


PACKED: dict[str, PackedSearch] = {
    "breadth-first": lambda compiled, forbidden, budget: breadth_first(
        compiled, forbidden=forbidden, budget=budget
    ),
    "astar": lambda compiled, forbidden, budget: astar(compiled, forbidden=forbidden, budget=budget),
    "best": _bfws,
}


def packed_skeleton(
    task: Task, compiled: CompiledTask, search: str, geometry: Geometry | None, limits: Limits
) -> Answer | None:
    """The answer of a packed search; None if geometry has refused something in some situations only.

    Args:
        task: the knowledge task.
        compiled: the same for packed searches; its operators are owned by the actions.
        search: a key of `PACKED`.
        geometry: what is refused.
        limits: the budget.
    """
    forbidden = None
    if geometry is not None:
        refused = geometry.refused_everywhere()
        if refused is None:
            return None
        calls = [task.actions[operator.owner].call for operator in compiled.task.operators]
        forbidden = [int(call in refused) for call in calls]
    budget = Budget(expansions=limits.expansions, stop=limits.deadline)
    found = PACKED[search](compiled, forbidden, budget)
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
