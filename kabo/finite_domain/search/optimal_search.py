"""A* with LM-cut: a plan of least cost, proven."""

from collections.abc import Sequence
from heapq import heappop, heappush
from typing import Any

from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain import search
from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget, as_number
from kabo.finite_domain.result import SearchResult


def astar(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: SearchBudget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan of least cost; or the proof that there is none.

    Args:
        compiled: the task.
        start: the values of all variables at the start; None: the task's initial values.
        forbidden: (operators,) 1 for each operator that must not be used, 0 for all others; None: all may be used.
        budget: the limits of the search; when they end it, the result is "exhausted" or "stopped".
        plain_work: the number of states that plain Python generates, by rising cost and without a heuristic,
            before the compiled search starts over. Where several plans have least cost, plain Python and compiled
            code may find different ones.
    """
    budget = budget or SearchBudget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    work = tuning.PLAIN_ASTAR_STATES if plain_work is None else plain_work
    found = _plain(compiled, packed, never, budget, work)
    if found is None:
        found = search.astar_compiled(compiled, packed, never, budget)
    return found


def _plain(
    compiled: CompiledTask, start: int, never: Never, budget: SearchBudget, work: int
) -> SearchResult | None:
    """Uniform-cost search in plain Python; None once it has generated `work` states."""
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
