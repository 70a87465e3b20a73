"""The compiled breadth-first search: its arrays, which double when they are full.

The loop over states is a kernel [kabo.finite_domain.kernels.breadth_first].
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.finite_domain.compiled_task import CompiledTask, Never, SearchBudget, as_number
from kabo.finite_domain.kernels.breadth_first import NEXT, PLACES, Batch, Seen
from kabo.finite_domain.kernels.breadth_first import expand as _expand
from kabo.finite_domain.kernels.records import COUNT, FULL, GOAL, SOLVED, UNSOLVABLE, Task
from kabo.finite_domain.kernels.seen import EMPTY, move_table
from kabo.finite_domain.result import SearchResult, Status

expand: Any = _expand
BETWEEN_LOOKS = 100_000  # expansions after which the caller is asked again whether to stop
BUFFER = 4096  # states: the least size of a batch of successors
MAX_ROWS = (1 << 31) - 1  # states, which are numbered in 32 bits


def breadth_first_compiled(compiled: CompiledTask, start: int, never: Never, budget: SearchBudget) -> SearchResult:
    """A plan with the fewest actions, or the reason why none was found."""
    task = Task(*compiled.arrays, never)
    memory = _BreadthFirstArrays(compiled.packing.array(start), len(compiled.task.operators))
    while True:
        limit = budget.left(int(memory.progress[NEXT]), BETWEEN_LOOKS)
        if not limit:
            return _without_plan("exhausted", memory)
        if budget.stopped():
            return _without_plan("stopped", memory)
        seen = Seen(memory.states, memory.parents, memory.table, memory.progress)
        status = expand(task, seen, memory.batch, limit)
        if status == SOLVED:
            return _with_plan(compiled, memory, never)
        if status == UNSOLVABLE:
            return _without_plan("unsolvable", memory)
        if status == FULL and not memory.grow(budget.memory):
            return _without_plan("exhausted", memory)


class _BreadthFirstArrays:
    """The arrays of one search; those of states double when they are full."""

    def __init__(self, start: NDArray[np.uint64], operators: int) -> None:
        self.rows = max(BUFFER, 2 * operators)  # successors of a batch of states
        words = len(start)
        self.states, self.parents = np.empty((self.rows, words), np.uint64), np.empty(self.rows, np.int32)
        self.table = np.full(1 << (4 * self.rows).bit_length(), EMPTY, np.uint64)
        self.progress = np.zeros(PLACES, np.int64)
        self.progress[COUNT], self.progress[GOAL] = 1, -1
        self.states[0], self.parents[0] = start, -1
        hashes, origins = np.empty(self.rows, np.uint64), np.empty(self.rows, np.int32)
        results = np.empty((self.rows, words), np.uint64)
        self.batch = Batch(results, hashes, origins, np.empty(operators, np.int32))

    def grow(self, most: int) -> bool:
        """Makes room for another batch of states; False if that would take more than `most` bytes."""
        count = int(self.progress[COUNT])
        kept = self.states.nbytes + self.parents.nbytes + self.table.nbytes
        while count + self.rows > len(self.states):
            room = min(2 * len(self.states), MAX_ROWS)
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
            move_table(self.table, larger, self.states, np.empty((1, self.states.shape[1]), np.uint64), False)
            self.table = larger
        return True


def _without_plan(status: Status, memory: _BreadthFirstArrays) -> SearchResult:
    count, expanded, generated = memory.progress[:GOAL].tolist()
    return SearchResult(status, None, None, expanded, generated, count)


def _with_plan(compiled: CompiledTask, memory: _BreadthFirstArrays, never: Never) -> SearchResult:
    count, expanded, generated, row = memory.progress[: GOAL + 1].tolist()
    chain = []
    while row >= 0:
        chain.append(compiled.packing.number_of(memory.states[row]))
        row = int(memory.parents[row])
    plan = plan_along(compiled, chain[::-1], never)
    return SearchResult("solved", plan, compiled.cost(plan), expanded, generated, count, optimal=True)


def plan_along(compiled: CompiledTask, states: Sequence[int], never: Never) -> tuple[int, ...]:
    """The operators that lead from each state to the next one; of several, the first in the order of the task."""
    plain, banned = compiled.plain, as_number(never)
    return tuple(
        next(o for o in plain.applicable(before, banned) if plain.after(before, o) == after)
        for before, after in pairwise(states)
    )
