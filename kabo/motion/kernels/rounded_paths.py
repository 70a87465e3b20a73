"""A path with rounded corners in one call: trims, pieces, way points, and how far these are from the path."""

import numpy as np

from kabo.compilation import kernel
from kabo.motion.kernels.blends import fit_trims, rounded_pieces, unrounded
from kabo.motion.kernels.chords_of_path import way_points_on
from kabo.motion.kernels.deviations import distances_of_path, positions_at


@kernel  # (m, n) f8, f8, f8 -> (m, n) f8, b1, (m,) b1
def usable_corners(rows, same, reversal):
    """Corners as plans keep them, whether all differ from the one before, and where the path turns back on itself."""
    m, n = rows.shape
    points, back, different = np.empty((m, n)), np.zeros(m, np.bool_), True
    lengths = np.empty(m)
    for i in range(m):
        square = 0.0
        for j in range(n):
            points[i, j] = rounded_value(rows[i, j])
            if i > 0:
                square += (points[i, j] - points[i - 1, j]) ** 2
        lengths[i] = np.sqrt(square)
        different = different and (i == 0 or lengths[i] > same)
    for i in range(1, m - 1):
        if different:
            square = 0.0
            for j in range(n):
                before = (points[i, j] - points[i - 1, j]) / lengths[i]
                square += ((points[i + 1, j] - points[i, j]) / lengths[i + 1] - before) ** 2
            back[i] = np.sqrt(square) > reversal
    return points, different, back


@kernel  # f8 -> f8
def rounded_value(value):
    """A joint value as plans keep it, with nine decimals, and no negative zero."""
    return np.rint(value * 1e9) / 1e9 + 0.0


@kernel  # (m,) f8, (m,) b1, i8 -> f8
def room(places, rests, i):
    """The distance of a corner from the nearest one where the path stops."""
    before, after = i - 1, i + 1
    while not rests[before]:
        before -= 1
    while not rests[after]:
        after += 1
    return min(places[i] - places[before], places[after] - places[i])


@kernel  # (m,) f8, (m - 2, n) f8, (m,) f8, b1, (4,) f8 -> (m,) f8
def greatest_trims(places, turns, shares, straight, limits):
    """The trims with which blends have shares of their greatest size, before the whole path is seen.

    `limits`: the greatest deviation, the share of trim and turn by which a blend passes by its corner, the least turn that
    counts, the least length of a piece.
    """
    m, n = len(places), turns.shape[1]
    trims, rests, bends = np.zeros(m), np.ones(m, np.bool_), np.zeros(m)
    for i in range(1, m - 1):
        square = 0.0
        for j in range(n):
            square += turns[i - 1, j] ** 2
        bends[i] = np.sqrt(square)
        rests[i] = shares[i] <= 0.0 and (straight or bends[i] > 0.0)
    for i in range(1, m - 1):
        if straight or bends[i] != 0.0:
            most = limits[0] / limits[1] / max(bends[i], limits[2])
            trims[i] = min(room(places, rests, i), most) * shares[i]
    return trims


@kernel  # (m, n) f8, (m - 1, 2, n) f8, b1, (m,) f8, f8, i8, (4,) f8, (2,) f8 -> arrays of a path
def rounded_path_of(corners, slopes, straight, shares, chord, samples, limits, shrinking):
    """Trims, borders, pieces, passed parameters, indices of corners, way points and deviations.

    `limits` as of `greatest_trims`.
    """
    places, turns, bases = unrounded(corners, slopes, straight)
    trims = greatest_trims(places, turns, shares, straight, limits)
    fit_trims(places, bases, turns, trims, limits[0], limits[3], shrinking)
    borders, pieces, curved = rounded_pieces(places, bases, turns, trims, limits[3])
    passing, indices = way_points_on(places, borders, pieces, curved, chord, samples, limits[3])
    waypoints = positions_at(borders, pieces, passing)
    for i in range(waypoints.shape[0]):
        for j in range(waypoints.shape[1]):
            waypoints[i, j] = rounded_value(waypoints[i, j])
    deviations = distances_of_path(borders, pieces, waypoints, passing)
    return trims, borders, pieces, passing, indices, waypoints, deviations
