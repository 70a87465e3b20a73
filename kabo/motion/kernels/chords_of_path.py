"""Way points on a path with rounded corners: few on blends, none between them on straight pieces."""

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.blends import apart, interval, sort_unique, united


@kernel  # (n, 6) f8, f8 -> f8
def curvature(piece, t):
    """The norm of the second derivative of a piece of a path."""
    square = 0.0
    for j in range(piece.shape[0]):
        c = piece[j]
        bend = 2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]))
        square += bend * bend
    return np.sqrt(square)


@kernel  # (m,) f8, (k + 1,) f8, (k,) b1, f8 -> (w,) f8
def needed_stops(places, borders, curved, least):
    """Parameters at which the path has way points in any case: corners, and the ends of runs of curved pieces."""
    m, last = len(places), len(borders) - 1
    cuts, found = np.empty(m + last + 1), np.empty(2 * m + last)
    cut_count, count = united(places, borders, cuts), m
    for i in range(m):
        found[i] = places[i]
    piece, was, before = 0, False, -1.0
    for c in range(cut_count - 1):
        if cuts[c + 1] - cuts[c] <= least:
            continue
        piece = interval(borders, 0.5 * (cuts[c] + cuts[c + 1]), piece)
        if before >= 0.0 and curved[piece] != was:
            found[count] = before
            count += 1
        was, before = curved[piece], cuts[c + 1]
    return apart(found, sort_unique(found, count), least)


@kernel  # (k,) f8, i8 -> (c,) f8
def resized(found, size):
    """An array of another size, with the same numbers at its beginning."""
    kept = np.empty(size)
    for i in range(min(size, len(found))):
        kept[i] = found[i]
    return kept


@kernel  # (m,) f8, (k + 1,) f8, (k, n, 6) f8, (k,) b1, f8, i8, f8 -> (w,) f8, (m,) i8
def way_points_on(places, borders, pieces, curved, chord, samples, least):
    """Parameters of the way points, between which chords on blends are off by `chord` at most, and those of corners."""
    stops = needed_stops(places, borders, curved, least)
    s, total = np.empty(samples), np.zeros(samples)
    found, size = np.empty(8 * len(stops)), 0
    first = 0
    for i in range(len(stops)):
        found[size] = stops[i]
        size += 1
        if i == len(stops) - 1:
            break
        low, high = stops[i], stops[i + 1]
        first = interval(borders, low, first)
        if not curved[interval(borders, 0.5 * (low + high), first)]:
            continue
        piece, before = first, 0.0
        for k in range(samples):
            s[k] = high if k == samples - 1 else low + k * ((high - low) / (samples - 1))
            piece = interval(borders, s[k], piece)
            density = np.sqrt(curvature(pieces[piece], s[k] - borders[piece]) / (8.0 * chord))
            if k > 0:
                total[k] = total[k - 1] + 0.5 * (density + before) * (s[k] - s[k - 1])
            before = density
        count, at = int(np.ceil(total[samples - 1])), 0
        if size + count + len(stops) > len(found):
            found = resized(found, 2 * (size + count + len(stops)))
        for k in range(1, count):
            wanted = k / count * total[samples - 1]
            while at < samples - 2 and total[at + 1] <= wanted:
                at += 1
            found[size] = (s[at + 1] - s[at]) / (total[at + 1] - total[at]) * (wanted - total[at]) + s[at]
            size += 1
    corners, at = np.empty(len(places), np.int64), 0
    for i in range(len(places)):
        while at < size - 1 and abs(found[at + 1] - places[i]) < abs(found[at] - places[i]):
            at += 1
        corners[i] = at
    return resized(found, size), corners
