"""A binary heap of edges by cost; equal costs are ordered by the vertices' indices, so that the order is unique."""

from kabo.compilation import lean_kernel


@lean_kernel  # f8, i8, i8, (H,) f8, (H, 3) i8, i8 -> bool
def _before(cost, first, second, costs, edges, i):
    if cost != costs[i]:
        return cost < costs[i]
    if first != edges[i, 0]:
        return first < edges[i, 0]
    return second < edges[i, 1]


@lean_kernel  # (H,) f8, (H, 3) i8, i8, f8, i8 x 3 -> i8
def push(costs, edges, size, cost, first, second, stamp):
    """Adds an edge with its stamp; returns the new size. The arrays must have a free slot."""
    i = size
    while i > 0:
        parent = (i - 1) // 2
        if not _before(cost, first, second, costs, edges, parent):
            break
        costs[i], edges[i, 0], edges[i, 1], edges[i, 2] = (
            costs[parent],
            edges[parent, 0],
            edges[parent, 1],
            edges[parent, 2],
        )
        i = parent
    costs[i], edges[i, 0], edges[i, 1], edges[i, 2] = cost, first, second, stamp
    return size + 1


@lean_kernel  # (H,) f8, (H, 3) i8, i8 -> i8
def pop(costs, edges, size):
    """Removes the cheapest entry, which the caller reads before; returns the new size."""
    size -= 1
    cost, first, second, stamp = costs[size], edges[size, 0], edges[size, 1], edges[size, 2]
    i = 0
    while 2 * i + 1 < size:
        child = 2 * i + 1
        if child + 1 < size and _before(
            costs[child + 1], edges[child + 1, 0], edges[child + 1, 1], costs, edges, child
        ):
            child += 1
        if _before(cost, first, second, costs, edges, child):
            break
        costs[i], edges[i, 0], edges[i, 1], edges[i, 2] = (
            costs[child],
            edges[child, 0],
            edges[child, 1],
            edges[child, 2],
        )
        i = child
    costs[i], edges[i, 0], edges[i, 1], edges[i, 2] = cost, first, second, stamp
    return size
