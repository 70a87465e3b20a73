"""Relaxed plans in plain Python, for tasks too small to wait for compiled code.

Facts are settled from the same buckets in the same order as in the kernel, so both find the same relaxed plans,
preferred owners and achieved facts [kabo.finite_domain.kernels.relaxed_plan].
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

UNREACHED = 1 << 30  # the cost of a fact that is not reached, above all others


@dataclass(frozen=True)
class PlainTables:
    """The operators of a relaxation, a list for each property, since Python reads lists faster than arrays."""

    preconditions: list[list[int]]
    adds: list[list[int]]
    uses: list[list[int]]  # for each fact the operators that need it
    waiting: list[int]  # for each operator the number of its preconditions
    prices: list[int]  # costs by which supporters are compared
    costs: list[int]  # costs that are added up to the cost of a plan
    owners: list[int]
    free: list[int]  # operators without preconditions
    limit: int  # h_add is cut off here
    unit: int  # the width of a bucket of the queue
    buckets: int


def relaxed_plan(
    tables: PlainTables, true: Iterable[int], goal: Sequence[int]
) -> tuple[int | None, list[int], list[int]]:
    """The cost of a relaxed plan, the owners of its operators that are applicable now, and the facts it achieves.

    The cost is None if there is no relaxed plan.
    """
    cost, supporter = _reach(tables, true, goal)
    if any(cost[f] == UNREACHED for f in goal):
        return None, [], []
    return _extract(tables, cost, supporter, goal)


def _reach(tables: PlainTables, true: Iterable[int], goal: Sequence[int]) -> tuple[list[int], list[int]]:
    """The h_add costs of facts as far as the goal needs them, and the first operator that achieves each at its cost."""
    count = len(tables.uses)
    cost, told = [UNREACHED] * count, [UNREACHED] * count
    supporter, place = [-1] * count, [-1] * count
    waiting, totals = list(tables.waiting), list(tables.prices)
    limit, unit, last = tables.limit, tables.unit, tables.buckets - 1
    queue: dict[int, list[int]] = {0: []}
    for f in true:
        if cost[f]:
            cost[f] = place[f] = 0
            queue[0].append(f)

    def fire(o: int, price: int) -> None:
        for f in tables.adds[o]:
            if price < cost[f]:
                cost[f], supporter[f] = price, o
                b = price // unit if price < last * unit else last
                if place[f] != b:
                    place[f] = b
                    if b in queue:
                        queue[b].append(f)
                    else:
                        queue[b] = [f]

    for o in tables.free:
        fire(o, min(totals[o], limit))
    b = settled = 0
    while queue and settled < len(goal):
        for f in queue.get(b, ()):
            if place[f] != b:
                continue
            place[f] = -1
            first = told[f] == UNREACHED
            change = cost[f] if first else cost[f] - told[f]
            told[f] = cost[f]
            for o in tables.uses[f]:
                if first:
                    waiting[o] -= 1
                totals[o] += change
                if not waiting[o]:
                    fire(o, min(totals[o], limit))
        queue.pop(b, None)
        b += 1
        while settled < len(goal) and cost[goal[settled]] < b * unit:
            settled += 1
    return cost, supporter


def _extract(
    tables: PlainTables, cost: list[int], supporter: list[int], goal: Sequence[int]
) -> tuple[int, list[int], list[int]]:
    """The cost of the goal's supporters, their owners that are applicable now, and the facts they achieve."""
    stack: list[int] = []
    marked: set[int] = set()

    def need(f: int) -> None:
        if f not in marked:
            marked.add(f)
            stack.append(f)

    for f in goal:
        if cost[f] > 0:
            need(f)
    value = 0
    used: set[int] = set()
    paid: dict[int, int] = {}
    ready: dict[int, None] = {}
    made = []
    while stack:
        f = stack.pop()
        made.append(f)
        o = supporter[f]
        if o in used:
            continue
        used.add(o)
        open_preconditions = [p for p in tables.preconditions[o] if cost[p] > 0]
        for p in open_preconditions:
            need(p)
        owner, price = tables.owners[o], tables.costs[o]
        if owner < 0:
            value += price
            continue
        value += max(0, price - paid.get(owner, 0))
        paid[owner] = max(price, paid.get(owner, 0))
        if not open_preconditions:
            ready[owner] = None
    return value, list(ready), made
