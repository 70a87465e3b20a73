"""Novelty-guided best-first search: what has not been seen goes first [BFWS(f5), Lipovetzky, Geffner 2017].

States are compared with those that have as many open goals, along the agenda [kabo.finite_domain.agenda], and as many
facts of the last relaxed plan reached. Novelty 1 shows a fact that none of them had, 2 a pair of facts; the others
follow, so nothing is left out. States with equal novelty and goals are taken in the order in which they were found.
"""

from collections import deque
from collections.abc import Sequence
from functools import cache
from typing import Any

from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain.compiled_task import Budget, CompiledTask, Never, as_number
from kabo.finite_domain.result import SearchResult

MOST_PLAN_FACTS = 256  # of a relaxed plan that are counted


def bfws(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: Budget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan, seldom a long one; or the proof that there is none.

    Args:
        compiled: the task.
        start: values of all variables, instead of the task's initial ones.
        forbidden: 1 for each operator that must not be used.
        budget: how long; a search that it ends is "exhausted" or "stopped".
        plain_work: how many states plain Python enters before the compiled search starts over; None: as many as take
            as long as loading it, over all searches of this task. The answer is the same.
    """
    budget = budget or Budget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    if compiled.plain.at_goal(packed):
        return SearchResult("solved", (), 0, 0, 0, 1)
    work = _plain_states(compiled) if plain_work is None else plain_work
    found = _Plain(compiled, never, work).search(packed, budget) if work else None
    compiled.spend("novelty", found.states if found else work)
    return found or _compiled()(compiled, packed, never, budget)


def _plain_states(compiled: CompiledTask) -> int:
    """How many states to enter in plain Python first; none once the kernel is there."""
    if _compiled.cache_info().currsize:
        return 0
    each = len(compiled.normal.sizes) ** 2 + len(compiled.normal.operators) + 1
    return compiled.plain_left("novelty", min(tuning.PLAIN_NOVELTY_STATES, tuning.PLAIN_NOVELTY_PAIRS // each))


@cache
def _compiled() -> Any:
    from kabo.finite_domain.search.compiled_novelty import search

    return search


def pair_words(facts: int) -> int:
    """Words for a bit for each pair of so many facts, in rows of whole words."""
    whole, rest = divmod(facts, 64)
    return 32 * whole * (whole + 1) + rest * (whole + 1)


def pair_partitions(facts: int) -> int:
    """How many partitions may remember pairs of so many facts."""
    return tuning.NOVELTY_PAIR_BYTES // max(8, 8 * pair_words(facts))


class _Plain:
    """The search in plain Python. A state is entered as a row of several lists."""

    def __init__(self, compiled: CompiledTask, never: Never, work: int) -> None:
        self.compiled, self.work, self.banned = compiled, work, as_number(never)
        self.generated = 0
        self.states: list[int] = []
        self.parents: list[int] = []
        self.operators: list[int] = []
        self.open: list[int] = []  # goals
        self.reached: list[int] = []  # bits of facts of the relaxed plan
        self.plans: list[list[int]] = []  # of each state its relaxed plan
        self.partitions: list[int] = []
        self.known: set[int] = set()
        self.numbered: dict[tuple[int, int], int] = {}
        self.facts_seen: list[set[int]] = []
        self.pairs_seen: list[set[int]] = []
        self.queues: dict[tuple[int, int], deque[int]] = {}
        changing = compiled.changing
        self.novel = [(v, at) for v, at in enumerate(changing.offset) if at >= 0]
        self.with_pairs = pair_partitions(changing.facts)

    def search(self, start: int, budget: Budget) -> SearchResult | None:
        """The result; None: it takes more than the work allowed."""
        self.known.add(start)
        self.enter(start, -1, -1)
        expanded = 0
        while self.queues:
            if len(self.states) >= self.work:
                return None
            if not budget.left(expanded, 1):
                return self.without_plan("exhausted", expanded)
            if expanded % 64 == 63 and budget.stopped():
                return self.without_plan("stopped", expanded)
            first = min(self.queues)
            row = self.queues[first].popleft()
            if not self.queues[first]:
                del self.queues[first]
            expanded += 1
            for o in self.compiled.plain.applicable(self.states[row], self.banned):
                after = self.compiled.plain.after(self.states[row], o)
                self.generated += 1
                if after not in self.known:
                    self.known.add(after)
                    if self.enter(after, row, o):
                        return self.with_plan(expanded)
        return self.without_plan("unsolvable", expanded)

    def without_plan(self, status: Any, expanded: int) -> SearchResult:
        return SearchResult(status, None, None, expanded, self.generated, len(self.states))

    def with_plan(self, expanded: int) -> SearchResult:
        plan, row = [], len(self.states) - 1
        while row > 0:
            plan.append(self.operators[row])
            row = self.parents[row]
        path = tuple(reversed(plan))
        return SearchResult("solved", path, self.compiled.cost(path), expanded, self.generated, len(self.states))

    def enter(self, state: int, parent: int, operator: int) -> bool:
        """Keeps a new state and queues it, unless the goal is out of its reach; whether it fulfils the goal."""
        row, values = len(self.states), self.compiled.packing.values(state)
        offset = self.compiled.relaxed.offset
        done = [values[v] in allowed for v, allowed in self.compiled.normal.goal.items()]
        goals = self.compiled.agenda.open_goals(done)
        self.states.append(state)
        self.parents.append(parent)
        self.operators.append(operator)
        self.open.append(goals)
        if goals == 0:
            return True
        if parent < 0 or goals < self.open[parent]:
            estimate = self.compiled.relaxation.evaluate([at + x for at, x in zip(offset, values, strict=True)])
            facts = [f for f in estimate.plan_facts if f < self.compiled.relaxed.facts]
            self.plans.append(facts[:MOST_PLAN_FACTS])
            reached = 0
        else:
            estimate = None
            self.plans.append(self.plans[parent])
            reached = self.reached[parent] | self.reached_now(row, values)
        self.reached.append(reached)
        if estimate is not None and estimate.value is None:
            self.partitions.append(-1)
            return False
        key = (goals, reached.bit_count())
        self.partitions.append(self.numbered.setdefault(key, len(self.numbered)))
        self.queues.setdefault((self.novelty(row, values), goals), deque()).append(row)
        return False

    def reached_now(self, row: int, values: Sequence[int]) -> int:
        """Bits of the facts of the relaxed plan that hold."""
        of = self.compiled.fact_task.variable
        offset = self.compiled.relaxed.offset
        return sum(1 << i for i, f in enumerate(self.plans[row]) if offset[of[f]] + values[of[f]] == f)

    def novelty(self, row: int, values: Sequence[int]) -> int:
        """1, 2 or 3, after remembering what the state shows."""
        partition, parent = self.partitions[row], self.parents[row]
        while len(self.facts_seen) <= partition:
            self.facts_seen.append(set())
            self.pairs_seen.append(set())
        seen, pairs = self.facts_seen[partition], self.pairs_seen[partition]
        facts = [at + values[v] for v, at in self.novel]
        result = 3 if seen.issuperset(facts) else 1
        seen.update(facts)
        if partition >= self.with_pairs:
            return result
        changed = facts
        if parent >= 0 and self.partitions[parent] == partition:
            before = self.compiled.packing.values(self.states[parent])
            changed = [at + values[v] for v, at in self.novel if values[v] != before[v]]
        shown = {f * (f + 1) // 2 + g if g < f else g * (g + 1) // 2 + f for f in changed for g in facts if f != g}
        if not pairs.issuperset(shown):
            pairs.update(shown)
            result = min(result, 2)
        return result
