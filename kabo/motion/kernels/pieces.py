"""From a time law to polynomial pieces in time: knots at whole microseconds, quintic pieces between them, few of them."""

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.grids import slope

# Nodes and weights of Gauss and Legendre's rule of eight points on [-1, 1], for the time that a cell takes.
GAUSS = (0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363)
WEIGHTS = (0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763)
SAMPLES = 4  # on a piece, where its limits are compared before it replaces others


@kernel  # f8 x 7, (6,) f8 -> none
def hermite(q0, v0, a0, q1, v1, a1, span, out):
    """Writes the quintic polynomial with position, velocity and acceleration at both ends of a span of time."""
    d = q1 - q0
    out[0], out[1], out[2] = q0, v0, 0.5 * a0
    out[3] = (20.0 * d - (8.0 * v1 + 12.0 * v0) * span - (3.0 * a0 - a1) * span**2) / (2.0 * span**3)
    out[4] = (-30.0 * d + (14.0 * v1 + 16.0 * v0) * span + (3.0 * a0 - 2.0 * a1) * span**2) / (2.0 * span**4)
    out[5] = (12.0 * d - 6.0 * (v1 + v0) * span - (a0 - a1) * span**2) / (2.0 * span**5)


@kernel  # (6,) f8, f8 -> f8 x 3
def motion_at(c, t):
    """Position, velocity and acceleration of a polynomial."""
    q = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
    v = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])))
    a = 2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]))
    return q, v, a


@kernel  # (N + 1,) f8, (N + 1,) f8 x 2, (N,) f8 -> (N + 1,) f8, (N, 6) f8
def in_time(grid, x, g, w):
    """The times at the grid [s] from 0 on, and the parameter as a quintic polynomial in time for each cell."""
    cells = len(w)
    times, pieces = np.zeros(cells + 1), np.empty((cells, 6))
    for i in range(cells):
        h = grid[i + 1] - grid[i]
        if i == 0:
            span = 3.0 * h / np.sqrt(x[1])
        elif i == cells - 1:
            span = 3.0 * h / np.sqrt(x[i])
        else:
            span, least = 0.0, 1e-4 * max(x[i], x[i + 1])
            for k in range(4):
                for side in (-1.0, 1.0):
                    s = 0.5 * h * (1.0 + side * GAUSS[k])
                    span += 0.5 * h * WEIGHTS[k] / np.sqrt(max(x[i] + s * g[i] + 0.5 * s * s * w[i], least))
        times[i + 1] = times[i] + span
        ends = 0.0 if i == 0 else x[i], 0.0 if i == cells - 1 else x[i + 1]
        gains = 0.0 if i == 0 else g[i], 0.0 if i == cells - 1 else g[i + 1]
        hermite(
            grid[i],
            np.sqrt(ends[0]),
            0.5 * gains[0],
            grid[i + 1],
            np.sqrt(ends[1]),
            0.5 * gains[1],
            span,
            pieces[i],
        )
    return times, pieces


@kernel  # (N + 1,) f8, (N, 6) f8, (m,) f8 -> (m,) f8
def times_at(times, law, places):
    """The times at which a motion, a polynomial for each cell, reaches increasing parameters `places`."""
    found = np.empty(len(places))
    i = 0
    for k in range(len(places)):
        while i < len(law) - 1 and law[i + 1, 0] <= places[k]:
            i += 1
        low, high = 0.0, times[i + 1] - times[i]
        for _ in range(50):
            middle = 0.5 * (low + high)
            if motion_at(law[i], middle)[0] < places[k]:
                low = middle
            else:
                high = middle
        found[k] = times[i] + 0.5 * (low + high)
    return found


@kernel  # (N + 1,) f8, (N,) i8, (k,) b1, f8, i8 -> (m,) i8, (m,) b1
def knots_of(times, owner, curved, factor, gap):
    """Knots [whole microseconds] near the nodes of the grid, slower by `factor`, and whether pieces must end there.

    They must where a blend begins or ends: there the knot is on the straight piece, if this takes longer than a few
    gaps of time.
    """
    cells = len(owner)
    knots, kept = np.empty(cells + 1, np.int64), np.zeros(cells + 1, np.bool_)
    knots[0], kept[0] = 0, True
    total = int(np.round(times[cells] * factor * 1e6))
    count = 1
    for i in range(1, cells):
        exact = times[i] * factor * 1e6
        before, after = curved[owner[i - 1]], curved[owner[i]]
        if before == after:
            at, must = int(np.round(exact)), False
        elif after:
            at, must = int(np.floor(exact - 1e-6)), True
        else:
            at, must = int(np.ceil(exact + 1e-6)), True
        if must and at - knots[count - 1] < gap and not kept[count - 1]:
            count -= 1  # the knot before gives way
        if at - knots[count - 1] < gap or total - at < gap:
            if must and after:
                kept[count - 1] = kept[count - 1] and count == 1  # too short for a straight piece of its own
            continue
        knots[count], kept[count] = at, must
        count += 1
    knots[count], kept[count] = total, True
    return knots[: count + 1], kept[: count + 1]


@kernel  # (m,) i8, (N + 1,) f8, (N, 6) f8, (N,) i8, (k, n, 6) f8, (k + 1,) f8, f8 -> (m, 3, n) f8
def states_at(knots, times, law, owner, pieces, borders, factor):
    """Position, velocity and acceleration of all joints at the knots."""
    n = pieces.shape[1]
    states, d = np.empty((len(knots), 3, n)), np.empty((3, n))
    i = 0
    for k in range(len(knots)):
        t = min(knots[k] * 1e-6 / factor, times[len(owner)])
        while i < len(owner) - 1 and times[i + 1] <= t:
            i += 1
        s, v, a = motion_at(law[i], t - times[i])
        if k == 0 or k == len(knots) - 1:
            s, v, a = borders[0] if k == 0 else borders[len(borders) - 1], 0.0, 0.0
        v, a = v / factor, a / factor**2
        for order in range(3):
            slope(pieces[owner[i]], s - borders[owner[i]], order, d[order])
        for j in range(n):
            states[k, 0, j] = d[0, j]
            states[k, 1, j] = d[1, j] * v
            states[k, 2, j] = d[2, j] * v * v + d[1, j] * a
    return states


@kernel  # (4, 5) f8, i8, i8, i8 -> none
def halve(controls, source, target, degree):
    """Replaces Bernstein coefficients by those of the first half, and writes those of the second [de Casteljau]."""
    for k in range(degree + 1):
        controls[target, k] = controls[source, k]
    for level in range(1, degree + 1):
        for k in range(degree, level - 1, -1):
            controls[source, k] = 0.5 * (controls[source, k] + controls[source, k - 1])
    # Row `source` now has the first half; the second one comes from the other side.
    for level in range(1, degree + 1):
        for k in range(degree + 1 - level):
            controls[target, k] = 0.5 * (controls[target, k] + controls[target, k + 1])


@kernel  # (n, 6) f8, f8, (3, n) f8, (4, 5) f8, (3,) f8 -> none
def piece_shares(piece, span, limits, controls, found):
    """Raises the shares of the limits in `found` to what a piece reaches, by Bernstein coefficients on its quarters."""
    for j in range(piece.shape[0]):
        c = piece[j]
        for order in range(1, 4):
            if limits[order - 1, j] <= 0.0:
                continue
            if order == 1:
                t = span
                b0, b1, b2, b3, b4 = c[1], 2.0 * c[2] * t, 3.0 * c[3] * t * t, 4.0 * c[4] * t**3, 5.0 * c[5] * t**4
                controls[0, 0] = b0
                controls[0, 1] = b0 + b1 / 4.0
                controls[0, 2] = b0 + b1 / 2.0 + b2 / 6.0
                controls[0, 3] = b0 + 3.0 * b1 / 4.0 + b2 / 2.0 + b3 / 4.0
                controls[0, 4] = b0 + b1 + b2 + b3 + b4
                degree = 4
            elif order == 2:
                b0, b1, b2, b3 = 2.0 * c[2], 6.0 * c[3] * span, 12.0 * c[4] * span**2, 20.0 * c[5] * span**3
                controls[0, 0] = b0
                controls[0, 1] = b0 + b1 / 3.0
                controls[0, 2] = b0 + 2.0 * b1 / 3.0 + b2 / 3.0
                controls[0, 3] = b0 + b1 + b2 + b3
                degree = 3
            else:
                b0, b1, b2 = 6.0 * c[3], 24.0 * c[4] * span, 60.0 * c[5] * span**2
                controls[0, 0] = b0
                controls[0, 1] = b0 + b1 / 2.0
                controls[0, 2] = b0 + b1 + b2
                degree = 2
            halve(controls, 0, 2, degree)
            halve(controls, 0, 1, degree)
            halve(controls, 2, 3, degree)
            most = 0.0
            for part in range(4):
                for k in range(degree + 1):
                    most = max(most, abs(controls[part, k]))
            found[order - 1] = max(found[order - 1], most / limits[order - 1, j])


@kernel  # (m,) i8, (m, 3, n) f8, i8, i8, (3, n) f8, f8, (n, 6) f8, (4, 5) f8, (3,) f8 -> b1
def fits(knots, states, low, high, limits, tolerance, out, controls, shares):
    """Writes the quintic pieces from one knot to another, and returns whether they may replace those between.

    They keep the limits, and pass the states between by `tolerance` at most.
    """
    n, span = states.shape[2], (knots[high] - knots[low]) * 1e-6
    for j in range(n):
        hermite(
            states[low, 0, j], states[low, 1, j], states[low, 2, j],
            states[high, 0, j], states[high, 1, j], states[high, 2, j], span, out[j],
        )  # fmt: skip
    for j in range(n):  # most pieces that do not fit are found by a few samples
        c = out[j]
        for k in range(1, SAMPLES):
            t = span * k / SAMPLES
            _, v, a = motion_at(c, t)
            jerk = 6.0 * c[3] + t * (24.0 * c[4] + t * 60.0 * c[5])
            if abs(v) > limits[0, j] or abs(a) > limits[1, j] or abs(jerk) > limits[2, j]:
                return False
        for k in range(low + 1, high):
            if abs(motion_at(c, (knots[k] - knots[low]) * 1e-6)[0] - states[k, 0, j]) > tolerance:
                return False
    shares[:] = 0.0
    piece_shares(out, span, limits, controls, shares)
    return max(shares[0], shares[1], shares[2]) <= 1.0


@kernel  # (m,) i8, (m,) b1, (m, 3, n) f8, (3, n) f8, f8, i8 -> (p + 1,) i8, (p, n, 6) f8
def few_pieces(knots, kept, states, limits, tolerance, longest):
    """Ends of pieces [whole microseconds] and their coefficients: from each knot the longest piece that fits."""
    n, m = states.shape[2], len(knots)
    ends, found = np.empty(m, np.int64), np.empty((m - 1, n, 6))
    tried, controls, shares = np.empty((n, 6)), np.empty((4, 5)), np.empty(3)
    ends[0] = knots[0]
    count, low = 0, 0
    while low < m - 1:
        high = low + 1
        fits(knots, states, low, high, limits, tolerance, found[count], controls, shares)
        further = high
        while not kept[further] and further + 1 < m and knots[further + 1] - knots[low] <= longest:
            further += 1
            if fits(knots, states, low, further, limits, tolerance, tried, controls, shares):
                high = further
                found[count] = tried
            elif further > high + 2:
                break
        low = high
        count += 1
        ends[count] = knots[low]
    return ends[: count + 1], found[:count]


@kernel  # (p + 1,) i8, (p, n, 6) f8, (3, n) f8 -> (3,) f8
def used_shares(ends, pieces, limits):
    """Bounds of the shares of the limits of velocity, acceleration and jerk that pieces reach."""
    found, controls = np.zeros(3), np.empty((4, 5))
    for p in range(len(pieces)):
        piece_shares(pieces[p], (ends[p + 1] - ends[p]) * 1e-6, limits, controls, found)
    return found
