"""The compiled novelty search: its arrays, which grow as needed.

The loop over states is a kernel [kabo.finite_domain.kernels.novelty].
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget
from kabo.finite_domain.kernels import novelty
from kabo.finite_domain.kernels.novelty import expand as _expand
from kabo.finite_domain.kernels.records import (
    COUNT,
    EXPANDED,
    FULL,
    GOAL,
    OPERATOR,
    PARENT,
    SOLVED,
    UNSOLVABLE,
    Task,
)
from kabo.finite_domain.kernels.seen import EMPTY, move_table
from kabo.finite_domain.result import SearchResult
from kabo.finite_domain.search.plain_novelty import MOST_PLAN_FACTS, pair_partitions, pair_words

expand: Any = _expand
WORK_BETWEEN_LOOKS = 1_000_000  # (operators + facts) x expansions after which the caller is asked whether to stop


def bfws_compiled(compiled: CompiledTask, start: int, never: Never, budget: SearchBudget) -> SearchResult:
    """A plan, or the reason why none was found; the same as the search in plain Python finds."""
    memory = _NoveltyArrays(compiled, start)
    size = len(compiled.relaxed.operators) + compiled.relaxed.all_facts
    while True:
        limit = budget.left(int(memory.progress[EXPANDED]), max(1, min(2000, WORK_BETWEEN_LOOKS // size)))
        if not limit:
            return memory.without_plan("exhausted")
        if budget.stopped():
            return memory.without_plan("stopped")
        status = expand(*memory.arguments(never), limit, memory.most_pairs)
        if status == SOLVED:
            return memory.with_plan(compiled)
        if status == UNSOLVABLE:
            return memory.without_plan("unsolvable")
        if status == FULL and not memory.grow(budget.memory):
            return memory.without_plan("exhausted")


def novelty_layout(compiled: CompiledTask) -> NDArray[np.int32]:
    """The goals, their orders and the facts that states are compared by, as one array for the kernel."""
    packing, offset, changing = compiled.packing, compiled.relaxed.offset, compiled.changing.offset
    goal, before = compiled.normal.goal, compiled.agenda.before
    flat = [0] * 9

    def put(row: list[int]) -> int:
        flat.extend(row)
        return len(flat) - len(row)

    def place(v: int) -> list[int]:
        return [packing.word[v], packing.shift[v], packing.mask[v]]

    tests = [
        [*place(v), put([int(x in allowed) for x in range(compiled.normal.sizes[v])])]
        for v, allowed in goal.items()
    ]
    starts = [0]
    for row in before:
        starts.append(starts[-1] + len(row))
    tests_at, starts_at = put([n for row in tests for n in row]), put(starts)
    before_at = put([j for row in before for j in row])
    places = put([n for v in range(len(offset)) for n in (*place(v), offset[v], changing[v])])
    owners = len({o.owner for o in compiled.relaxed.operators if o.owner >= 0})
    facts = compiled.relaxed.facts
    flat[:9] = [
        len(offset),
        len(goal),
        tests_at,
        starts_at,
        before_at,
        places,
        facts,
        compiled.changing.facts,
        owners,
    ]
    return np.array(flat, np.int32)


class _NoveltyArrays:
    """The arrays of one search; those of states double when they are full."""

    def __init__(self, compiled: CompiledTask, start: int) -> None:
        self.compiled = compiled
        self.layout = novelty_layout(compiled)
        words = compiled.packing.words
        self.width = len(compiled.task.operators)  # one expansion gives at most `width` states
        room = max(1024, 2 * self.width)
        facts = compiled.changing.facts
        self.most_pairs = pair_partitions(facts)
        self.rooms: dict[str, NDArray[Any]] = {
            "states": np.empty((room, words), np.uint64),
            "rows": np.empty((room, novelty.COLUMNS), np.int32),
            "reached": np.empty((room, MOST_PLAN_FACTS // 64), np.uint64),
            "plans": np.empty((room, 2), np.int32),
            "plan_facts": np.empty(room * MOST_PLAN_FACTS, np.int32),
            "facts_seen": np.zeros((room, facts), np.uint8),
            "pairs_seen": np.zeros((min(room, self.most_pairs), pair_words(facts)), np.uint64),
        }
        self.known = np.full(1 << (2 * room).bit_length(), EMPTY, np.uint64)
        goals = len(compiled.normal.goal)
        self.numbered = np.full((goals + 1) * (MOST_PLAN_FACTS + 1), -1, np.int32)
        self.queues = np.full((3 * (goals + 1), 2), -1, np.int32)
        self.progress = np.zeros(novelty.STEPS, np.int64)
        self.rooms["states"][0] = compiled.packing.array(start)
        view, variables = compiled.relaxation.for_kernels(), len(compiled.normal.sizes)
        true = np.empty(variables, np.int32)
        self.relaxed = novelty.Relaxed(view.table, view.scratch, np.empty(0, np.uint64), true, view.goal, view.out)
        self.after = np.empty((1, words), np.uint64)
        self.work = novelty.Work(
            np.full(compiled.relaxed.facts, -1, np.int64),
            np.empty(goals, np.int32),
            np.empty((2, variables), np.int32),
            np.zeros((facts + 63) // 64, np.uint64),
            np.empty(len(compiled.task.operators), np.int32),
            self.after,
        )

    def arguments(self, never: Never) -> tuple[Any, ...]:
        """The arguments of the kernel but for the last two, its limits."""
        store = novelty.Store(
            known=self.known, **{name: self.rooms[name] for name in novelty.Store._fields if name != "known"}
        )
        partitions = novelty.Partitions(self.layout, self.numbered, self.queues, self.progress)
        return Task(*self.compiled.arrays, never), store, partitions, self.relaxed, self.work

    def grow(self, most: int) -> bool:
        """Makes room for the successors of one more state; False if that would take more than `most` bytes."""
        count, plans, plan_facts, partitions = self.progress[
            [COUNT, novelty.PLANS, novelty.PLAN_FACTS, novelty.PARTITIONS]
        ].tolist()
        width = self.width
        needed = {
            "states": count + width,
            "rows": count + width,
            "reached": count + width,
            "plans": plans + width,
            "plan_facts": plan_facts + width * MOST_PLAN_FACTS,
            "facts_seen": partitions + width,
            "pairs_seen": min(partitions + width, self.most_pairs),
        }
        for name, size in needed.items():
            old = self.rooms[name]
            if size <= len(old):
                continue
            room = max(2 * len(old), size)
            if name == "pairs_seen":
                room = min(room, self.most_pairs)
            elif self.bytes() + (room - len(old)) * old[:1].nbytes > most:
                return False
            self.rooms[name] = np.zeros((room, *old.shape[1:]), old.dtype)
            self.rooms[name][: len(old)] = old
        while 10 * (count + width) > 7 * len(self.known):
            if self.bytes() + 2 * self.known.nbytes > most:
                return False
            larger = np.full(2 * len(self.known), EMPTY, np.uint64)
            move_table(self.known, larger, self.rooms["states"], np.empty_like(self.after), False)
            self.known = larger
        return True

    def bytes(self) -> int:
        """The bytes of all arrays of states; those of seen pairs have a limit of their own."""
        return self.known.nbytes + sum(array.nbytes for name, array in self.rooms.items() if name != "pairs_seen")

    def without_plan(self, status: Any) -> SearchResult:
        """The result of a search that ended with this status, without a plan."""
        count, expanded, generated = self.progress[:GOAL].tolist()
        return SearchResult(status, None, None, expanded, generated, count)

    def with_plan(self, compiled: CompiledTask) -> SearchResult:
        """The result with the plan that was found."""
        plan, row, rows = [], int(self.progress[GOAL]), self.rooms["rows"]
        while row > 0:
            plan.append(int(rows[row, OPERATOR]))
            row = int(rows[row, PARENT])
        path = tuple(reversed(plan))
        count, expanded, generated = self.progress[:GOAL].tolist()
        return SearchResult("solved", path, compiled.cost(path), expanded, generated, count)
