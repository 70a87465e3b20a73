"""Novelty-guided best-first search over packed states [kabo.finite_domain.search.plain_novelty does the same in Python].

`layout` describes goals and facts. It begins with the numbers of variables and goals, and the index of each table: the
test of each goal with the values it allows; the goals ordered before each goal; and for each variable its word, shift,
mask, first fact, and first fact among those that can change, or -1.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.finite_domain.kernels.relaxed_plan import relaxed_plan
from kabo.finite_domain.kernels.seen import find
from kabo.finite_domain.kernels.successors import applicable, apply, content, hashed

VARIABLES, GOALS, TESTS, BEFORE_OF, BEFORE, PLACES, FACTS, CHANGING, OWNERS = 0, 1, 2, 3, 4, 5, 6, 7, 8
# Columns of `rows`: parent, operator, open goals, facts reached, its relaxed plan, its partition, the next in its queue.
PARENT, OPERATOR, OPEN, REACHED, PLAN, PARTITION, AFTER = 0, 1, 2, 3, 4, 5, 6
COUNT, EXPANDED, GENERATED, PLANS, PLAN_FACTS, PARTITIONS, GOAL = 0, 1, 2, 3, 4, 5, 6  # places of `progress`
RUNNING, SOLVED, UNSOLVABLE, FULL = 0, 1, 2, 3
MOST_PLAN_FACTS = 256
ONE = np.uint64(1)


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


@lean_kernel  # (L,) i4, (S, W) u8, (S, 7) i4, (S, 4) u8, i8, i8, (P, 2) i4, (Q,) i4, (F,) i4 -> i8
def _inherit(layout, states, rows, reached, row, parent, plans, plan_facts, holding):
    """Takes over the parent's relaxed plan; returns how many of its facts have been true since it was made."""
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


@lean_kernel  # (L,) i4, (S, 7) i4, (S, 4) u8, i8, (P, 2) i4, (Q,) i4, (X,) i8, relaxed plan's … -> bool
def _plan(layout, rows, reached, row, plans, plan_facts, progress, table, scratch, true, goal, out, no_words):
    """Makes and keeps a relaxed plan for the state whose facts are `true`; returns whether there is one."""
    value = relaxed_plan(table, scratch, no_words, true, goal, out)
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


@lean_kernel  # (L,) i4, (S, W) u8, (S, 7) i4, i8, i8, (Y, C) u1, (Z, D) u8, (2, V) i4, (C,) u8 -> i8
def _novelty(layout, states, rows, row, parent, facts_seen, pairs_seen, changing, fact_bits):
    """The state's novelty (3: above 2); records its facts and pairs of facts."""
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


@lean_kernel  # see `expand`
def _enter(
    layout, states, rows, reached, row, parent, operator, plans, plan_facts, numbered, facts_seen, pairs_seen,
    queues, progress, table, scratch, true, holding, goal, out, no_words, done, changing, fact_bits,
):  # fmt: skip
    """Keeps a new state, and queues it unless the goal is out of its reach; returns whether it fulfils the goal."""
    rows[row, PARENT], rows[row, OPERATOR], rows[row, AFTER] = parent, operator, -1
    goals = _open_goals(layout, states, row, done)
    rows[row, OPEN] = goals
    if goals == 0:
        return True
    for v in range(layout[VARIABLES]):
        at = layout[PLACES] + 5 * v
        true[v] = layout[at + 3] + content(layout, states, row, at)
        holding[true[v]] = row
    count = 0
    if parent < 0 or goals < rows[parent, OPEN]:
        if not _plan(
            layout, rows, reached, row, plans, plan_facts, progress, table, scratch, true, goal, out, no_words
        ):
            rows[row, PARTITION] = -1
            return False
    else:
        count = _inherit(layout, states, rows, reached, row, parent, plans, plan_facts, holding)
    rows[row, REACHED] = count
    key = goals * (MOST_PLAN_FACTS + 1) + count
    if numbered[key] < 0:
        numbered[key] = progress[PARTITIONS]
        progress[PARTITIONS] += 1
    rows[row, PARTITION] = numbered[key]
    novelty = _novelty(layout, states, rows, row, parent, facts_seen, pairs_seen, changing, fact_bits)
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


@lean_kernel
def _has_room(states, known, plans, plan_facts, facts_seen, pairs_seen, progress, count, most_pairs):
    """Whether all tables have room for `count` states more."""
    return (
        progress[COUNT] + count <= states.shape[0]
        and 10 * (progress[COUNT] + count) <= 7 * known.shape[0]
        and progress[PLANS] + count <= plans.shape[0]
        and progress[PLAN_FACTS] + count * MOST_PLAN_FACTS <= plan_facts.shape[0]
        and progress[PARTITIONS] + count <= facts_seen.shape[0]
        and min(progress[PARTITIONS] + count, most_pairs) <= pairs_seen.shape[0]
    )


@lean_kernel  # (T,) i4, (B,) u8, (G,) u8, (L,) i4, (S, W) u8, (S, 7) i4, (S, 4) u8, (H,) u8, (P, 2) i4, (Q,) i4, …
def expand(
    numbers, bits, never, layout, states, rows, reached, known, plans, plan_facts, numbered, facts_seen, pairs_seen,
    queues, progress, table, scratch, true, holding, goal, out, no_words, done, changing, fact_bits,
    able, after, limit, most_pairs,
):  # fmt: skip
    """Expands up to `limit` more states; returns RUNNING, SOLVED, UNSOLVABLE, or FULL if arrays must grow first.

    The arrays must have space for at least one more state, since the first call stores the start.
    """
    if progress[COUNT] == 0:
        find(known, states, states, 0, hashed(states, 0), 0)
        progress[COUNT] = 1
        if _enter(
            layout, states, rows, reached, 0, -1, -1, plans, plan_facts, numbered, facts_seen, pairs_seen,
            queues, progress, table, scratch, true, holding, goal, out, no_words, done, changing, fact_bits,
        ):  # fmt: skip
            progress[GOAL] = 0
            return SOLVED
    end = progress[EXPANDED] + limit
    while progress[EXPANDED] < end:
        queue = _first_waiting(queues)
        if queue == queues.shape[0]:
            return UNSOLVABLE
        row = queues[queue, 0]
        count = applicable(numbers, bits, states, row, never, able)
        if not _has_room(states, known, plans, plan_facts, facts_seen, pairs_seen, progress, count, most_pairs):
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
            if _enter(
                layout, states, rows, reached, new, row, able[i], plans, plan_facts, numbered, facts_seen, pairs_seen,
                queues, progress, table, scratch, true, holding, goal, out, no_words, done, changing, fact_bits,
            ):  # fmt: skip
                progress[GOAL] = new
                return SOLVED
    return RUNNING
