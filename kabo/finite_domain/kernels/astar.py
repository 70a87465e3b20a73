"""A* over packed states with LM-cut: a state has its parent's bound until it is first taken from the queue.

A state that is reached again at less cost is reopened, since LM-cut is not consistent.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel
from kabo.finite_domain.kernels.landmark_cut import INFINITE_COST, landmark_cut
from kabo.finite_domain.kernels.records import (
    COUNT,
    EXPANDED,
    FIRST_OWN,
    FULL,
    GENERATED,
    GOAL,
    OPERATOR,
    OWN,
    PARENT,
    RUNNING,
    SOLVED,
    UNSOLVABLE,
)
from kabo.finite_domain.kernels.seen import find_row
from kabo.finite_domain.kernels.successors import applicable, apply, at_goal, hashed

COST, BOUND, ASKED, CLOSED, COLUMNS = range(FIRST_OWN, FIRST_OWN + 5)  # columns of `rows`
WAITING, EVALUATED, START_BOUND, NEAREST, PLACES = range(OWN, OWN + 5)  # places of `progress`


class Store(NamedTuple):
    """The states found so far, and those that wait."""

    states: NDArray[np.uint64]  # (S, W)
    rows: NDArray[np.int64]  # (S, 6)
    known: NDArray[np.uint64]  # (H,)
    queue: NDArray[np.int64]  # (Q, 3)
    progress: NDArray[np.int64]


class Successors(NamedTuple):
    """What operators cost, and scratch for one expansion."""

    costs: NDArray[np.int64]  # (O,)
    able: NDArray[np.int32]  # (O,)
    after: NDArray[np.uint64]  # (1, W)


@lean_kernel  # (Q, 3) i8, i8, i8 -> bool
def _before(queue, i, j):
    """Whether entry i comes before entry j: the lower total cost, then the lower bound, then the one found later."""
    if queue[i, 0] != queue[j, 0]:
        return queue[i, 0] < queue[j, 0]
    if queue[i, 1] != queue[j, 1]:
        return queue[i, 1] < queue[j, 1]
    return queue[i, 2] > queue[j, 2]


@lean_kernel  # (Q, 3) i8, i8, i8
def _swap(queue, i, j):
    for c in range(3):
        queue[i, c], queue[j, c] = queue[j, c], queue[i, c]


@lean_kernel  # (Q, 3) i8, (X,) i8, i8, i8, i8
def _push(queue, progress, total, bound, row):
    """Queues a state; there must be room."""
    i = progress[WAITING]
    progress[WAITING] += 1
    queue[i, 0], queue[i, 1], queue[i, 2] = total, bound, row
    while i > 0 and _before(queue, i, (i - 1) // 2):
        _swap(queue, i, (i - 1) // 2)
        i = (i - 1) // 2


@lean_kernel  # (Q, 3) i8, (X,) i8
def _pop(queue, progress):
    """Removes the first entry, which the caller has read."""
    progress[WAITING] -= 1
    size, i = progress[WAITING], 0
    _swap(queue, 0, size)
    while 2 * i + 1 < size:
        child = 2 * i + 1
        if child + 1 < size and _before(queue, child + 1, child):
            child += 1
        if _before(queue, i, child):
            break
        _swap(queue, i, child)
        i = child


@lean_kernel  # Store, (1, W) u8, i8, i8, i8
def _reach(store, after, parent, operator, price):
    """Keeps and queues a successor if it is new or reached at less cost than before."""
    states, rows, known, queue, progress = store
    cost, new = rows[parent, COST] + price, progress[COUNT]
    row = find_row(known, states, after, 0, hashed(after, 0), new)
    if row < 0:
        row = new
        for w in range(states.shape[1]):
            states[row, w] = after[0, w]
        rows[row, BOUND], rows[row, ASKED] = max(0, rows[parent, BOUND] - price), 0
        progress[COUNT] += 1
    elif cost >= rows[row, COST]:
        return
    rows[row, PARENT], rows[row, OPERATOR], rows[row, COST], rows[row, CLOSED] = parent, operator, cost, 0
    if rows[row, BOUND] < INFINITE_COST:
        _push(queue, progress, cost + rows[row, BOUND], rows[row, BOUND], row)


@lean_kernel  # Store
def _start(store):
    """Takes note of the first state, and queues it."""
    states, rows, known, queue, progress = store
    find_row(known, states, states, 0, hashed(states, 0), 0)
    progress[COUNT] = 1
    rows[0, PARENT], rows[0, OPERATOR], rows[0, COST], rows[0, BOUND] = -1, -1, 0, 0
    rows[0, ASKED], rows[0, CLOSED] = 0, 0
    _push(queue, progress, 0, 0, 0)


@lean_kernel  # Task, Store, Successors, Relaxation, i8 -> i8
def expand(task, store, successors, relaxation, limit):
    """Processes up to `limit` queue entries; returns RUNNING, SOLVED, UNSOLVABLE, or FULL (arrays must grow)."""
    numbers, bits, never = task
    states, rows, known, queue, progress = store
    costs, able, after = successors
    if progress[COUNT] == 0:
        _start(store)
    for _ in range(limit):
        if progress[WAITING] == 0:
            return UNSOLVABLE
        room = progress[COUNT] + able.shape[0]
        if (
            room > states.shape[0]
            or 10 * room > 7 * known.shape[0]
            or progress[WAITING] + able.shape[0] > queue.shape[0]
        ):
            return FULL
        total, row = queue[0, 0], queue[0, 2]
        _pop(queue, progress)
        if rows[row, CLOSED] != 0 or total != rows[row, COST] + rows[row, BOUND]:
            continue
        if rows[row, ASKED] == 0:
            bound = landmark_cut(relaxation, states, row, progress[NEAREST] != 0)
            progress[EVALUATED] += 1
            rows[row, ASKED] = 1
            if row == 0:  # both variants once, to keep the better one for this search
                other = landmark_cut(relaxation, states, row, True)
                progress[NEAREST] = other > bound
                bound = max(bound, other)
                progress[START_BOUND] = bound
            if bound > rows[row, BOUND]:
                rows[row, BOUND] = bound
                if bound < INFINITE_COST:
                    _push(queue, progress, rows[row, COST] + bound, bound, row)
                continue
        rows[row, CLOSED] = 1
        if at_goal(numbers, bits, states, row):
            progress[GOAL] = row
            return SOLVED
        progress[EXPANDED] += 1
        for i in range(applicable(numbers, bits, states, row, never, able)):
            progress[GENERATED] += 1
            apply(numbers, bits, states, row, able[i], after, 0)
            _reach(store, after, row, able[i], costs[able[i]])
    return RUNNING
