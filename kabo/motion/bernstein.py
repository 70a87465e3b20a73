"""Bounds of polynomials by Bernstein coefficients: a polynomial stays within the range of its coefficients.

Polynomials have at most six coefficients in increasing powers of a local time that runs from 0 to a duration
[Farouki 2012, The Bernstein polynomial basis]. All functions work on arrays of polynomials; the last axis is the power.
"""

from math import comb
from numbers import Integral

import numpy as np

from kabo.arrays import Array
from kabo.given import refuse, require_number, shown

MAX_DEGREE = 5  # of a piece: position, velocity and acceleration at both of its ends determine it


def _matrices(degree: int) -> tuple[Array, Array, Array]:
    """The matrices that give Bernstein coefficients from powers, and those of the first and second half."""
    powers = np.array([[comb(i, k) / comb(degree, k) for k in range(degree + 1)] for i in range(degree + 1)])
    first = np.array([[comb(i, k) / 2.0**i for k in range(degree + 1)] for i in range(degree + 1)])
    return powers, first, first[::-1, ::-1].copy()


MAX_HALVINGS = 12  # of a piece: bounds are then as near as rounding allows, and each one doubles the numbers
_OF_DEGREE = [_matrices(degree) for degree in range(MAX_DEGREE + 1)]


def derivative(coefficients: Array, order: int) -> Array:
    """The coefficients (…, k - order) of the derivative of polynomials (…, k); one zero if nothing is left.

    Raises:
        ArgumentError: the order is no whole number from 0 on.
    """
    if not isinstance(order, Integral) or isinstance(order, bool) or order < 0:
        refuse("order", f"derivatives have the order 0 or more, not {shown(order)}")
    found = coefficients
    for _ in range(min(int(order), found.shape[-1])):
        found = found[..., 1:] * np.arange(1, found.shape[-1])
    return found if found.shape[-1] else np.zeros((*found.shape[:-1], 1))


def bernstein(coefficients: Array, durations: Array) -> Array:
    """The Bernstein coefficients (…, k) of polynomials (…, k) on local times from 0 to `durations` (…)."""
    k = coefficients.shape[-1]
    scaled = coefficients * np.asarray(durations)[..., None] ** np.arange(k)
    return np.asarray(scaled @ _OF_DEGREE[k - 1][0].T)


def halved(controls: Array) -> Array:
    """Bernstein coefficients (2, …, k) of the first and the second half of polynomials (…, k) [de Casteljau]."""
    _, first, second = _OF_DEGREE[controls.shape[-1] - 1]
    return np.stack([controls @ first.T, controls @ second.T])


def ranges(coefficients: Array, durations: Array, *, halvings: int = 3) -> tuple[Array, Array]:
    """A lower and an upper bound (…) of polynomials (…, k) on local times from 0 to `durations` (…).

    Args:
        coefficients: in increasing powers.
        durations: positive.
        halvings: how often the time is halved; the excess of bounds falls to a quarter each time.

    Raises:
        ArgumentError: `halvings` is no whole number from 0 to `MAX_HALVINGS`.
    """
    halvings = require_number("halvings", halvings, 0, MAX_HALVINGS, whole=True)
    controls = bernstein(coefficients, durations)[None]
    for _ in range(halvings if coefficients.shape[-1] > 2 else 0):
        controls = halved(controls).reshape(-1, *controls.shape[1:])
    return controls.min(axis=(0, -1)), controls.max(axis=(0, -1))


def recentred(coefficients: Array, delays: Array) -> Array:
    """The same polynomials (…, 6) in powers of a local time that begins `delays` (…) later."""
    found, delay = np.array(coefficients, np.float64), np.asarray(delays)
    for level in range(MAX_DEGREE):  # as in Horner's scheme, which is quicker than powers
        for k in range(MAX_DEGREE - 1, level - 1, -1):
            found[..., k] += delay * found[..., k + 1]
    return found


def values(coefficients: Array, local: Array) -> Array:
    """The values (…) of polynomials (…, k) at local times (…)."""
    found = np.zeros(coefficients.shape[:-1])
    for power in range(coefficients.shape[-1] - 1, -1, -1):
        found = found * local + coefficients[..., power]
    return found
