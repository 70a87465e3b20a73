"""LM-cut: a lower bound of the goal's cost, from landmarks with shared costs [Helmert, Domshlak 2009].

A landmark is a set of operators of which every plan has at least one. An operator may count in several landmarks
until its cost is used up, so the sum is never too high. The relaxation has one operator with a cost for each
operator of the task, and axioms for that operator's conditional effects, so that these effects share the cost
[kabo.finite_domain.heuristics.relaxed_facts].

The array `lm` holds all tables; it begins with the index of each table [kabo.finite_domain.heuristics.landmarks].
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel
from kabo.finite_domain.kernels.successors import content

FACTS, OPERATORS, GOAL, VARIABLES, GOALS, ENDS, FREE_COUNT, FIRST = 0, 1, 2, 3, 4, 5, 6, 7
PRE_OF, PRE, ADD_OF, ADD, USE_OF, USE, MADE_OF, MADE = 8, 9, 10, 11, 12, 13, 14, 15
FREE, PLACES, TESTS, THEN_OF, THEN = 16, 17, 18, 19, 20
INFINITE_COST = 1 << 60  # of what is out of reach; above the cost of any plan
OUTSIDE, ZONE, BEFORE = 0, 1, 2  # marks of facts


class Relaxation(NamedTuple):
    """A relaxation for LM-cut, and scratch; F facts, O operators."""

    lm: NDArray[np.int32]  # tables
    prices: NDArray[np.int64]  # (O,) costs; INFINITE_COST for operators that must not be used
    holding: NDArray[np.uint8]  # (F,) 1 for each fact that holds, else 0
    price: NDArray[np.int64]  # (O,) costs that are left
    operator: NDArray[np.int64]  # (O, 2) preconditions to come, supporter
    cost: NDArray[np.int64]  # (F,) h_max
    heap: NDArray[np.int32]  # (F,)
    place: NDArray[np.int32]  # (F,) in the heap
    mark: NDArray[np.int32]  # (F,)
    stack: NDArray[np.int32]  # (F,)
    cut: NDArray[np.int32]  # (O,)


@lean_kernel  # (F,) i4, (F,) i4, (F,) i8, i8, i8 -> i8
def _raise(heap, place, cost, size, f):
    """Moves fact f, whose cost has just fallen, to its place in the heap; returns the size of the heap."""
    i = place[f]
    if i < 0:
        i = size
        size += 1
    while i > 0:
        parent = (i - 1) // 2
        g = heap[parent]
        if cost[g] < cost[f] or (cost[g] == cost[f] and g <= f):
            break
        heap[i] = g
        place[g] = i
        i = parent
    heap[i] = f
    place[f] = i
    return size


@lean_kernel  # (F,) i4, (F,) i4, (F,) i8, i8 -> i8
def _drop(heap, place, cost, size):
    """Removes the cheapest fact, of equally cheap ones the first; returns the size of the heap."""
    place[heap[0]] = -1
    size -= 1
    f, i = heap[size], 0
    if size == 0:
        return 0
    while 2 * i + 1 < size:
        child = 2 * i + 1
        g = heap[child]
        if child + 1 < size:
            other = heap[child + 1]
            if cost[other] < cost[g] or (cost[other] == cost[g] and other < g):
                child += 1
                g = other
        if cost[f] < cost[g] or (cost[f] == cost[g] and f <= g):
            break
        heap[i] = g
        place[g] = i
        i = child
    heap[i] = f
    place[f] = i
    return size


@lean_kernel  # (L,) i4, (S, W) u8, i8, (F,) u1, (F,) i4
def facts_that_hold(lm, states, row, holding, stack):
    """Marks the facts that hold in the state: its values, and "holds at the end" for each goal that can stay true.

    A goal that holds cannot stay true if something that must still be achieved requires the goal to be false.
    """
    facts, goals, ends = lm[FACTS], lm[GOALS], lm[ENDS]
    for f in range(facts):
        holding[f] = 0
    for v in range(lm[VARIABLES]):
        at = lm[PLACES] + 4 * v
        holding[lm[at + 3] + content(lm, states, row, at)] = 1
    depth = 0
    for k in range(goals):
        at = lm[TESTS] + 4 * k
        if lm[lm[at + 3] + content(lm, states, row, at)] != 0:
            holding[ends + k] = 1
        else:
            holding[ends + k] = 2  # has to be achieved; marked so until this function ends
            stack[depth] = ends + k
            depth += 1
    while depth > 0:
        depth -= 1
        f = stack[depth]
        for i in range(lm[THEN] + lm[lm[THEN_OF] + f], lm[THEN] + lm[lm[THEN_OF] + f + 1]):
            g = lm[i]
            if holding[g] == 0 or (holding[g] == 1 and g >= ends):
                holding[g] = 2
                stack[depth] = g
                depth += 1
    for f in range(facts):
        if holding[f] == 2:
            holding[f] = 0


@lean_kernel  # (L,) i4, (F,) u1, (O,) i8, (O, 2) i8, (F,) i8, (F,) i4, (F,) i4
def costs_by_max(lm, holding, price, operator, cost, heap, place):
    """Computes h_max of all facts and the supporter of each operator.

    An operator costs its price plus the h_max value of its dearest precondition, which is its supporter.
    """
    size = 0
    for f in range(lm[FACTS]):
        cost[f] = INFINITE_COST
        place[f] = -1
    for f in range(lm[FACTS]):
        if holding[f] != 0:
            cost[f] = 0
            size = _raise(heap, place, cost, size, f)
    for o in range(lm[OPERATORS]):
        operator[o, 0] = lm[lm[PRE_OF] + o + 1] - lm[lm[PRE_OF] + o]  # preconditions to come
        operator[o, 1] = -1  # supporter
    for i in range(lm[FREE], lm[FREE] + lm[FREE_COUNT]):
        o = lm[i]
        if price[o] < INFINITE_COST:
            for j in range(lm[ADD] + lm[lm[ADD_OF] + o], lm[ADD] + lm[lm[ADD_OF] + o + 1]):
                if price[o] < cost[lm[j]]:
                    cost[lm[j]] = price[o]
                    size = _raise(heap, place, cost, size, lm[j])
    while size > 0:
        f = heap[0]
        size = _drop(heap, place, cost, size)
        for i in range(lm[USE] + lm[lm[USE_OF] + f], lm[USE] + lm[lm[USE_OF] + f + 1]):
            o = lm[i]
            operator[o, 0] -= 1
            if operator[o, 0] == 0 and price[o] < INFINITE_COST:
                operator[o, 1] = f
                total = cost[f] + price[o]
                for j in range(lm[ADD] + lm[lm[ADD_OF] + o], lm[ADD] + lm[lm[ADD_OF] + o + 1]):
                    if total < cost[lm[j]]:
                        cost[lm[j]] = total
                        size = _raise(heap, place, cost, size, lm[j])


@lean_kernel  # (L,) i4, (O,) i8, (O, 2) i8, (F,) i4, (F,) i4
def _goal_zone(lm, price, operator, mark, stack):
    """Marks the facts from which the goal is reached at no cost, along supporters."""
    for f in range(lm[FACTS]):
        mark[f] = OUTSIDE
    mark[lm[GOAL]] = ZONE
    stack[0] = lm[GOAL]
    depth = 1
    while depth > 0:
        depth -= 1
        f = stack[depth]
        for i in range(lm[MADE] + lm[lm[MADE_OF] + f], lm[MADE] + lm[lm[MADE_OF] + f + 1]):
            o = lm[i]
            supporter = operator[o, 1]
            if price[o] == 0 and supporter >= 0 and mark[supporter] == OUTSIDE:
                mark[supporter] = ZONE
                stack[depth] = supporter
                depth += 1


@lean_kernel  # (L,) i4, i8, (F,) i4, (F,) i4, i8, (O,) i4, i8 -> i8, i8
def _pass(lm, o, mark, stack, depth, cut, count):
    """Adds operator o to the cut if it leads into the goal zone; else visits the facts that it adds."""
    first, end = lm[ADD] + lm[lm[ADD_OF] + o], lm[ADD] + lm[lm[ADD_OF] + o + 1]
    for j in range(first, end):
        if mark[lm[j]] == ZONE:
            cut[count] = o
            return depth, count + 1
    for j in range(first, end):
        if mark[lm[j]] == OUTSIDE:
            mark[lm[j]] = BEFORE
            stack[depth] = lm[j]
            depth += 1
    return depth, count


@lean_kernel  # (L,) i4, (F,) u1, (O,) i8, (O, 2) i8, (F,) i4, (F,) i4, (O,) i4 -> i8
def _cut(lm, holding, price, operator, mark, stack, cut):
    """Fills `cut` with the operators that lead from outside the goal zone into it; returns how many."""
    depth, count = 0, 0
    for f in range(lm[FACTS]):
        if holding[f] != 0 and mark[f] == OUTSIDE:
            mark[f] = BEFORE
            stack[depth] = f
            depth += 1
    for i in range(lm[FREE], lm[FREE] + lm[FREE_COUNT]):
        if price[lm[i]] < INFINITE_COST:
            depth, count = _pass(lm, lm[i], mark, stack, depth, cut, count)
    while depth > 0:
        depth -= 1
        f = stack[depth]
        for i in range(lm[USE] + lm[lm[USE_OF] + f], lm[USE] + lm[lm[USE_OF] + f + 1]):
            if operator[lm[i], 1] == f:
                depth, count = _pass(lm, lm[i], mark, stack, depth, cut, count)
    return count


@lean_kernel  # (L,) i4, (O,) i8, (O, 2) i8, (F,) i8, (F,) i4, (F,) i4, i8, i8 -> i8
def _offer(lm, price, operator, cost, heap, place, o, size):
    """Lowers the costs of the facts that operator o adds to its present cost; returns the size of the heap."""
    supporter = operator[o, 1]
    total = price[o] + (cost[supporter] if supporter >= 0 else 0)
    for j in range(lm[ADD] + lm[lm[ADD_OF] + o], lm[ADD] + lm[lm[ADD_OF] + o + 1]):
        if total < cost[lm[j]]:
            cost[lm[j]] = total
            size = _raise(heap, place, cost, size, lm[j])
    return size


@lean_kernel  # (L,) i4, (O,) i8, (O, 2) i8, (F,) i8, (F,) i4, (F,) i4, (O,) i4, i8
def _lower(lm, price, operator, cost, heap, place, cut, count):
    """Updates h_max after the prices of the operators in the cut fell."""
    size = 0
    for i in range(count):
        size = _offer(lm, price, operator, cost, heap, place, cut[i], size)
    while size > 0:
        f = heap[0]
        size = _drop(heap, place, cost, size)
        for i in range(lm[USE] + lm[lm[USE_OF] + f], lm[USE] + lm[lm[USE_OF] + f + 1]):
            o = lm[i]
            if operator[o, 1] != f:
                continue
            for j in range(lm[PRE] + lm[lm[PRE_OF] + o], lm[PRE] + lm[lm[PRE_OF] + o + 1]):
                if cost[lm[j]] > cost[operator[o, 1]]:
                    operator[o, 1] = lm[j]
            size = _offer(lm, price, operator, cost, heap, place, o, size)


@lean_kernel  # Relaxation, bool -> i8
def bound_of_facts(relaxation, nearest_first):
    """A lower bound of the goal's cost from the facts that hold; INFINITE_COST if the goal is out of reach.

    Each landmark is computed for the goal with the highest h_max
    value, or with `nearest_first` for the goal with the lowest positive value: landmarks of near goals contain few
    operators, so more cost remains for the other goals. Either order may give the better bound.
    """
    lm, prices, holding, price, operator, cost, heap, place, mark, stack, cut = relaxation
    for o in range(lm[OPERATORS]):
        price[o] = prices[o]
    costs_by_max(lm, holding, price, operator, cost, heap, place)
    goal, bound = lm[GOAL], 0
    if cost[goal] >= INFINITE_COST:
        return INFINITE_COST
    last = lm[OPERATORS] - 1  # asks that all goals hold
    while cost[goal] > 0:
        dearest = operator[last, 1]
        if nearest_first:
            for i in range(lm[ENDS], goal):
                if 0 < cost[i] < cost[operator[last, 1]]:
                    operator[last, 1] = i
        _goal_zone(lm, price, operator, mark, stack)
        count = _cut(lm, holding, price, operator, mark, stack, cut)
        operator[last, 1] = dearest
        least = price[cut[0]]
        for i in range(1, count):
            least = min(least, price[cut[i]])
        bound += least
        for i in range(count):
            price[cut[i]] -= least
        _lower(lm, price, operator, cost, heap, place, cut, count)
    return bound


@lean_kernel  # Relaxation, (S, W) u8, i8, bool -> i8
def landmark_cut(relaxation, states, row, nearest_first):
    """A lower bound of the goal's cost from a packed state; it counts goals that have to be given up."""
    facts_that_hold(relaxation.lm, states, row, relaxation.holding, relaxation.stack)
    return bound_of_facts(relaxation, nearest_first)
