"""How far polynomial motions are from the straight pieces of their path, by Bernstein coefficients on quarters of time."""

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.grids import delayed
from kabo.motion.kernels.pieces import halve

BINOMIALS = (1.0, 5.0, 10.0, 10.0, 5.0, 1.0)


@kernel  # (6,) f8, f8, (4, 6) f8 -> f8 x 2
def range_of(c, span, controls):
    """A lower and an upper bound of a polynomial on local times from 0 to `span`."""
    power = 1.0
    for k in range(6):
        controls[0, k] = c[k] * power / BINOMIALS[k]
        power *= span
    for level in range(4, -1, -1):  # Bernstein coefficients have these as their differences
        for i in range(level, 5):
            controls[0, i + 1] += controls[0, i]
    halve(controls, 0, 2, 5)
    halve(controls, 0, 1, 5)
    halve(controls, 2, 3, 5)
    low, high = controls[0, 0], controls[0, 0]
    for part in range(4):
        for k in range(6):
            low, high = min(low, controls[part, k]), max(high, controls[part, k])
    return low, high


@kernel  # (n, 6) f8, (n,) f8, f8, (2, 6) f8, (4, 6) f8, (n,) f8 -> none
def raise_distances(part, step, span, rows, controls, found):
    """Raises `found` to what joints may be from a straight piece by `step`, during a motion relative to its beginning."""
    share, rest, square = rows[0], rows[1], 0.0
    share[:] = 0.0
    for j in range(len(step)):
        square += step[j] * step[j]
        for k in range(6):
            share[k] += part[j, k] * step[j]
    excess = 0.0
    if square > 0.0:
        for k in range(6):
            share[k] /= square
        low, high = range_of(share, span, controls)
        excess = max(0.0, -low, high - 1.0)
    for j in range(len(step)):
        for k in range(6):
            rest[k] = part[j, k] - step[j] * share[k]
        low, high = range_of(rest, span, controls)
        found[j] = max(found[j], max(-low, high) + excess * abs(step[j]))


@kernel  # (p, n, 6) f8, (p, n) f8, (p,) f8 -> (p, n) f8
def distances_of_parts(parts, steps, spans):
    """How far joints may be from the straight piece of each part of a motion."""
    found, rows, controls = np.zeros(steps.shape), np.empty((2, 6)), np.empty((4, 6))
    for p in range(len(parts)):
        raise_distances(parts[p], steps[p], spans[p], rows, controls, found[p])
    return found


@kernel  # (k + 1,) f8, (k, n, 6) f8, (m, n) f8, (m,) f8 -> (m - 1, n) f8
def distances_of_path(times, padded, waypoints, passing):
    """How far joints may be from each piece of the path while the motion follows it."""
    m, n = waypoints.shape
    found, rows, controls = np.zeros((m - 1, n)), np.empty((2, 6)), np.empty((4, 6))
    part, step = np.empty((n, 6)), np.empty(n)
    piece, own, low, last = 0, 0, times[0], len(times) - 1
    while low < times[last]:
        while piece < last - 1 and times[piece + 1] <= low:
            piece += 1
        while own < m - 2 and passing[own + 1] <= low:
            own += 1
        high = times[piece + 1]
        if passing[own + 1] > low:
            high = min(high, passing[own + 1])
        delay = low - times[piece]
        for j in range(n):
            step[j] = waypoints[own + 1, j] - waypoints[own, j]
            delayed(padded[piece, j], delay, part[j])
            part[j, 0] -= waypoints[own, j]
        raise_distances(part, step, high - low, rows, controls, found[own])
        low = high
    return found


@kernel  # (k + 1,) f8, (k, n, 6) f8, (n,) f8 x 2 -> (k,) b1
def pieces_beyond(times, padded, lower, upper):
    """Whether each piece of a motion may leave its bounds."""
    found, controls = np.zeros(len(padded), np.bool_), np.empty((4, 6))
    for k in range(len(padded)):
        for j in range(padded.shape[1]):
            low, high = range_of(padded[k, j], times[k + 1] - times[k], controls)
            found[k] = found[k] or low < lower[j] or high > upper[j]
    return found


@kernel  # (k + 1,) f8, (k, n, 6) f8, (m,) f8 -> (m, n) f8
def positions_at(times, padded, moments):
    """The positions at some moments of a motion; those at or after a border belong to the piece that begins there."""
    n, piece = padded.shape[1], 0
    found = np.empty((len(moments), n))
    for i in range(len(moments)):
        while piece < len(padded) - 1 and times[piece + 1] <= moments[i]:
            piece += 1
        while piece > 0 and times[piece] > moments[i]:
            piece -= 1
        t = moments[i] - times[piece]
        for j in range(n):
            value = 0.0
            for power in range(5, -1, -1):
                value = value * t + padded[piece, j, power]
            found[i, j] = value
    return found
