"""Rounding of coefficients for plans: each to as many decimals as its effect needs, and no more.

An error e of the coefficient of t^k moves the m-th derivative by up to k! / (k - m)! h^(k - m) e in a piece of h
seconds. So high powers need few decimals in short pieces, and many in long ones. The number of decimals depends on the
power and on h alone: what is rounded twice is as rounded once.
"""

from math import perm

import numpy as np

from kabo.arrays import Array, Integers
from kabo.motion.bernstein import MAX_DEGREE

# What one coefficient may move position, velocity, acceleration and jerk by [rad or m, and s]. Six coefficients end at a
# border of pieces, and three begin there: jumps stay below 3e-10.
TOLERANCES = (2e-11, 1e-11, 5e-11, 2e-9)
MAX_DECIMALS = 22  # the greatest power of ten that a double is exactly
EXACT = 2.0**50  # numbers above it, in units of the last decimal, have fewer digits than they may have
# What a coefficient of each power (6) moves each derivative (4) by, in tolerances: a factor times a power of the duration.
_ORDERS = range(len(TOLERANCES))
_FACTORS = np.array([[perm(k, m) / TOLERANCES[m] for m in _ORDERS] for k in range(MAX_DEGREE + 1)])
_POWERS = np.array([[max(k - m, 0) for m in _ORDERS] for k in range(MAX_DEGREE + 1)])
_NEEDING_MORE = 2.0 * 10.0 ** np.arange(MAX_DECIMALS + 1)  # effects above which one decimal more is needed
_SCALES = 10.0 ** np.arange(MAX_DECIMALS + 1)


def decimals_of(spans: Array) -> Integers:
    """How many decimals (k, 6) the coefficients of pieces of the durations `spans` (k,) [s] need."""
    lengths = np.round(np.asarray(spans, np.float64), 6)[:, None, None]
    effects = (_FACTORS * lengths**_POWERS).max(axis=2)
    return np.asarray(np.minimum(np.searchsorted(_NEEDING_MORE, effects), MAX_DECIMALS))


def rounded_coefficients(padded: Array, spans: Array) -> Array:
    """The coefficients (k, n, 6) of pieces of the durations `spans` (k,), rounded; no zeros are negative."""
    scale = _SCALES[decimals_of(spans)][:, None, :]
    units = padded * scale
    return np.asarray(np.where(np.abs(units) < EXACT, np.rint(units) / scale, padded) + 0.0)
