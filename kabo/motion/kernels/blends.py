"""Paths with rounded corners as pieces of polynomials, and the trims with which they stay near their straight pieces.

`blending.py` says what they are. A path of m corners has m - 1 pieces between them, `bases`; its `borders` are where
blends begin and end.
"""

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.deviations import BINOMIALS
from kabo.motion.kernels.grids import delayed


@kernel  # (m, n) f8, (m - 1, 2, n) f8, b1 -> (m,) f8, (m - 2, n) f8, (m - 1, n, 6) f8
def unrounded(corners, slopes, straight):
    """The places of corners, turns at them, and the pieces between them: all straight, or with slopes at their ends."""
    m, n = corners.shape
    places, turns, bases = np.zeros(m), np.empty((m - 2, n)), np.zeros((m - 1, n, 6))
    found = np.empty((m - 1, 2, n))
    for i in range(m - 1):
        square = 0.0
        for j in range(n):
            square += (corners[i + 1, j] - corners[i, j]) ** 2
        length = np.sqrt(square)
        places[i + 1] = places[i] + length
        bent = False
        for j in range(n):
            unit = (corners[i + 1, j] - corners[i, j]) / length
            for e in range(2):
                found[i, e, j] = unit if straight else slopes[i, e, j]
            bent = bent or found[i, 0, j] != unit or found[i, 1, j] != unit
        for j in range(n):
            first, last = found[i, 0, j], found[i, 1, j]
            bases[i, j, 0], bases[i, j, 1] = corners[i, j], first
            if bent:
                unit = (corners[i + 1, j] - corners[i, j]) / length
                bases[i, j, 2] = (3.0 * unit - 2.0 * first - last) / length
                bases[i, j, 3] = (first + last - 2.0 * unit) / (length * length)
    for i in range(m - 2):
        for j in range(n):
            turns[i, j] = found[i + 1, 0, j] - found[i, 1, j]
    return places, turns, bases


@kernel  # (k,) f8, i8 -> i8
def sort_unique(found, count):
    """Sorts the first `count` numbers and drops what occurs again; returns how many there are."""
    for i in range(1, count):
        value, at = found[i], i
        while at > 0 and found[at - 1] > value:
            found[at] = found[at - 1]
            at -= 1
        found[at] = value
    kept = 1
    for i in range(1, count):
        if found[i] != found[kept - 1]:
            found[kept] = found[i]
            kept += 1
    return kept


@kernel  # (k,) f8, f8, i8 -> i8
def interval(knots, place, low):
    """The index of the interval between knots that contains a place, from `low` on; the last one beyond the end."""
    while low < len(knots) - 2 and knots[low + 1] <= place:
        low += 1
    return low


@kernel  # (n, 6) f8 -> b1
def is_bent(piece):
    """Whether a piece is more than a straight line."""
    for j in range(piece.shape[0]):
        for k in range(2, 6):
            if piece[j, k] != 0.0:
                return True
    return False


@kernel  # (a,) f8, (b,) f8, (a + b,) f8 -> i8
def united(first, second, out):
    """Writes the numbers of both, sorted, each once; returns how many there are."""
    for i in range(len(first)):
        out[i] = first[i]
    for i in range(len(second)):
        out[len(first) + i] = second[i]
    return sort_unique(out, len(first) + len(second))


@kernel  # (k,) f8, i8, f8 -> (c,) f8
def apart(found, count, least):
    """Those of the first `count` increasing numbers that are greater by `least` than the one before."""
    size = 1
    for i in range(1, count):
        size += found[i] - found[i - 1] > least
    kept, at = np.empty(size), 1
    kept[0] = found[0]
    for i in range(1, count):
        if found[i] - found[i - 1] > least:
            kept[at] = found[i]
            at += 1
    return kept


@kernel  # (m,) f8, (m - 1, n, 6) f8, (m,) f8, f8 -> (k + 1,) f8
def borders_of(places, bases, trims, least):
    """Where blends and curves begin and end, and the ends of the path; none closer to the one before than `least`."""
    m, count = len(places), 2
    found = np.empty(3 * m)
    found[0], found[1] = 0.0, places[m - 1]
    was = False
    for i in range(m - 1):
        bent = is_bent(bases[i])
        if i > 0:
            for side in (-1.0, 1.0):
                found[count] = min(max(places[i] + side * trims[i], 0.0), places[m - 1])
                count += 1
            if bent or was:
                found[count] = places[i]
                count += 1
        was = bent
    kept = apart(found, sort_unique(found, count), least)  # what rounding leaves of a piece is none
    kept[len(kept) - 1] = places[m - 1]
    return kept


@kernel  # (m,) f8, (m - 1, n, 6) f8, (m - 2, n) f8, (m,) f8, f8 -> (k + 1,) f8, (k, n, 6) f8, (k,) b1
def rounded_pieces(places, bases, turns, trims, least):
    """Borders, the pieces between them in powers of the parameter from the beginning of each, and which are curved."""
    borders = borders_of(places, bases, trims, least)
    count, n, m = len(borders) - 1, bases.shape[1], len(places)
    found, curved, bend = np.empty((count, n, 6)), np.empty(count, np.bool_), np.empty(6)
    last = 0
    for p in range(count):
        begin, middle = borders[p], 0.5 * (borders[p] + borders[p + 1])
        last = interval(places, begin + least, last)
        for j in range(n):
            delayed(bases[last, j], begin - places[last], found[p, j])
        for i in range(1, m - 1):
            a, since = trims[i], begin - places[i]
            if not places[i] - a <= middle < places[i] + a:
                continue
            t, passed = (since + a) / (2.0 * a), i <= last
            bend[0] = 2.0 * a * (t**3 - 0.5 * t**4) - (since if passed else 0.0)
            bend[1] = 3.0 * t**2 - 2.0 * t**3 - (1.0 if passed else 0.0)
            bend[2] = 3.0 * (t - t**2) / (2.0 * a)
            bend[3] = (1.0 - 2.0 * t) / (4.0 * a**2)
            bend[4] = -1.0 / (16.0 * a**3)
            for j in range(n):
                for k in range(5):
                    found[p, j, k] += bend[k] * turns[i - 1, j]
        curved[p] = is_bent(found[p])
    for j in range(n):
        found[0, j, 0] = bases[0, j, 0]  # what blends that reach to the start leave there by rounding
    return borders, found, curved


@kernel  # (m,) f8, (m - 1, n, 6) f8, (k + 1,) f8, (k, n, 6) f8 -> (c + 1,) f8, (c,) f8
def away_from_bases(places, bases, borders, pieces):
    """Parameters, and bounds of the distance from the pieces without rounding between each of them and the next.

    The difference of both is a polynomial between parameters, so within the hull of its Bernstein coefficients.
    """
    m, n = len(places), bases.shape[1]
    cuts = np.empty(m + len(borders))
    count = united(places, borders, cuts)
    away = np.empty(count - 1)
    rounded, base, squares = np.empty(6), np.empty(6), np.empty(6)
    piece, own = 0, 0
    for c in range(count - 1):
        low, span, middle = cuts[c], cuts[c + 1] - cuts[c], 0.5 * (cuts[c] + cuts[c + 1])
        piece, own = interval(borders, middle, piece), interval(places, middle, own)
        for k in range(6):
            squares[k] = 0.0
        for j in range(n):
            delayed(pieces[piece, j], low - borders[piece], rounded)
            delayed(bases[own, j], low - places[own], base)
            power = 1.0
            for k in range(6):
                rounded[k] = (rounded[k] - base[k]) * power / BINOMIALS[k]
                power *= span
            for level in range(4, -1, -1):  # Bernstein coefficients have these as their differences
                for i in range(level, 5):
                    rounded[i + 1] += rounded[i]
            for k in range(6):
                squares[k] += rounded[k] * rounded[k]
        most = 0.0
        for k in range(6):
            most = max(most, squares[k])
        away[c] = np.sqrt(most)
    return cuts[:count], away


@kernel  # (m,) f8, (m - 1, n, 6) f8, (m - 2, n) f8, (m,) f8, f8, f8, (2,) f8 -> none
def fit_trims(places, bases, turns, trims, deviation, least, shrinking):
    """Lowers trims until the path stays near its pieces without rounding; each step by factors between two bounds."""
    worst = np.empty(len(places))
    while True:
        borders, pieces, _ = rounded_pieces(places, bases, turns, trims, least)
        cuts, away = away_from_bases(places, bases, borders, pieces)
        over = False
        for i in range(len(worst)):
            worst[i] = 0.0
        for c in range(len(away)):
            if away[c] > deviation * (1.0 + 1e-9) + 1e-12:  # rounding of a point
                over = True
                for i in range(1, len(places) - 1):
                    if cuts[c] < places[i] + trims[i] and cuts[c + 1] > places[i] - trims[i]:
                        worst[i] = max(worst[i], away[c])
        if not over:
            return
        for i in range(1, len(places) - 1):
            if worst[i] > 0.0:
                share = deviation / max(worst[i], least)
                trims[i] *= min(max(share, shrinking[0]), shrinking[1])
