"""Piecewise polynomials in time, and bounds of them that hold everywhere: Bernstein's, with subdivision.

A polynomial on an interval lies between the least and the greatest of its Bernstein coefficients, and equals the first
and the last of them at the ends [Farouki 2012, section 3]. Halving the interval brings the others nearer, quadratically.
"""

from dataclasses import dataclass
from math import comb

import numpy as np

from kabo.arrays import Array, Integers
from kabo.plan import Segment

DEGREE = 5
# Bernstein coefficients of u^k: b_i = C(i, k) / C(5, k) for i >= k.
_BERNSTEIN = np.array([[comb(i, k) / comb(DEGREE, k) for k in range(DEGREE + 1)] for i in range(DEGREE + 1)])
_BINOMIAL = np.array([[comb(i, k) for k in range(DEGREE + 1)] for i in range(DEGREE + 1)], np.float64)
_EXPONENTS = np.arange(DEGREE + 1)
# Halves of de Casteljau: the coefficients of the first and the second half, from those of the whole.
_FIRST = np.array([[comb(i, k) / 2.0**i for k in range(DEGREE + 1)] for i in range(DEGREE + 1)])
_SECOND = _FIRST[::-1, ::-1]


@dataclass(frozen=True, eq=False)
class Curve:
    """Some joints' values in time: piece k is a polynomial in the time since `times[k]`.

    Attributes:
        times: the ends of the K pieces (K + 1,) [s], strictly increasing.
        powers: the coefficients (K, n, 6) in increasing powers.
    """

    times: Array
    powers: Array

    def pieces_at(self, times: Array) -> Integers:
        """The piece for each time; at a border the later one, before the beginning the first, after the end the last."""
        found = np.searchsorted(self.times, times, side="right") - 1
        return np.asarray(np.clip(found, 0, len(self.powers) - 1))

    def at(self, times: Array, order: int = 0) -> Array:
        """The values (T, n) at times (T,) [s], or their derivatives; after the end and before the start as there."""
        clipped = np.clip(times, self.times[0], self.times[-1])
        pieces = self.pieces_at(clipped)
        return values(self.powers[pieces], clipped - self.times[pieces], order)

    def between(self, starts: Array, ends: Array) -> Array:
        """The Bernstein coefficients (T, n, 6) on intervals, each of which lies in one piece."""
        pieces = self.pieces_at((starts + ends) / 2)
        powers, begin = self.powers[pieces], starts - self.times[pieces]
        # Taylor's shift to the beginning of the interval, then time as a share of the interval.
        lags = _EXPONENTS[None, :] - _EXPONENTS[:, None]  # of the power i over k
        shift = np.where(lags >= 0, begin[:, None, None] ** np.maximum(lags, 0), 0.0) * _BINOMIAL.T
        shifted = np.einsum("tki,tni->tnk", shift, powers)
        return np.asarray((shifted * ((ends - starts)[:, None, None] ** _EXPONENTS)) @ _BERNSTEIN.T)


def curve_of(segment: Segment) -> Curve:
    """The curve that a segment's joints follow; with constant velocities between way points without a trajectory."""
    given = segment.trajectory
    if given is None:
        rows, times = np.asarray(segment.waypoints, np.float64), np.asarray(segment.times, np.float64)
        powers = np.zeros((len(rows) - 1, rows.shape[1], DEGREE + 1))
        powers[:, :, 0], powers[:, :, 1] = rows[:-1], np.diff(rows, axis=0) / np.diff(times)[:, None]
        return Curve(times, powers)
    powers = np.zeros((len(given.coefficients), len(given.joints), DEGREE + 1))
    for k, piece in enumerate(given.coefficients):
        for j, own in enumerate(piece):
            powers[k, j, : len(own)] = own
    return Curve(np.asarray(given.times, np.float64), powers)


def values(powers: Array, local: Array, order: int = 0) -> Array:
    """The values (T, n) of polynomials (T, n, 6) or of their derivatives, each row at its own local time (T,)."""
    for _ in range(order):
        powers = powers[..., 1:] * np.arange(1, powers.shape[-1])
    result = np.zeros(powers.shape[:-1])
    for k in range(powers.shape[-1] - 1, -1, -1):
        result = result * local[:, None] + powers[..., k]
    return result


def derived(powers: Array) -> Array:
    """The coefficients (…, 6) of the derivatives of polynomials."""
    result = np.zeros_like(powers)
    result[..., :-1] = powers[..., 1:] * np.arange(1, powers.shape[-1])
    return result


def bernstein(powers: Array, lengths: Array) -> Array:
    """The Bernstein coefficients (T, n, 6) of polynomials (T, n, 6) from local time 0 to `lengths` (T,)."""
    return np.asarray((powers * (lengths[:, None, None] ** _EXPONENTS)) @ _BERNSTEIN.T)


def halves(coefficients: Array) -> tuple[Array, Array]:
    """The Bernstein coefficients on the first and on the second half of the interval, from those (…, 6) on the whole."""
    return coefficients @ _FIRST.T, coefficients @ _SECOND.T
