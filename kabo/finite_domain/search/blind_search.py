"""Breadth-first search: the fewest actions, or the proof that there is no plan."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo import tuning
from kabo.finite_domain.compiled_task import Budget, CompiledTask, Never, as_number
from kabo.finite_domain.result import SearchResult, Status

BETWEEN_LOOKS = 100_000  # expansions between two questions whether to stop
BUFFER = 4096
ROWS = (1 << 31) - 1  # states are counted in 32 bits
EMPTY = np.uint64(0xFFFFFFFFFFFFFFFF)
SOLVED, UNSOLVABLE, FULL = 1, 2, 3  # as in the kernel


def breadth_first(
    compiled: CompiledTask,
    *,
    start: Sequence[int] | None = None,
    forbidden: Sequence[int] | NDArray[Any] | None = None,
    budget: Budget | None = None,
    plain_work: int | None = None,
) -> SearchResult:
    """A plan of fewest actions; costs do not count.

    Args:
        compiled: the task.
        start: values of all variables, instead of the task's initial ones.
        forbidden: 1 for each operator that must not be used.
        budget: how long; a search that it ends is "exhausted" or "stopped".
        plain_work: how many states plain Python generates before the compiled search starts over; None: as many as
            take as long as loading it, over all searches of this task. The answer is the same.
    """
    budget = budget or Budget()
    packed, never = compiled.start(start), compiled.never(forbidden)
    if compiled.plain.at_goal(packed):
        return SearchResult("solved", (), 0, 0, 0, 1, optimal=True)
    if plain_work is None:
        plain_work = (
            0
            if _kernels.cache_info().currsize
            else compiled.plain_left("breadth-first", tuning.PLAIN_BREADTH_FIRST_STATES)
        )
    found = _plain(compiled, packed, never, budget, plain_work) if plain_work else None
    compiled.spend("breadth-first", found.generated if found else plain_work)
    return found or _compiled(compiled, packed, never, budget)


def _plain(compiled: CompiledTask, start: int, never: Never, budget: Budget, work: int) -> SearchResult | None:
    """The search in plain Python; None: it is larger than `work` generated states."""
    plain, banned = compiled.plain, as_number(never)
    parents: dict[int, tuple[int, int] | None] = {start: None}
    queue, generated = [start], 0
    for expanded, state in enumerate(queue):  # grows while it is read
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


class _Memory:
    """The arrays of a search, which double when they are full."""

    def __init__(self, start: NDArray[np.uint64], operators: int) -> None:
        self.rows = max(BUFFER, 2 * operators)  # successors of a batch of states
        words = len(start)
        self.states, self.parents = np.empty((self.rows, words), np.uint64), np.empty(self.rows, np.int32)
        self.table = np.full(1 << (4 * self.rows).bit_length(), EMPTY, np.uint64)
        self.progress = np.array([1, 0, 0, -1, 0], np.int64)
        self.states[0], self.parents[0] = start, -1
        self.batch = np.empty((self.rows, words), np.uint64)
        self.hashes, self.origins = np.empty(self.rows, np.uint64), np.empty(self.rows, np.int32)

    def grow(self, most: int) -> bool:
        """Makes room for another batch; False: that would take more bytes than `most`."""
        count = int(self.progress[0])
        kept = self.states.nbytes + self.parents.nbytes + self.table.nbytes
        while count + self.rows > len(self.states):
            room = min(2 * len(self.states), ROWS)
            kept += (self.states.nbytes + self.parents.nbytes) * (room - len(self.states)) // len(self.states)
            if kept > most or room < count + self.rows:
                return False
            states, parents = np.empty((room, self.states.shape[1]), np.uint64), np.empty(room, np.int32)
            states[:count], parents[:count] = self.states[:count], self.parents[:count]
            self.states, self.parents = states, parents
        while 10 * (count + self.rows) > 7 * len(self.table):
            kept += self.table.nbytes
            if kept + self.table.nbytes > most:  # both are there for a moment
                return False
            larger = np.full(2 * len(self.table), EMPTY, np.uint64)
            _kernels()[1](self.table, larger, self.states, np.empty((1, self.states.shape[1]), np.uint64), False)
            self.table = larger
        return True


def _compiled(compiled: CompiledTask, start: int, never: Never, budget: Budget) -> SearchResult:
    expand = _kernels()[0]
    numbers, bits = compiled.arrays
    memory = _Memory(compiled.packing.array(start), len(compiled.task.operators))
    out = np.empty(len(compiled.task.operators), np.int32)
    while True:
        limit = budget.left(int(memory.progress[1]), BETWEEN_LOOKS)
        if not limit:
            return _without_plan("exhausted", memory)
        if budget.stopped():
            return _without_plan("stopped", memory)
        status = expand(
            numbers,
            bits,
            never,
            memory.states,
            memory.parents,
            memory.table,
            memory.progress,
            memory.batch,
            memory.hashes,
            memory.origins,
            out,
            limit,
        )
        if status == SOLVED:
            return _with_plan(compiled, memory, never)
        if status == UNSOLVABLE:
            return _without_plan("unsolvable", memory)
        if status == FULL and not memory.grow(budget.memory):
            return _without_plan("exhausted", memory)


def _without_plan(status: Status, memory: _Memory) -> SearchResult:
    count, expanded, generated = memory.progress[:3].tolist()
    return SearchResult(status, None, None, expanded, generated, count)


def _with_plan(compiled: CompiledTask, memory: _Memory, never: Never) -> SearchResult:
    count, expanded, generated, row, _ = memory.progress.tolist()
    chain = []
    while row >= 0:
        chain.append(compiled.packing.number_of(memory.states[row]))
        row = int(memory.parents[row])
    plan = plan_along(compiled, chain[::-1], never)
    return SearchResult("solved", plan, compiled.cost(plan), expanded, generated, count, optimal=True)


def plan_along(compiled: CompiledTask, states: Sequence[int], never: Never) -> tuple[int, ...]:
    """The operators that lead from each state to the next: of several the first in the order of generation."""
    plain, banned = compiled.plain, as_number(never)
    return tuple(
        next(o for o in plain.applicable(before, banned) if plain.after(before, o) == after)
        for before, after in pairwise(states)
    )


@cache
def _kernels() -> tuple[Any, Any]:
    from kabo.finite_domain.kernels.breadth_first import expand
    from kabo.finite_domain.kernels.seen import move_table

    return expand, move_table
