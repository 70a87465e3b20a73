"""Novelty-guided best-first search in plain Python, for tasks too small to wait for compiled code.

It keeps the same states in the same order as the kernel [kabo.finite_domain.kernels.novelty].
"""

from collections import deque
from collections.abc import Sequence
from typing import Any

from kabo import tuning
from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget, as_number
from kabo.finite_domain.result import SearchResult

MOST_PLAN_FACTS = 256  # facts of a relaxed plan that are counted; further ones are ignored


def pair_words(facts: int) -> int:
    """The number of 64-bit words of a table with a bit for each pair of facts; each fact's row has whole words."""
    whole, rest = divmod(facts, 64)
    return 32 * whole * (whole + 1) + rest * (whole + 1)


def pair_partitions(facts: int) -> int:
    """The number of novelty partitions whose tables of seen fact pairs fit into the memory limit."""
    return tuning.NOVELTY_PAIR_BYTES // max(8, 8 * pair_words(facts))


class PlainNovelty:
    """The novelty search in plain Python; entry i of the lists `states` to `partitions` is about state i."""

    def __init__(self, compiled: CompiledTask, never: Never, work: int) -> None:
        self.compiled, self.work, self.banned = compiled, work, as_number(never)
        self.generated = 0
        self.states: list[int] = []
        self.parents: list[int] = []
        self.operators: list[int] = []
        self.open: list[int] = []  # the number of open goals
        self.reached: list[int] = []  # bit i: the i-th fact of the relaxed plan has been true since it was made
        self.plans: list[list[int]] = []  # the facts of the relaxed plan by which the state is judged
        self.partitions: list[int] = []
        self.known: set[int] = set()
        self.numbered: dict[tuple[int, int], int] = {}
        self.facts_seen: list[set[int]] = []
        self.pairs_seen: list[set[int]] = []
        self.queues: dict[tuple[int, int], deque[int]] = {}
        changing = compiled.changing
        self.novel = [(v, at) for v, at in enumerate(changing.offset) if at >= 0]
        self.with_pairs = pair_partitions(changing.facts)

    def search(self, start: int, budget: SearchBudget) -> SearchResult | None:
        """The result of the search; None if it needs more states than plain Python may keep."""
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
        """The result of a search that ended with this status, without a plan."""
        return SearchResult(status, None, None, expanded, self.generated, len(self.states))

    def with_plan(self, expanded: int) -> SearchResult:
        """The result with the plan that leads to the last state."""
        plan, row = [], len(self.states) - 1
        while row > 0:
            plan.append(self.operators[row])
            row = self.parents[row]
        path = tuple(reversed(plan))
        return SearchResult("solved", path, self.compiled.cost(path), expanded, self.generated, len(self.states))

    def enter(self, state: int, parent: int, operator: int) -> bool:
        """Stores a new state, and queues it if the goal is reachable; returns whether it is a goal state."""
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
        """A mask: bit i is set if the i-th fact of the relaxed plan that judges this state holds in the state."""
        of = self.compiled.fact_task.variable
        offset = self.compiled.relaxed.offset
        return sum(1 << i for i, f in enumerate(self.plans[row]) if offset[of[f]] + values[of[f]] == f)

    def novelty(self, row: int, values: Sequence[int]) -> int:
        """The state's novelty: 1, 2, or 3 for anything above 2; records its facts and pairs of facts as seen."""
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
