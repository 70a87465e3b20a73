"""Breadth-first search: a plan of fewest actions, or the proof that there is no plan."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain import search
from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget, as_number
from kabo.finite_domain.result import SearchResult


def breadth_first(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: SearchBudget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan with the fewest actions, whatever they cost; or the proof that there is none.

    Args:
        compiled: the task.
        start: the values of all variables at the start; None: the task's initial values.
        forbidden: (operators,) 1 for each operator that must not be used, 0 for all others; None: all may be used.
        budget: the limits of the search; when they end it, the result is "exhausted" or "stopped".
        plain_work: the number of states that plain Python generates before the compiled search starts over; None:
            as many as it generates, over all searches of this task, in about the time of loading the kernel. Plain
            Python and compiled code find the same plan.
    """
    budget = budget or SearchBudget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    if compiled.plain.at_goal(packed):
        return SearchResult("solved", (), 0, 0, 0, 1, optimal=True)
    if plain_work is None:
        loaded = _compiled.cache_info().currsize
        plain_work = 0 if loaded else compiled.plain_left("breadth-first", tuning.PLAIN_BREADTH_FIRST_STATES)
    found = _plain(compiled, packed, never, budget, plain_work) if plain_work else None
    compiled.spend("breadth-first", found.generated if found else plain_work)
    return found or _compiled()(compiled, packed, never, budget)


def _plain(
    compiled: CompiledTask, start: int, never: Never, budget: SearchBudget, work: int
) -> SearchResult | None:
    """The search in plain Python; None once it has generated `work` states."""
    plain, banned = compiled.plain, as_number(never)
    parents: dict[int, tuple[int, int] | None] = {start: None}
    queue, generated = [start], 0
    for expanded, state in enumerate(queue):
        if generated >= work:
            return None
        if not budget.left(expanded, 1):
            return SearchResult("exhausted", None, None, expanded, generated, len(queue))
        if expanded % 256 == 255 and budget.stopped():
            return SearchResult("stopped", None, None, expanded, generated, len(queue))
        for o in plain.applicable(state, banned):
            after = plain.after(state, o)
            generated += 1
            if after in parents:
                continue
            parents[after] = (state, o)
            queue.append(after)
            if plain.at_goal(after):
                plan = _path(parents, after)
                cost = compiled.cost(plan)
                return SearchResult("solved", plan, cost, expanded + 1, generated, len(queue), optimal=True)
    return SearchResult("unsolvable", None, None, len(queue), generated, len(queue))


def _path(parents: dict[int, tuple[int, int] | None], state: int) -> tuple[int, ...]:
    plan = []
    while (step := parents[state]) is not None:
        state, o = step
        plan.append(o)
    return tuple(reversed(plan))


@cache
def _compiled() -> Callable[[CompiledTask, int, Never, SearchBudget], SearchResult]:
    return search.breadth_first_compiled
