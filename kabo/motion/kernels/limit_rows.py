"""Limits of a motion as rows over the time law: x, the square of the speed along a path, g = x' and w = x''.

The velocity of joint j is p_j' sqrt(x), its acceleration p_j'' x + p_j' g / 2, its jerk sqrt(x) (p_j''' x + 3/2 p_j'' g
+ p_j' w / 2). Rows are divided by the limits: a row of an acceleration must stay within [-1, 1], a row c of a jerk must
keep sqrt(x) |c| <= 1.
"""

from typing import NamedTuple

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.grids import HUGE, REST, slope


class Rows(NamedTuple):
    """The limits on a grid of N cells of lengths h (N,).

    x has caps at nodes (N + 1,) and in the middle of cells (N,). `held` is empty but for one entry if nothing is held.

    `node_rows` (r, 2) of (x, g) belong to node i from `node_start[i]` to `node_start[i + 1]`; `cell_rows` (r, 3, 3)
    are of (x, g, w): of the jerk at the left and the right end of a cell, of the acceleration in its middle by x, g, w at
    the left end. The latter is zero on straight cells.
    """

    h: np.ndarray
    cap: np.ndarray
    middle_cap: np.ndarray
    node_start: np.ndarray
    node_rows: np.ndarray
    cell_start: np.ndarray
    cell_rows: np.ndarray
    held: np.ndarray


@kernel  # (k, n, 6) f8, (k + 1,) f8, (k,) b1, (N + 1,) f8, (N,) i8, (3, n) f8, (N, 3) f8, (N + 1, 2, 3) f8 -> Rows
def limit_rows(pieces, borders, curved, grid, owner, full, shares, held):
    """The rows of all limits; on straight cells one joint decides. Each cell may use a share of each limit."""
    n, cells = pieces.shape[1], len(owner)
    h, cap, middle_cap = np.empty(cells), np.full(cells + 1, HUGE), np.full(cells, HUGE)
    node_start, cell_start = np.zeros(cells + 2, np.int64), np.zeros(cells + 1, np.int64)
    node_rows, cell_rows = np.empty((n * (cells + 1), 2)), np.zeros((n * cells, 3, 3))
    d, middle, limits = np.empty((2, 4, n)), np.empty((2, n)), np.empty((3, n))
    for i in range(cells):
        h[i] = grid[i + 1] - grid[i]
        p = owner[i]
        for order in range(3):
            for j in range(n):
                limits[order, j] = full[order, j] * shares[i, order]
        for e in range(2):
            for order in range(1, 4):
                slope(pieces[p], grid[i + e] - borders[p], order, d[e, order])
            for j in range(n):
                size = abs(d[e, 1, j])
                if size > 1e-12:
                    cap[i + e] = min(cap[i + e], (limits[0, j] / size) ** 2)
        if i == 0 or i == cells - 1:
            # From rest, jerk is constant up to the first node: it bounds x there.
            e = 1 if i == 0 else 0
            for j in range(n):
                size = max(abs(d[0, 1, j]), abs(d[1, 1, j]))
                if size > 1e-12:
                    most = REST * (limits[2, j] / size) ** (2.0 / 3.0) * h[i] ** (4.0 / 3.0)
                    cap[i + e] = min(cap[i + e], most)
        at, to = node_start[i], cell_start[i]
        if curved[p]:
            t, u = 0.5 * h[i], 0.125 * h[i] * h[i]
            for order in range(2):
                slope(pieces[p], 0.5 * (grid[i] + grid[i + 1]) - borders[p], order + 1, middle[order])
            for j in range(n):
                if abs(middle[0, j]) > 1e-12:
                    middle_cap[i] = min(middle_cap[i], (limits[0, j] / middle[0, j]) ** 2)
                if max(abs(d[0, 1, j]), abs(d[0, 2, j]), abs(d[1, 1, j])) > 1e-12:
                    node_rows[at, 0] = d[0, 2, j] / limits[1, j]
                    node_rows[at, 1] = 0.5 * d[0, 1, j] / limits[1, j]
                    at += 1
                    for e in range(2):
                        cell_rows[to, e, 0] = d[e, 3, j] / limits[2, j]
                        cell_rows[to, e, 1] = 1.5 * d[e, 2, j] / limits[2, j]
                        cell_rows[to, e, 2] = 0.5 * d[e, 1, j] / limits[2, j]
                    a, b = middle[1, j] / limits[1, j], 0.5 * middle[0, j] / limits[1, j]
                    cell_rows[to, 2, 0], cell_rows[to, 2, 1], cell_rows[to, 2, 2] = a, t * a + b, u * a + t * b
                    to += 1
        else:
            hard, sharp = 0.0, 0.0
            for j in range(n):
                size = abs(d[0, 1, j])
                if size > 1e-12:
                    middle_cap[i] = min(middle_cap[i], (limits[0, j] / size) ** 2)
                    hard, sharp = max(hard, size / limits[1, j]), max(sharp, size / limits[2, j])
            node_rows[at, 0], node_rows[at, 1] = 0.0, 0.5 * hard
            for e in range(2):
                cell_rows[to, e, 0], cell_rows[to, e, 1], cell_rows[to, e, 2] = 0.0, 0.0, 0.5 * sharp
            at, to = at + 1, to + 1
        node_start[i + 1], cell_start[i + 1] = at, to
    node_start[cells + 1] = node_start[cells]
    return Rows(h, cap, middle_cap, node_start, node_rows, cell_start, cell_rows, held)
