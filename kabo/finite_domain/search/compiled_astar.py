"""The compiled A* with LM-cut: its arrays, which double when they are full.

The loop over states is a kernel [kabo.finite_domain.kernels.astar].
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget
from kabo.finite_domain.heuristics.landmark_bound import room_for
from kabo.finite_domain.heuristics.landmarks import landmark_tables
from kabo.finite_domain.kernels import astar, records
from kabo.finite_domain.kernels.astar import expand as _expand
from kabo.finite_domain.kernels.landmark_cut import FACTS, INFINITE_COST
from kabo.finite_domain.kernels.records import COUNT, EXPANDED, FULL, GOAL, OPERATOR, PARENT, SOLVED, UNSOLVABLE
from kabo.finite_domain.kernels.seen import EMPTY, move_table
from kabo.finite_domain.mutexes import Mutexes, mutexes
from kabo.finite_domain.result import SearchResult

expand: Any = _expand
WORK_BETWEEN_LOOKS = 500_000  # (operators + facts) x expansions after which the caller is asked whether to stop


def astar_compiled(compiled: CompiledTask, start: int, never: Never, budget: SearchBudget) -> SearchResult:
    """A plan of least cost, or the reason why none was found."""
    memory = _AstarArrays(compiled, start, never)
    size = len(compiled.relaxed.operators) + compiled.relaxed.all_facts
    while True:
        limit = budget.left(int(memory.progress[EXPANDED]), max(1, min(1000, WORK_BETWEEN_LOOKS // size)))
        if not limit:
            return memory.without_plan("exhausted")
        if budget.stopped():
            return memory.without_plan("stopped")
        status = expand(*memory.arguments(), limit)
        if status == SOLVED:
            return memory.with_plan()
        if status == UNSOLVABLE:
            return memory.without_plan("unsolvable")
        if status == FULL and not memory.grow(budget.memory):
            return memory.without_plan("exhausted")


def valid_mutexes(compiled: CompiledTask, start: int) -> Mutexes:
    """The pairs of facts that are never true together in states reachable from this start.

    The task's own mutexes are valid unless the start violates one of them; then the mutexes are computed anew.
    """
    facts = compiled.relaxed.of(compiled.packing.values(start))
    known = compiled.mutexes
    return known if known.allow(facts) else mutexes(compiled.fact_task, facts)


class _AstarArrays:
    """The arrays of one search; those of states double when they are full."""

    def __init__(self, compiled: CompiledTask, start: int, never: Never) -> None:
        self.compiled, self.never = compiled, never
        self.operators = len(compiled.task.operators)
        words, room = compiled.packing.words, max(1024, 2 * self.operators)
        self.rooms: dict[str, NDArray[Any]] = {
            "states": np.empty((room, words), np.uint64),
            "rows": np.empty((room, astar.COLUMNS), np.int64),
            "queue": np.empty((2 * room, 3), np.int64),
        }
        self.known = np.full(1 << (2 * room).bit_length(), EMPTY, np.uint64)
        self.progress = np.zeros(astar.PLACES, np.int64)
        self.rooms["states"][0] = compiled.packing.array(start)
        costs = np.array([o.cost for o in compiled.task.operators], np.int64)
        self.after = np.empty((1, words), np.uint64)
        self.successors = astar.Successors(costs, np.empty(self.operators, np.int32), self.after)
        self.bound = self._bound(start)

    def _bound(self, start: int) -> Any:
        """The relaxation for LM-cut, with its scratch."""
        task = self.compiled
        lm, relaxed = landmark_tables(
            task.normal,
            task.packing,
            task.relaxed,
            task.fact_task,
            goals=task.goal_facts,
            mutexes=valid_mutexes(task, start),
        )
        facts = int(lm[FACTS])
        never = np.unpackbits(self.never.view(np.uint8), bitorder="little")
        prices = [INFINITE_COST if o.owner >= 0 and never[o.owner] else o.cost for o in relaxed]
        return room_for(lm, np.array(prices, np.int64), np.empty(facts, np.uint8))

    def arguments(self) -> tuple[Any, ...]:
        """The arguments of the kernel but for the last one, the limit."""
        room = self.rooms
        store = astar.Store(room["states"], room["rows"], self.known, room["queue"], self.progress)
        return records.Task(*self.compiled.arrays, self.never), store, self.successors, self.bound

    def grow(self, most: int) -> bool:
        """Makes room for the successors of one more state; False if that would take more than `most` bytes."""
        count, waiting = int(self.progress[COUNT]), int(self.progress[astar.WAITING])
        kept = self.known.nbytes + sum(array.nbytes for array in self.rooms.values())
        needed = {"states": count, "rows": count, "queue": waiting}
        for name, used in needed.items():
            old = self.rooms[name]
            if used + self.operators > len(old):
                kept += old.nbytes
                if kept > most:
                    return False
                self.rooms[name] = np.empty((2 * len(old), *old.shape[1:]), old.dtype)
                self.rooms[name][: len(old)] = old
        while 10 * (count + self.operators) > 7 * len(self.known):
            kept += self.known.nbytes
            if kept + self.known.nbytes > most:
                return False
            larger = np.full(2 * len(self.known), EMPTY, np.uint64)
            move_table(self.known, larger, self.rooms["states"], self.after, True)
            self.known = larger
        return True

    def without_plan(self, status: Any) -> SearchResult:
        """The result of a search that ended with this status, without a plan."""
        count, expanded, generated = self.progress[:GOAL].tolist()
        return SearchResult(status, None, None, expanded, generated, count, initial_estimate=self._start_bound())

    def with_plan(self) -> SearchResult:
        """The result with the plan that was found."""
        plan, row, rows = [], int(self.progress[GOAL]), self.rooms["rows"]
        cost = int(rows[row, astar.COST])
        while rows[row, PARENT] >= 0:
            plan.append(int(rows[row, OPERATOR]))
            row = int(rows[row, PARENT])
        count, expanded, generated = self.progress[:GOAL].tolist()
        path = tuple(reversed(plan))
        return SearchResult(
            "solved", path, cost, expanded, generated, count, optimal=True, initial_estimate=self._start_bound()
        )

    def _start_bound(self) -> int | None:
        bound = int(self.progress[astar.START_BOUND])
        return bound if self.progress[astar.EVALUATED] and bound < INFINITE_COST else None
