"""Novelty-guided best-first search over packed states [kabo.finite_domain.search.plain_novelty does the same in Python].

`layout` describes goals and facts. It begins with the numbers of variables and goals, and the index of each table: the
test of each goal with the values it allows; the goals ordered before each goal; and for each variable its word, shift,
mask, first fact, and first fact among those that can change, or -1.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel
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
from kabo.finite_domain.kernels.relaxed_plan import relaxed_plan
from kabo.finite_domain.kernels.seen import find
from kabo.finite_domain.kernels.successors import applicable, apply, content, hashed

VARIABLES, GOALS, TESTS, BEFORE_OF, BEFORE, PLACES, FACTS, CHANGING, OWNERS = 0, 1, 2, 3, 4, 5, 6, 7, 8
# Columns of `rows`: open goals, facts reached, its relaxed plan, its partition, the next in its queue.
OPEN, REACHED, PLAN, PARTITION, AFTER, COLUMNS = range(FIRST_OWN, FIRST_OWN + 6)
PLANS, PLAN_FACTS, PARTITIONS, STEPS = range(OWN, OWN + 4)  # places of `progress`
MOST_PLAN_FACTS = 256
ONE = np.uint64(1)


class Store(NamedTuple):
    """The states found so far, with the relaxed plans that they follow, and what was seen; these arrays grow."""

    states: NDArray[np.uint64]  # (S, W)
    rows: NDArray[np.int32]  # (S, 7)
    reached: NDArray[np.uint64]  # (S, 4) a bit for each fact of the relaxed plan
    known: NDArray[np.uint64]  # (H,)
    plans: NDArray[np.int32]  # (P, 2) first fact, number of facts
    plan_facts: NDArray[np.int32]  # (Q,)
    facts_seen: NDArray[np.uint8]  # (Y, C)
    pairs_seen: NDArray[np.uint64]  # (Z, D)


class Partitions(NamedTuple):
    """The numbers of the partitions, the queues, and how far the search is."""

    layout: NDArray[np.int32]
    numbered: NDArray[np.int32]
    queues: NDArray[np.int32]  # (K, 2) first and last state
    progress: NDArray[np.int64]


class Relaxed(NamedTuple):
    """The arguments of `relaxed_plan`."""

    table: NDArray[np.int32]
    scratch: NDArray[np.int32]
    words: NDArray[np.uint64]  # empty
    true: NDArray[np.int32]  # (V,)
    goal: NDArray[np.int32]
    out: NDArray[np.int32]


class Work(NamedTuple):
    """Scratch."""

    holding: NDArray[np.int64]  # (F,) the last state in which each fact held
    done: NDArray[np.int32]  # (G,)
    changing: NDArray[np.int32]  # (2, V)
    fact_bits: NDArray[np.uint64]
    able: NDArray[np.int32]  # (O,)
    after: NDArray[np.uint64]  # (1, W)


@lean_kernel  # (L,) i4, (S, W) u8, i8, (G,) i4 -> i8
def _open_goals(layout, states, row, done):
    """The number of goals that do not count as reached, along the goal agenda."""
    goals, tests = layout[GOALS], layout[TESTS]
    for k in range(goals):
        at = tests + 4 * k
        done[k] = layout[layout[at + 3] + content(layout, states, row, at)]
    count = 0
    for k in range(goals):
        left = done[k] == 0
        for i in range(layout[layout[BEFORE_OF] + k], layout[layout[BEFORE_OF] + k + 1]):
            left = left or done[layout[layout[BEFORE] + i]] == 0
        if left:
            count += 1
    return count


@lean_kernel  # Store, i8, i8, (F,) i8 -> i8
def _inherit(store, row, parent, holding):
    """Takes over the parent's relaxed plan; returns how many of its facts have been true since it was made."""
    rows, reached, plans, plan_facts = store.rows, store.reached, store.plans, store.plan_facts
    plan = rows[parent, PLAN]
    rows[row, PLAN] = plan
    count = rows[parent, REACHED]
    for w in range(reached.shape[1]):
        reached[row, w] = reached[parent, w]
    for i in range(plans[plan, 1]):
        bit = ONE << np.uint64(i & 63)
        if reached[row, i >> 6] & bit == 0:
            f = plan_facts[plans[plan, 0] + i]
            if holding[f] == row:
                reached[row, i >> 6] |= bit
                count += 1
    return count


@lean_kernel  # Store, i8, Partitions, Relaxed -> bool
def _plan(store, row, partitions, relaxed):
    """Makes and keeps a relaxed plan for the state whose facts are `true`; returns whether there is one."""
    rows, reached, plans, plan_facts = store.rows, store.reached, store.plans, store.plan_facts
    layout, progress, out = partitions.layout, partitions.progress, relaxed.out
    value = relaxed_plan(relaxed.table, relaxed.scratch, relaxed.words, relaxed.true, relaxed.goal, out)
    plan, at = progress[PLANS], progress[PLAN_FACTS]
    count = 0
    if value >= 0:
        for i in range(out[1]):
            f = out[2 + layout[OWNERS] + i]
            if f < layout[FACTS] and count < MOST_PLAN_FACTS:
                plan_facts[at + count] = f
                count += 1
    plans[plan, 0], plans[plan, 1] = at, count
    progress[PLANS] += 1
    progress[PLAN_FACTS] += count
    rows[row, PLAN] = plan
    for w in range(reached.shape[1]):
        reached[row, w] = 0
    return value >= 0


@lean_kernel  # i8 -> i8
def _first_word(f):
    """The index of the first word of fact f's row, which has a bit for every fact up to f."""
    whole = f >> 6
    return 32 * whole * (whole + 1) + (f & 63) * (whole + 1)


@lean_kernel  # (V,) i4, (V,) i4, i8, bool, (C,) u8, (Z,) u8 -> bool
def _new_pair(now, before, count, same, bits, pairs):
    """Records the state's pairs of facts; returns whether any is new. With `same` only pairs with a changed fact count."""
    new = False
    for i in range(count):
        bits[now[i] >> 6] |= ONE << np.uint64(now[i] & 63)
    for i in range(count):
        f = now[i]
        if same and before[i] == f:
            continue
        row, last = _first_word(f), f >> 6
        fresh = np.uint64(0)
        for w in range(last):
            fresh |= bits[w] & ~pairs[row + w]
            pairs[row + w] |= bits[w]
        below = bits[last] & ((ONE << np.uint64(f & 63)) - ONE)
        fresh |= below & ~pairs[row + last]
        pairs[row + last] |= below
        new = new or fresh != 0
        if same:  # else the greater facts look at this one themselves
            bit = ONE << np.uint64(f & 63)
            for j in range(count):
                if now[j] > f:
                    at = _first_word(now[j]) + last
                    new = new or pairs[at] & bit == 0
                    pairs[at] |= bit
    for i in range(count):
        bits[now[i] >> 6] = 0
    return new


@lean_kernel  # (L,) i4, Store, i8, i8, (2, V) i4, (C,) u8 -> i8
def _novelty(layout, store, row, parent, changing, fact_bits):
    """The state's novelty (3: above 2); records its facts and pairs of facts."""
    states, rows, facts_seen, pairs_seen = store.states, store.rows, store.facts_seen, store.pairs_seen
    partition = rows[row, PARTITION]
    same = parent >= 0 and rows[parent, PARTITION] == partition
    now, before = changing[0], changing[1]
    count, new = 0, False
    for v in range(layout[VARIABLES]):
        at = layout[PLACES] + 5 * v
        if layout[at + 4] < 0:
            continue
        f = layout[at + 4] + content(layout, states, row, at)
        now[count] = f
        if same:
            before[count] = layout[at + 4] + content(layout, states, parent, at)
        count += 1
        if facts_seen[partition, f] == 0:
            facts_seen[partition, f] = 1
            new = True
    paired = partition < pairs_seen.shape[0] and _new_pair(
        now, before, count, same, fact_bits, pairs_seen[partition]
    )
    if new:
        return 1
    return 2 if paired else 3


@lean_kernel  # Store, Partitions, Relaxed, Work, i8, i8, i8 -> bool
def _enter(store, partitions, relaxed, work, row, parent, operator):
    """Keeps a new state, and queues it unless the goal is out of its reach; returns whether it fulfils the goal."""
    layout, numbered, queues, progress = partitions
    states, rows, true, holding = store.states, store.rows, relaxed.true, work.holding
    rows[row, PARENT], rows[row, OPERATOR], rows[row, AFTER] = parent, operator, -1
    goals = _open_goals(layout, states, row, work.done)
    rows[row, OPEN] = goals
    if goals == 0:
        return True
    for v in range(layout[VARIABLES]):
        at = layout[PLACES] + 5 * v
        true[v] = layout[at + 3] + content(layout, states, row, at)
        holding[true[v]] = row
    count = 0
    if parent < 0 or goals < rows[parent, OPEN]:
        if not _plan(store, row, partitions, relaxed):
            rows[row, PARTITION] = -1
            return False
    else:
        count = _inherit(store, row, parent, holding)
    rows[row, REACHED] = count
    key = goals * (MOST_PLAN_FACTS + 1) + count
    if numbered[key] < 0:
        numbered[key] = progress[PARTITIONS]
        progress[PARTITIONS] += 1
    rows[row, PARTITION] = numbered[key]
    novelty = _novelty(layout, store, row, parent, work.changing, work.fact_bits)
    queue = (novelty - 1) * (layout[GOALS] + 1) + goals
    if queues[queue, 0] < 0:
        queues[queue, 0] = row
    else:
        rows[queues[queue, 1], AFTER] = row
    queues[queue, 1] = row
    return False


@lean_kernel  # (K, 2) i4 -> i8
def _first_waiting(queues):
    """The first queue in which a state waits; the number of queues if there is none."""
    queue = 0
    while queue < queues.shape[0] and queues[queue, 0] < 0:
        queue += 1
    return queue


@lean_kernel  # Store, (X,) i8, i8, i8 -> bool
def _has_room(store, progress, count, most_pairs):
    """Whether all tables have room for `count` states more."""
    return (
        progress[COUNT] + count <= store.states.shape[0]
        and 10 * (progress[COUNT] + count) <= 7 * store.known.shape[0]
        and progress[PLANS] + count <= store.plans.shape[0]
        and progress[PLAN_FACTS] + count * MOST_PLAN_FACTS <= store.plan_facts.shape[0]
        and progress[PARTITIONS] + count <= store.facts_seen.shape[0]
        and min(progress[PARTITIONS] + count, most_pairs) <= store.pairs_seen.shape[0]
    )


@lean_kernel  # Task, Store, Partitions, Relaxed, Work, i8, i8 -> i8
def expand(task, store, partitions, relaxed, work, limit, most_pairs):
    """Expands up to `limit` more states; returns RUNNING, SOLVED, UNSOLVABLE, or FULL if arrays must grow first.

    The arrays must have space for at least one more state, since the first call stores the start.
    """
    numbers, bits, never = task
    states, rows, known = store.states, store.rows, store.known
    queues, progress, able, after = partitions.queues, partitions.progress, work.able, work.after
    if progress[COUNT] == 0:
        find(known, states, states, 0, hashed(states, 0), 0)
        progress[COUNT] = 1
        if _enter(store, partitions, relaxed, work, 0, -1, -1):
            progress[GOAL] = 0
            return SOLVED
    end = progress[EXPANDED] + limit
    while progress[EXPANDED] < end:
        queue = _first_waiting(queues)
        if queue == queues.shape[0]:
            return UNSOLVABLE
        row = queues[queue, 0]
        count = applicable(numbers, bits, states, row, never, able)
        if not _has_room(store, progress, count, most_pairs):
            return FULL
        queues[queue, 0] = rows[row, AFTER]
        progress[EXPANDED] += 1
        for i in range(count):
            apply(numbers, bits, states, row, able[i], after, 0)
            progress[GENERATED] += 1
            new = progress[COUNT]
            if find(known, states, after, 0, hashed(after, 0), new) >= 0:
                continue
            for w in range(states.shape[1]):
                states[new, w] = after[0, w]
            progress[COUNT] = new + 1
            if _enter(store, partitions, relaxed, work, new, row, able[i]):
                progress[GOAL] = new
                return SOLVED
    return RUNNING
