"""A* with LM-cut: the least cost, proven."""

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Any

from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain.compiled_task import Budget, CompiledTask, Never, as_number
from kabo.finite_domain.result import SearchResult


def astar(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: Budget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan of least cost; or the proof that there is none.

    Args:
        compiled: the task.
        start: values of all variables, instead of the task's initial ones.
        forbidden: 1 for each operator that must not be used.
        budget: how long; a search that it ends is "exhausted" or "stopped".
        plain_work: how many states plain Python generates, by rising cost and without a heuristic, before the compiled
            search starts over; of several plans of least cost that may give another.
    """
    budget = budget or Budget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    work = tuning.PLAIN_ASTAR_STATES if plain_work is None else plain_work
    found = _plain(compiled, packed, never, budget, work)
    if found is None:
        from kabo.finite_domain.search.compiled_astar import search

        found = search(compiled, packed, never, budget)
    return found


def _plain(compiled: CompiledTask, start: int, never: Never, budget: Budget, work: int) -> SearchResult | None:
    """By rising cost in plain Python; None: it is larger than `work` generated states."""
    plain, banned, operators = compiled.plain, as_number(never), compiled.task.operators
    costs, parents = {start: 0}, dict[int, tuple[int, int]]()
    queue, found, done = [(0, 0, start)], 0, set[int]()
    expanded = generated = 0
    while queue:
        cost, _, state = heappop(queue)
        if state in done:
            continue
        done.add(state)
        if plain.at_goal(state):
            plan = []
            while state in parents:
                state, o = parents[state]
                plan.append(o)
            return SearchResult(
                "solved", tuple(reversed(plan)), cost, expanded, generated, len(costs), optimal=True
            )
        if generated >= work:
            return None
        if not budget.left(expanded, 1):
            return SearchResult("exhausted", None, None, expanded, generated, len(costs))
        if expanded % 256 == 255 and budget.stopped():
            return SearchResult("stopped", None, None, expanded, generated, len(costs))
        expanded += 1
        for o in plain.applicable(state, banned):
            after, total = plain.after(state, o), cost + operators[o].cost
            generated += 1
            if total < costs.get(after, total + 1):
                found += 1
                costs[after], parents[after] = total, (state, o)
                heappush(queue, (total, found, after))
    return SearchResult("unsolvable", None, None, expanded, generated, len(costs))
