"""Grids of the time law: parameters of a path that a fast motion passes in about equal steps of time."""

import numpy as np

from kabo.compilation import kernel

REST = 0.25 * 6.0 ** (4.0 / 3.0)  # from rest with constant jerk J, the square of the speed is REST J^(2/3) s^(4/3)
HUGE = 1e18
LEAST = 6  # cells of a blend


@kernel  # (6,) f8, f8, (6,) f8 -> none
def delayed(source, delay, out):
    """Writes the same polynomial in powers of a parameter that begins `delay` later, by Horner's scheme."""
    for k in range(6):
        out[k] = source[k]
    for level in range(5):
        for k in range(4, level - 1, -1):
            out[k] += delay * out[k + 1]


@kernel  # (n, 6) f8, f8, i8, (n,) f8 -> none
def slope(piece, ds, order, out):
    """Writes the derivative of the given order (0 to 3) of a piece of a path, `ds` after its beginning."""
    for j in range(piece.shape[0]):
        c = piece[j]
        if order == 0:
            out[j] = c[0] + ds * (c[1] + ds * (c[2] + ds * (c[3] + ds * c[4])))
        elif order == 1:
            out[j] = c[1] + ds * (2.0 * c[2] + ds * (3.0 * c[3] + ds * 4.0 * c[4]))
        elif order == 2:
            out[j] = 2.0 * c[2] + ds * (6.0 * c[3] + ds * 12.0 * c[4])
        else:
            out[j] = 6.0 * c[3] + ds * 24.0 * c[4]


@kernel  # (k, n, 6) f8, (k + 1,) f8, (k,) b1, (3, n) f8, (3,) f8, f8 -> (k + 2, n, 6) f8, (k + 3,) f8, (k + 2,) b1
def with_rest_cells(pieces, borders, curved, limits, shares, most):
    """Pieces, borders and kinds of a path, with a piece of its own for the jerk at both ends.

    Args:
        pieces, borders, curved: the path.
        limits: of velocity, acceleration and jerk.
        shares: of the way with constant jerk that such a piece takes, of a curved piece and of a straight one, at most.
        most: limits are no greater.
    """
    k, n = len(curved), pieces.shape[1]
    found, edges, kinds = np.empty((k + 2, n, 6)), np.empty(k + 3), np.empty(k + 2, np.bool_)
    d, own = np.empty(n), np.empty(3)
    whole = borders[k] - borders[0]
    edges[0], edges[k + 2] = borders[0], borders[k]
    for i in range(1, k):
        edges[i + 1] = borders[i]
    for end in range(2):
        p = 0 if end == 0 else k - 1
        length = borders[p + 1] - borders[p]
        slope(pieces[p], 0.0 if end == 0 else length, 1, d)
        for order in range(3):
            own[order] = most
            for j in range(n):
                if abs(d[j]) > 1e-12:
                    own[order] = min(own[order], limits[order, j] / abs(d[j]))
        ramp = min(own[1] / own[2], np.sqrt(own[0] / own[2]))
        share = shares[0] * min(own[2] * ramp**3 / 6.0, whole / 12.0)
        share = min(share, (shares[1] if curved[p] else shares[2]) * length)
        edges[1 if end == 0 else k + 1] = borders[0] + share if end == 0 else borders[k] - share
    for i in range(k + 2):
        p = min(max(i - 1, 0), k - 1)
        kinds[i] = curved[p]
        for j in range(n):
            delayed(pieces[p, j], edges[i] - borders[p], found[i, j])
    return found, edges, kinds


@kernel  # (k, n, 6) f8, (k + 1,) f8, (3, n) f8, i8, f8 -> (m,) f8, (m,) f8, (m,) i8
def sampled_speeds(pieces, borders, limits, count, least):
    """Parameters, estimates of the square of the speed there, and their piece: `count` on each piece of the path.

    The estimate keeps velocity, and about half of acceleration and jerk for the turn of the path; along the path it
    speeds up with the other half. It is only used to place the grid.
    """
    n, k = pieces.shape[1], pieces.shape[0]
    places, squares, owners = np.empty(k * count + 1), np.empty(k * count + 1), np.empty(k * count + 1, np.int64)
    gains, d = np.empty(k * count + 1), np.empty(n)
    for i in range(k * count + 1):
        owner = min(i // count, k - 1)
        share = (i - owner * count) / count
        # Near rests samples are denser towards the rest.
        if owner == 1 and k == 3:
            share = 2.0 * share**2 if share < 0.5 else 1.0 - 2.0 * (1.0 - share) ** 2
        elif owner <= 1:
            share = share * share
        elif owner >= k - 2:
            share = 1.0 - (1.0 - share) ** 2
        length = borders[owner + 1] - borders[owner]
        places[i], owners[i] = borders[owner] + share * length, owner
        x, gain, sharp = HUGE, HUGE, HUGE
        for order in range(1, 4):
            slope(pieces[owner], share * length, order, d)
            for j in range(n):
                size = abs(d[j])
                if size > 1e-12:
                    if order == 1:
                        x = min(x, (limits[0, j] / size) ** 2)
                        gain = min(gain, limits[1, j] / size)
                        sharp = min(sharp, limits[2, j] / size)
                    elif order == 2:
                        x = min(x, 0.6 * limits[1, j] / size)
                    else:
                        x = min(x, (0.6 * limits[2, j] / size) ** (2.0 / 3.0))
        away = min(places[i] - borders[0], borders[k] - places[i])
        squares[i] = max(min(x, REST * sharp ** (2.0 / 3.0) * away ** (4.0 / 3.0)), least)
        gains[i] = 2.0 * gain
    for i in range(1, len(places)):
        squares[i] = min(squares[i], squares[i - 1] + gains[i] * (places[i] - places[i - 1]))
    for i in range(len(places) - 2, -1, -1):
        squares[i] = min(squares[i], squares[i + 1] + gains[i] * (places[i + 1] - places[i]))
    return places, squares, owners


@kernel  # (m,) f8 x 2, (k,) b1, f8, i8 -> (N + 1,) f8, (N,) i8
def grid_of(places, squares, curved, step, most):
    """A grid from the first to the last place, and the piece of each cell: cells take about `step` [s] at these speeds.

    The first and the last piece, where jerk is constant, are one cell. A blend has `LEAST` cells or more, a straight piece
    two or more.
    """
    m, k = len(places), len(curved)
    times = np.zeros(m)
    for i in range(1, m):
        times[i] = times[i - 1] + 2.0 * (places[i] - places[i - 1]) / (
            np.sqrt(squares[i]) + np.sqrt(squares[i - 1])
        )
    count = (m - 1) // k
    step = max(step, times[m - 1] / most)
    cells = np.empty(k, np.int64)
    total = 0
    for p in range(k):
        own = int(np.ceil((times[(p + 1) * count] - times[p * count]) / step))
        least = LEAST if curved[p] else 2
        if k == 3:
            least = 12
        cells[p] = 1 if p == 0 or p == k - 1 else max(own, least)
        total += cells[p]
    grid, owner = np.empty(total + 1), np.empty(total, np.int64)
    at = 0
    for p in range(k):
        low, high, i = times[p * count], times[(p + 1) * count], p * count
        for c in range(cells[p]):
            wanted = low + (high - low) * c / cells[p]
            while i < (p + 1) * count - 1 and times[i + 1] <= wanted:
                i += 1
            share = (wanted - times[i]) / (times[i + 1] - times[i])
            # With constant acceleration between two samples.
            a, b = np.sqrt(squares[i]), np.sqrt(squares[i + 1])
            share = share * (2.0 * a + share * (b - a)) / (a + b)
            grid[at] = places[i] + share * (places[i + 1] - places[i]) if c else places[p * count]
            owner[at] = p
            at += 1
    grid[at] = places[m - 1]
    return grid, owner
