"""Breadth-first search over packed states, in batches: successors, then table places, then look-ups.

Each look-up waits for main memory; reading all places in a separate pass lets the processor wait for many of them
at once.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel
from kabo.finite_domain.kernels.records import (
    COUNT,
    EXPANDED,
    FULL,
    GENERATED,
    GOAL,
    OWN,
    RUNNING,
    SOLVED,
    UNSOLVABLE,
)
from kabo.finite_domain.kernels.seen import find, place
from kabo.finite_domain.kernels.successors import applicable, apply, at_goal, hashed

NEXT, TOUCHED, PLACES = (
    EXPANDED,
    OWN,
    OWN + 1,
)  # places of `progress`: the state to expand next counts them as well
BATCH = 128


class Seen(NamedTuple):
    """The states found so far, in the order of their rows."""

    states: NDArray[np.uint64]  # (S, W)
    parents: NDArray[np.int32]  # (S,)
    table: NDArray[np.uint64]  # (P,)
    progress: NDArray[np.int64]


class Batch(NamedTuple):
    """Scratch for the successors of a batch of states."""

    results: NDArray[np.uint64]  # (R, W)
    hashes: NDArray[np.uint64]  # (R,)
    origins: NDArray[np.int32]  # (R,)
    out: NDArray[np.int32]  # (O,) applicable operators


@lean_kernel  # Task, Seen, Batch, i8 -> i8
def expand(task, seen, batch, limit):
    """Expands up to `limit` more states; returns RUNNING, SOLVED, UNSOLVABLE, or FULL where arrays must grow first."""
    numbers, bits, never = task
    states, parents, table, progress = seen
    results, hashes, origins, out = batch
    operators = out.shape[0]
    end = progress[NEXT] + limit
    if progress[NEXT] == 0:
        find(table, states, states, 0, hashed(states, 0), 0)
    while progress[NEXT] < end:
        if progress[NEXT] == progress[COUNT]:
            return UNSOLVABLE
        first, made = progress[NEXT], 0
        row = first
        stop = min(end, progress[COUNT], first + BATCH)
        while row < stop and made + operators <= results.shape[0]:
            count = applicable(numbers, bits, states, row, never, out)
            for i in range(count):
                apply(numbers, bits, states, row, out[i], results, made)
                hashes[made] = hashed(results, made)
                origins[made] = row
                made += 1
            row += 1
        known = progress[COUNT]
        if known + made > states.shape[0] or 10 * (known + made) > 7 * table.shape[0]:
            return FULL
        touched = np.uint64(0)
        for r in range(made):
            touched ^= table[place(hashes[r], table.shape[0])]
        progress[TOUCHED] = np.int64(touched >> np.uint64(1))
        for r in range(made):
            if find(table, states, results, r, hashes[r], known) >= 0:
                continue
            for w in range(states.shape[1]):
                states[known, w] = results[r, w]
            parents[known] = origins[r]
            known += 1
            if at_goal(numbers, bits, states, known - 1):
                progress[COUNT], progress[NEXT], progress[GOAL] = known, origins[r] + 1, known - 1
                progress[GENERATED] += r + 1
                return SOLVED
        progress[COUNT], progress[NEXT] = known, row
        progress[GENERATED] += made
    return RUNNING
