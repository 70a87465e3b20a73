"""Relaxed plans: deletes are ignored, and the goal is reached by the cheapest supporters by h_add [FF, HSP].

Facts are settled in the order of rising cost, from a queue of buckets, each one unit of cost wide. The last bucket
takes all dearer facts, whose costs are corrected until none changes. The queue is first in, first out, so
supporters are the same in every run and in plain Python [kabo.finite_domain.heuristics.plain_relaxation].

`table` and `scratch` are one array each, since passing an array from Python costs as much as settling ten facts.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel

# Numbers at the head of a table, then where its arrays begin.
FACTS, OPERATORS, BUCKETS, UNIT, LIMIT, FREE_OPERATORS, OWNERS = 0, 1, 2, 3, 4, 5, 6
STARTS = 8
PRECONDITIONS_OF, PRECONDITIONS, ADDS_OF, ADDS, USES_OF, USES, FRESH, COST, OWNER, FREE, END = range(8, 19)
HEAD = 20
UNREACHED = 1 << 30  # dearer than any fact
AT, NEXT, PREVIOUS, SPREAD, SUPPORTER, MARK = 0, 1, 2, 3, 4, 5  # columns of `facts`
COLUMNS = 6


class Links(NamedTuple):
    """Which facts each operator adds, and which operators need each fact: parts of a table."""

    adds_of: NDArray[np.int32]  # (O + 1,)
    adds: NDArray[np.int32]
    uses_of: NDArray[np.int32]  # (F + 1,)
    uses: NDArray[np.int32]


@lean_kernel  # (6F,) i4, (2K,) i4, i8, i8
def _remove(facts, ends, f, b):
    """Takes fact f out of bucket b."""
    after, before = facts[COLUMNS * f + NEXT], facts[COLUMNS * f + PREVIOUS]
    if before >= 0:
        facts[COLUMNS * before + NEXT] = after
    else:
        ends[2 * b] = after
    if after >= 0:
        facts[COLUMNS * after + PREVIOUS] = before
    else:
        ends[2 * b + 1] = before
    facts[COLUMNS * f + AT] = -1


@lean_kernel  # (6F,) i4, (2K,) i4, i8, i8
def _append(facts, ends, f, b):
    """Puts fact f at the end of bucket b, unless it is in that bucket already."""
    old = facts[COLUMNS * f + AT]
    if old == b:
        return
    if old >= 0:
        _remove(facts, ends, f, old)
    last = ends[2 * b + 1]
    facts[COLUMNS * f + AT], facts[COLUMNS * f + NEXT], facts[COLUMNS * f + PREVIOUS] = b, -1, last
    ends[2 * b + 1] = f
    if last >= 0:
        facts[COLUMNS * last + NEXT] = f
    else:
        ends[2 * b] = f


@lean_kernel  # (6F,) i4, (2K,) i4, (F,) i4, Links, i8 x 5 -> i8
def _fire(facts, ends, cost, links, o, price, unit, last, top):
    """Lowers the costs of the facts that operator o adds to `price`; returns the last bucket in use."""
    for i in range(links.adds_of[o], links.adds_of[o + 1]):
        f = links.adds[i]
        if price < cost[f]:
            cost[f] = price
            facts[COLUMNS * f + SUPPORTER] = o
            b = price if unit == 1 else price // unit
            b = min(b, last)
            _append(facts, ends, f, b)
            top = max(b, top)
    return top


@lean_kernel  # (T,) i4, (6F,) i4, (2K,) i4, (F,) i4, (2O,) i4, Links, (W,) u8, (N,) i4 -> i8
def _begin(table, facts, ends, cost, waiting, links, words, true):
    """Resets the arrays, queues the true facts and those of operators without preconditions; returns the last bucket."""
    for f in range(cost.shape[0]):
        cost[f] = UNREACHED
        facts[COLUMNS * f + AT] = -1
        facts[COLUMNS * f + SPREAD] = UNREACHED
    fresh = table[table[FRESH] : table[FRESH] + waiting.shape[0]]
    for i in range(waiting.shape[0]):
        waiting[i] = fresh[i]
    for w in range(words.shape[0]):
        bits = words[w]
        f = 64 * w
        while bits != 0:
            if bits & 1 != 0 and cost[f] != 0:
                cost[f] = 0
                _append(facts, ends, f, 0)
            bits >>= 1
            f += 1
    for i in range(true.shape[0]):
        f = true[i]
        if cost[f] != 0:
            cost[f] = 0
            _append(facts, ends, f, 0)
    top = 0
    for i in range(table[FREE_OPERATORS]):
        o = table[table[FREE] + i]
        price = min(waiting[2 * o + 1], table[LIMIT])
        top = _fire(facts, ends, cost, links, o, price, table[UNIT], table[BUCKETS] - 1, top)
    return top


@lean_kernel  # (T,) i4, (6F,) i4, (2K,) i4, (F,) i4, (2O,) i4, Links, (G,) i4, i8
def _reach(table, facts, ends, cost, waiting, links, goal, top):
    """Settles facts by rising cost until the whole goal is settled, or nothing is left."""
    settled, b = 0, 0
    unit, last, limit = table[UNIT], table[BUCKETS] - 1, table[LIMIT]
    while b <= top and settled < goal.shape[0]:
        while ends[2 * b] >= 0:
            f = ends[2 * b]
            _remove(facts, ends, f, b)
            price, told = cost[f], facts[COLUMNS * f + SPREAD]
            facts[COLUMNS * f + SPREAD] = price
            less, change = 1, price
            if told != UNREACHED:  # the operators that need it have counted it before, at a higher cost
                less, change = 0, price - told
            for i in range(links.uses_of[f], links.uses_of[f + 1]):
                o = links.uses[i]
                left = waiting[2 * o] - less
                total = waiting[2 * o + 1] + change
                waiting[2 * o] = left
                waiting[2 * o + 1] = total
                if left == 0:
                    top = _fire(facts, ends, cost, links, o, min(total, limit), unit, last, top)
        b += 1
        while settled < goal.shape[0] and cost[goal[settled]] < b * unit:
            settled += 1
    while b <= top:
        ends[2 * b], ends[2 * b + 1] = -1, -1
        b += 1


@lean_kernel  # (T,) i4, (6F,) i4, (F,) i4, (O,) i4, (2P,) i4, (F,) i4, (G,) i4, (R,) i4, i8 -> i8
def _extract(table, facts, cost, used, owners, stack, goal, out, epoch):
    """The cost of the goal's supporters; writes their owners that are applicable now, and their facts, into `out`."""
    depth, value, owned, needed = 0, 0, 0, 0
    for i in range(goal.shape[0]):
        f = goal[i]
        if cost[f] == UNREACHED:
            return -1
        if cost[f] > 0 and facts[COLUMNS * f + MARK] != epoch:
            facts[COLUMNS * f + MARK] = epoch
            stack[depth] = f
            depth += 1
    kept = 2 + table[OWNERS]
    while depth > 0:
        depth -= 1
        f = stack[depth]
        out[kept + needed] = f
        needed += 1
        o = facts[COLUMNS * f + SUPPORTER]
        if used[o] == epoch:
            continue
        used[o] = epoch
        now = True
        for i in range(table[table[PRECONDITIONS_OF] + o], table[table[PRECONDITIONS_OF] + o + 1]):
            p = table[table[PRECONDITIONS] + i]
            if cost[p] > 0:
                now = False
                if facts[COLUMNS * p + MARK] != epoch:
                    facts[COLUMNS * p + MARK] = epoch
                    stack[depth] = p
                    depth += 1
        price, w = table[table[COST] + o], table[table[OWNER] + o]
        if w < 0:
            value += price
            continue
        if owners[2 * w] // 2 != epoch:  # an owner pays once, for the dearest of its operators
            owners[2 * w], owners[2 * w + 1] = 2 * epoch, 0
        if price > owners[2 * w + 1]:
            value += price - owners[2 * w + 1]
            owners[2 * w + 1] = price
        if now and owners[2 * w] == 2 * epoch:
            owners[2 * w] = 2 * epoch + 1
            out[2 + owned] = w
            owned += 1
    out[0], out[1] = owned, needed
    return value


@lean_kernel  # (T,) i4, (S,) i4, (W,) u8, (N,) i4, (G,) i4, (R,) i4 -> i8
def relaxed_plan(table, scratch, words, true, goal, out):
    """The cost of a relaxed plan; -1 if the goal is out of reach even in the relaxation.

    The true facts are the bits of `words` and the numbers in `true`. `out` is filled with the number of owners
    that are applicable now, the number of facts that the plan achieves, from index 2 on these owners, and from
    index 2 + (number of all owners) on these facts.
    """
    n, m = table[FACTS], table[OPERATORS]
    scratch[0] += 1
    if scratch[0] == 1 << 29:  # the counter of calls restarts: marks of earlier calls must go
        scratch[:] = 0
        scratch[0] = 1
        for b in range(2 * table[BUCKETS]):
            scratch[1 + b] = -1
    at = 1
    ends = scratch[at : at + 2 * table[BUCKETS]]
    at += 2 * table[BUCKETS]
    facts = scratch[at : at + COLUMNS * n]
    at += COLUMNS * n
    cost = scratch[at : at + n]
    at += n
    waiting = scratch[at : at + 2 * m]
    at += 2 * m
    used = scratch[at : at + m]
    at += m
    owners = scratch[at : at + 2 * table[OWNERS]]
    at += 2 * table[OWNERS]
    stack = scratch[at : at + n]
    links = Links(
        table[table[ADDS_OF] : table[ADDS]],
        table[table[ADDS] : table[USES_OF]],
        table[table[USES_OF] : table[USES]],
        table[table[USES] : table[FRESH]],
    )
    top = _begin(table, facts, ends, cost, waiting, links, words, true)
    _reach(table, facts, ends, cost, waiting, links, goal, top)
    return _extract(table, facts, cost, used, owners, stack, goal, out, scratch[0])
