"""Paths with rounded corners: each corner becomes a blend; blends of close corners may overlap, and add up.

Such a path can be followed without stopping [Kunz, Stilman 2012]. A path of straight pieces is its first direction
and the turns d_i at its corners s_i, p(s) = p_0 + s u_0 + sum of d_i max(0, s - s_i). Here every max(0, s - s_i)
is replaced, between s_i - a_i and s_i + a_i, by 2 a_i (τ³ - τ⁴ / 2) with τ = (s - s_i + a_i) / 2 a_i, whose slope is
the smoothstep 3 τ² - 2 τ³: so direction and curvature are continuous. A single corner gives a blend of trim a_i; where
several trims overlap the path is still as smooth, so the blend of a sharp corner between short, gently bending pieces
may extend to the nearest corner where the motion stops.

Way points that lie on a line within a small tolerance are dropped first.

Between corners the path may also be cubic, with given slopes at both ends of a piece (`curving.py` makes them). Turns are
then the differences of slopes; where there is none, and curvature goes on, the path is smooth without a blend.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kabo.arrays import Array
from kabo.motion.bernstein import derivative, values
from kabo.motion.kernels.blends import fit_trims, rounded_pieces, unrounded

MIN_PIECE_LENGTH = 1e-9  # [rad, L2]: shorter pieces are dropped
# Norm of a turn: gentler corners get the trims of this turn, or they would take the room of sharper ones.
GENTLE_TURN = 0.1
# Factors by which trims shrink in one step, where the path is too far from its corners.
MIN_SHRINKING, MAX_SHRINKING = 0.5, 0.98
CORNER_SHARE = 3.0 / 16  # a blend passes by its corner at this share of its trim and the norm of its turn
_NO_SLOPES = np.zeros((0, 2, 0))


@dataclass(frozen=True)
class Blended:
    """A path with rounded `corners` (m, n); `trims` (m,) are the lengths of blends before and after a corner.

    A trim is 0 at both ends of the path and at corners where the path stops. A blend may extend over other
    corners, but not over a corner where the path stops.
    """

    corners: Array
    trims: Array
    slopes: Array | None = None  # (m - 1, 2, n): derivatives where each piece begins and ends; None: straight

    @cached_property
    def _unrounded(self) -> tuple[Array, Array, Array]:
        return _unrounded(self.corners, self.slopes)

    @cached_property
    def _rounded(self) -> tuple[Array, Array, NDArray[np.bool_]]:
        places, turns, bases = self._unrounded
        borders, pieces, curved = rounded_pieces(places, bases, turns, self.trims, MIN_PIECE_LENGTH)
        return borders, pieces, curved

    @property
    def places(self) -> Array:
        """The parameter of each corner (m,): the middle of its blend."""
        return self._unrounded[0]

    @property
    def turns(self) -> Array:
        """The differences (m - 2, n) of the slopes after and before each inner corner; 0 where the path is smooth."""
        return self._unrounded[1]

    @property
    def bases(self) -> Array:
        """The pieces (m - 1, n, 6) between corners without rounding, in powers of the parameter from each corner."""
        return self._unrounded[2]

    @property
    def borders(self) -> Array:
        """The parameters where blends and curves begin and end, both ends of the path, and corners where it stops."""
        return self._rounded[0]

    @property
    def coefficients(self) -> Array:
        """The pieces (k, n, 6) between borders, in powers of the parameter from the beginning of each.

        On straight pieces all but the first two are exactly 0.
        """
        return self._rounded[1]

    @property
    def curved(self) -> NDArray[np.bool_]:
        """Whether each of the k pieces between borders is part of a blend."""
        return self._rounded[2]

    @cached_property
    def stops(self) -> list[int]:
        """The corners at which the path stops: its ends, and those with a turn that is not rounded."""
        rests = self.trims[1:-1] <= 0.0
        if self.slopes is not None:
            rests &= np.any(self.turns != 0.0, axis=1)
        return [0, *(np.flatnonzero(rests) + 1).tolist(), len(self.corners) - 1]

    def between(self, first: int, last: int) -> "Blended":
        """The part from one corner where the path stops to another."""
        slopes = None if self.slopes is None else self.slopes[first:last]
        return Blended(self.corners[first : last + 1], self.trims[first : last + 1], slopes)

    @property
    def length(self) -> float:
        """The greatest parameter: the length of the straight pieces."""
        return float(self.places[-1])

    def corner(self, number: int) -> float:
        """The parameter of one corner: the middle of its blend."""
        return float(self.places[number])

    def at(self, places: ArrayLike, order: int = 0) -> Array:
        """The points (…, n) of the path at the parameters `places`, or its derivatives."""
        s = np.asarray(places, np.float64)
        k = np.clip(np.searchsorted(self.borders, s, side="right") - 1, 0, len(self.coefficients) - 1)
        return values(derivative(self.coefficients[k], order), (s - self.borders[k])[..., None])

    def straight(self, places: ArrayLike) -> Array:
        """The points (…, n) of the path without rounding of corners, at the parameters `places`."""
        s = np.asarray(places, np.float64)
        k = np.clip(np.searchsorted(self.places, s, side="right") - 1, 0, len(self.bases) - 1)
        return np.asarray(values(self.bases[k], (s - self.places[k])[..., None]))


def blended(
    corners: ArrayLike, deviation: float, shares: ArrayLike | None = None, slopes: Array | None = None
) -> Blended:
    """The path along corners (m, n) that stays by `deviation` [rad, L2] or less from the pieces between them.

    The bound holds for points at the same parameter.

    Args:
        corners: at least two corners (m, n), of which adjacent ones differ.
        deviation: the greatest permitted distance of the path from the straight pieces.
        shares: (m,) the fraction of its greatest trim that each corner gets; at 0 the path stops there, if it turns.
        slopes: (m - 1, 2, n) the derivatives by the length of its chord where each piece begins and ends.
    """
    points = np.array(corners, np.float64)
    if len(points) < 2 or np.linalg.norm(np.diff(points, axis=0), axis=1).min() <= MIN_PIECE_LENGTH:
        raise ValueError("a path needs two corners, and neighbours that differ")
    places, turns, bases = _unrounded(points, slopes)
    bend = np.linalg.norm(turns, axis=1)
    wanted = np.ones(len(points) - 2) if shares is None else np.asarray(shares, np.float64)[1:-1]
    if slopes is not None:
        wanted = np.where(bend == 0.0, 0.0, wanted)
    rests = np.concatenate([[True], (wanted <= 0.0) & ((bend > 0.0) | (slopes is None)), [True]])
    trims = np.zeros(len(points))
    trims[1:-1] = (
        np.minimum(_room(places, rests), deviation / CORNER_SHARE / np.maximum(bend, GENTLE_TURN)) * wanted
    )
    fit_trims(places, bases, turns, trims, float(deviation), MIN_PIECE_LENGTH, (MIN_SHRINKING, MAX_SHRINKING))
    return Blended(points, trims, slopes)


def _room(places: Array, rests: NDArray[np.bool_]) -> Array:
    """The distance of each inner corner from the nearest corner where the path stops."""
    stops = places[rests]
    inner = places[1:-1]
    k = np.clip(np.searchsorted(stops, inner, side="right"), 1, len(stops) - 1)
    return np.minimum(inner - stops[k - 1], stops[k] - inner)


def _unrounded(points: Array, slopes: Array | None) -> tuple[Array, Array, Array]:
    """Places (m,) of the corners, turns (m - 2, n), and the pieces between corners."""
    given = _NO_SLOPES if slopes is None else np.ascontiguousarray(slopes, np.float64)
    places, turns, bases = unrounded(np.ascontiguousarray(points), given, slopes is None)
    return places, turns, bases


def thinned(waypoints: ArrayLike, tolerance: float) -> list[int]:
    """The indices of the way points (m, n) to keep; the others lie within `tolerance` [L2] of the path along these.

    [Douglas, Peucker 1973]; the first and the last are kept.
    """
    path = np.array(waypoints, np.float64)
    kept, waiting = {0, len(path) - 1}, [(0, len(path) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        away = _distances(path[first + 1 : last], path[first], path[last])
        worst = int(np.argmax(away))
        if away[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            waiting += [(first, middle), (middle, last)]
    return sorted(kept)


def _distances(points: Array, start: Array, end: Array) -> Array:
    """The distances (k,) of points (k, n) from a segment."""
    way = end - start
    square = float(way @ way)
    shares = np.zeros(len(points)) if square == 0.0 else np.clip((points - start) @ way / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - shares[:, None] * way, axis=1))
