"""What is to be proven of a motion near its path: straight segments, how far joints may be from them, and whose they are.

A path has pieces between its way points. Those that a motion does not leave need no proof of their own.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.compilation import kernel
from kabo.motion.kernels.deviations import raise_distances
from kabo.motion.kernels.grids import delayed
from kabo.motion.kernels.rounded_paths import rounded_value

REFUSED = 2  # what is asked of a piece that cannot be proven


class Course(NamedTuple):
    """A motion and its path."""

    times: Array  # (k + 1,)
    coefficients: Array  # (k, n, 6)
    waypoints: Array  # (m, n)
    passing: Array  # (m,)
    deviations: Array  # (m - 1, n)
    corners: Integers  # (c,) way points


class Whose(NamedTuple):
    """The straight pieces of a route, and what its parts ask of a motion near them."""

    corners: Array  # (c, n)
    owners: Integers  # (c - 1,) part of each piece
    curved: Booleans  # (p,) whether each part is a curve, which is not proven yet
    touching: Array  # (p,) distance from the part up to which bodies may touch [rad, L2]; negative: nowhere
    rests: Array  # (s, n) where strokes of parts rest
    stroke_owners: Integers  # (s,) their parts
    resting: Array  # (N,) a configuration of the whole robot
    column: int  # of the first joint that moves


@kernel  # Course, f8, (n,) f8 -> none
def place_at(course, moment, out):
    """Writes where a motion is at a moment."""
    last = len(course.times) - 2
    piece = min(max(np.searchsorted(course.times, moment, side="right") - 1, 0), last)
    t = moment - course.times[piece]
    for j in range(len(out)):
        value = 0.0
        for power in range(5, -1, -1):
            value = value * t + course.coefficients[piece, j, power]
        out[j] = value


@kernel  # (n,) f8, Whose, i8 -> f8
def distance_from_part(row, whose, owner):
    """The distance of a place from the straight pieces of a part [rad, L2]."""
    found, n = np.inf, len(row)
    for i in range(len(whose.owners)):
        if whose.owners[i] != owner:
            continue
        along, square = 0.0, 0.0
        for j in range(n):
            step = whose.corners[i + 1, j] - whose.corners[i, j]
            along += (row[j] - whose.corners[i, j]) * step
            square += step * step
        share, away = min(max(along / square, 0.0), 1.0), 0.0
        for j in range(n):
            step = whose.corners[i + 1, j] - whose.corners[i, j]
            away += (row[j] - whose.corners[i, j] - share * step) ** 2
        found = min(found, np.sqrt(away))
    return found


@kernel  # (n,) f8 x 2, f8, Whose, i8, (3,) f8 -> b1
def steady(start, end, away, whose, owner, nearness):
    """Whether a motion is near enough to a piece of a stroke: the nearer to where it rests, the nearer it has to be."""
    for s in range(len(whose.stroke_owners)):
        if whose.stroke_owners[s] != owner:
            continue
        first, second = 0.0, 0.0
        for j in range(len(start)):
            first += (start[j] - whose.rests[s, j]) ** 2
            second += (end[j] - whose.rests[s, j]) ** 2
        nearest = min(np.sqrt(first), np.sqrt(second))
        if not away <= nearness[0] * nearest + (nearness[1] if whose.curved[owner] else nearness[2]):
            return False
    return True


@kernel  # Course, Whose, (k,) i8, f8, f8, (3,) f8 -> (k,) i8, (k,) i8, (k,) i8, (k, N) f8 x 3
def asked_of(course, whose, pieces, margin, on_path, nearness):
    """What is to be proven of some pieces: which of them, their parts, what is asked, and ends and strays of segments.

    What is asked: 0 that all is free, 1 that also bodies are apart that may touch on the part, REFUSED nothing.

    Args:
        course: the motion.
        whose: the route that it follows.
        pieces: of its path.
        margin: the factor of deviations with which segments are to be free; negative: the middles of pieces alone.
        on_path: deviation up to which a motion does not leave its path [rad or m].
        nearness: of strokes: the share of the way from the rest, and what curves and other pieces may be off there.
    """
    n, size, count = course.waypoints.shape[1], len(whose.resting), 0
    chosen, parts, asked = np.empty_like(pieces), np.empty_like(pieces), np.empty_like(pieces)
    rows = np.empty((3, len(pieces), size))
    start, end, last = np.empty(n), np.empty(n), len(whose.owners) - 1
    for piece in pieces:
        owner = whose.owners[min(np.searchsorted(course.corners, piece, side="right") - 1, last)]
        away = 0.0
        for j in range(n):
            away = max(away, course.deviations[piece, j])
        if not (away > on_path or whose.curved[owner]):
            continue
        chosen[count], parts[count], asked[count] = piece, owner, 0
        if margin < 0.0:
            place_at(course, (course.passing[piece] + course.passing[piece + 1]) / 2.0, start)
            end[:] = start
        else:
            start[:] = course.waypoints[piece]
            end[:] = course.waypoints[piece + 1]
            asked[count] = 0 if steady(start, end, away, whose, owner, nearness) else REFUSED
        if asked[count] == 0 and whose.touching[owner] >= 0.0:
            far = max(distance_from_part(start, whose, owner), distance_from_part(end, whose, owner))
            asked[count] = 1 if far > whose.touching[owner] else 0
        for j in range(size):
            rows[0, count, j] = rows[1, count, j] = whose.resting[j]
            rows[2, count, j] = 0.0
        for j in range(n):
            rows[0, count, whose.column + j] = rounded_value(start[j])
            rows[1, count, whose.column + j] = rounded_value(end[j])
            if margin >= 0.0:
                rows[2, count, whose.column + j] = margin * course.deviations[piece, j]
        count += 1
    return chosen[:count], parts[:count], asked[:count], rows[0, :count], rows[1, :count], rows[2, :count]


@kernel  # Course, i8, (m, n) f8, (m,) f8, (m - 1, n) f8 -> none
def write_deviation(course, piece, waypoints, passing, deviations):
    """Writes how far a motion may be from one piece of a path."""
    n, last = waypoints.shape[1], len(course.times) - 1
    part, step, rows, controls = np.empty((n, 6)), np.empty(n), np.empty((2, 6)), np.empty((4, 6))
    deviations[piece] = 0.0
    low, end = passing[piece], passing[piece + 1]
    if piece == len(passing) - 2:
        end = max(end, course.times[last])
    own = min(max(np.searchsorted(course.times, low, side="right") - 1, 0), last - 1)
    for j in range(n):
        step[j] = waypoints[piece + 1, j] - waypoints[piece, j]
    while low < end:
        while own < last - 1 and course.times[own + 1] <= low:
            own += 1
        high = min(course.times[own + 1], end)
        for j in range(n):
            delayed(course.coefficients[own, j], low - course.times[own], part[j])
            part[j, 0] -= waypoints[piece, j]
        raise_distances(part, step, high - low, rows, controls, deviations[piece])
        if high <= low:
            break
        low = high


@kernel  # Course, (k,) i8, f8 -> (m + k, n) f8, (m + k,) f8, (m + k - 1, n) f8, (c,) i8, (2 k,) i8
def with_middles(course, pieces, decimals):
    """The path with a way point in the middle of some pieces, increasing: way points, times, deviations, corners, halves.

    `decimals`: ten to the number of decimals of times.
    """
    m, n, k = len(course.passing), course.waypoints.shape[1], len(pieces)
    waypoints, passing = np.empty((m + k, n)), np.empty(m + k)
    deviations, halves = np.empty((m + k - 1, n)), np.empty(2 * k, np.int64)
    done = 0
    for i in range(m):
        waypoints[i + done] = course.waypoints[i]
        passing[i + done] = course.passing[i]
        if i < m - 1:
            deviations[i + done] = course.deviations[i]
        if done < k and pieces[done] == i:
            halves[2 * done], halves[2 * done + 1] = i + done, i + done + 1
            done += 1
            middle = np.rint((course.passing[i] + course.passing[i + 1]) / 2.0 * decimals) / decimals
            passing[i + done] = middle
            place_at(course, middle, waypoints[i + done])
            for j in range(n):
                waypoints[i + done, j] = rounded_value(waypoints[i + done, j])
    for half in halves:
        write_deviation(course, half, waypoints, passing, deviations)
    corners = np.empty_like(course.corners)
    for c in range(len(corners)):
        corners[c] = course.corners[c] + np.searchsorted(pieces, course.corners[c])
    return waypoints, passing, deviations, corners, halves
