"""Smooth paths through way points of a curve: where way points sample a curve, the path between them is a cubic spline.

A straight line of the tool is a curve in joint space. Chords between its way points are off by κ h² / 8 (κ: curvature, h:
distance of way points) and turn by κ h at each of them, so that a motion along chords has to slow down there. The spline
passes the same way points, is off by the order of h⁴, and its curvature is continuous. It is straight at its ends (its
curvature is 0 there), so that straight pieces and blends may follow. [de Boor, A Practical Guide to Splines, IV]
"""

import numpy as np

from kabo.arrays import Array
from kabo.motion.kernels.splines import solved_rows

GRADING = 0.7  # share by which knots are closer together at the ends than in the middle: 0 evenly, 1 as cosines


def smooth_knots(waypoints: Array, count: int) -> Array:
    """Knots (count + 1, n) on the smoothest cubic through three or more way points (m, n), closer together at its ends.

    The ends are exactly those given.
    """
    places = _places(waypoints)
    slopes = _free_slopes(waypoints, places)
    shares = np.arange(count + 1) / count
    wanted = places[-1] * ((1.0 - GRADING) * shares + GRADING * (1.0 - np.cos(np.pi * shares)) / 2.0)
    k = np.clip(np.searchsorted(places, wanted, side="right") - 1, 0, len(places) - 2)
    length = (places[k + 1] - places[k])[:, None]
    t = (wanted - places[k])[:, None] / length
    found = (
        (1 + 2 * t) * (1 - t) ** 2 * waypoints[k]
        + t**2 * (3 - 2 * t) * waypoints[k + 1]
        + length * (t * (1 - t) ** 2 * slopes[k] - t**2 * (1 - t) * slopes[k + 1])
    )
    found[0], found[-1] = waypoints[0], waypoints[-1]
    return np.asarray(found)


def natural_slopes(knots: Array) -> Array:
    """The slopes (m, n) at knots (m, n) of the cubic spline through them without curvature at its ends."""
    places = _places(knots)
    h = np.diff(places)
    chords = np.diff(knots, axis=0) / h[:, None]
    ends = (2.0, 1.0, 3.0 * chords[0]), (2.0, 1.0, 3.0 * chords[-1])
    return _slopes(h, chords, *ends)


def _slopes(h: Array, chords: Array, first: tuple[float, float, Array], last: tuple[float, float, Array]) -> Array:
    """The slopes (m, n) of a spline whose curvature does not jump at inner knots.

    Args:
        h: lengths (m - 1,) of pieces. chords: their mean slopes (m - 1, n).
        first, last: equations of the ends: the coefficients of the end's slope and of its neighbour's, and their sum (n,).
    """
    diagonal = np.concatenate([[first[0]], 2.0 * (h[:-1] + h[1:]), [last[0]]])
    lower = np.concatenate([[0.0], h[1:], [last[1]]])
    upper = np.concatenate([[first[1]], h[:-1], [0.0]])
    inner = 3.0 * (h[1:, None] * chords[:-1] + h[:-1, None] * chords[1:])
    right = np.concatenate([first[2][None], inner, last[2][None]])
    return np.asarray(solved_rows(lower, diagonal, upper, right))


def _free_slopes(points: Array, places: Array) -> Array:
    """The slopes (m, n) of the spline whose two first pieces are one cubic, and the two last ones ("not a knot")."""
    h, m = np.diff(places), len(points)
    chords = np.diff(points, axis=0) / h[:, None]
    if m == 3:  # a parabola
        bend = (chords[1] - chords[0]) / (h[0] + h[1])
        return np.stack([chords[0] - h[0] * bend, chords[0] + h[0] * bend, chords[1] + h[1] * bend])
    first, last = (
        (b, a + b, ((a + 2.0 * (a + b)) * b * chords[c] + a**2 * chords[d]) / (a + b))
        for a, b, c, d in ((h[0], h[1], 0, 1), (h[-1], h[-2], m - 2, m - 3))
    )
    return _slopes(h, chords, first, last)


def _places(points: Array) -> Array:
    """The lengths of chords up to each point (m,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
