"""Novelty-guided best-first search: states with new facts are expanded first [BFWS(f5), Lipovetzky, Geffner 2017].

A state is compared with the earlier states that have the same number of open goals (counted along the goal agenda,
kabo.finite_domain.agenda) and have reached the same number of facts of their relaxed plan. Its novelty is 1 if it has
a fact that none of these has, 2 if it has a pair of facts that none has, else 3. All states are kept, so the search is
complete. States of equal novelty and as many open goals are expanded in the order in which they were found.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain import search
from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget
from kabo.finite_domain.result import SearchResult
from kabo.finite_domain.search.plain_novelty import PlainNovelty


def bfws(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: SearchBudget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan, usually short but not proven so; or the proof that there is none.

    Args:
        compiled: the task.
        start: the values of all variables at the start; None: the task's initial values.
        forbidden: (operators,) 1 for each operator that must not be used, 0 for all others; None: all may be used.
        budget: the limits of the search; when they end it, the result is "exhausted" or "stopped".
        plain_work: the number of states that plain Python keeps before the compiled search starts over; None: as
            many as it keeps, over all searches of this task, in about the time of loading the kernel. Plain Python
            and compiled code find the same plan.
    """
    budget = budget or SearchBudget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    if compiled.plain.at_goal(packed):
        return SearchResult("solved", (), 0, 0, 0, 1)
    work = _plain_states(compiled) if plain_work is None else plain_work
    found = PlainNovelty(compiled, never, work).search(packed, budget) if work else None
    compiled.spend("novelty", found.states if found else work)
    return found or _compiled()(compiled, packed, never, budget)


def _plain_states(compiled: CompiledTask) -> int:
    """The number of states to keep in plain Python first; 0 once the kernel is loaded."""
    if _compiled.cache_info().currsize:
        return 0
    each = len(compiled.normal.sizes) ** 2 + len(compiled.normal.operators) + 1
    return compiled.plain_left("novelty", min(tuning.PLAIN_NOVELTY_STATES, tuning.PLAIN_NOVELTY_PAIRS // each))


@cache
def _compiled() -> Callable[[CompiledTask, int, Never, SearchBudget], SearchResult]:
    return search.bfws_compiled
