"""Rounded coefficients: what they move, how short they are, and that rounding again changes nothing."""

from fractions import Fraction

import numpy as np
import pytest

from kabo.motion.rounding import decimals_of, rounded_coefficients

SPANS = np.array([1e-6, 3e-4, 0.033, 0.2, 1.0, 4.6, 30.0])


def exact(own, at, order):
    """A derivative of a polynomial in fractions: the oracle, without rounding."""
    terms = [Fraction(float(c)) for c in own]
    for _ in range(order):
        terms = [k * c for k, c in enumerate(terms)][1:]
    return sum(c * Fraction(float(at)) ** k for k, c in enumerate(terms))


def pieces(count, seed=0):
    """Polynomials (count, 7, 6) whose powers have effects of about 1, one for each of `count` spans."""
    random = np.random.default_rng(seed).normal(size=(count, 7, 6))
    return random / SPANS[:count, None, None] ** np.arange(6)


def test_values_and_derivatives_at_both_ends_move_by_less_than_3e_10_together():
    given = pieces(6)
    kept = rounded_coefficients(given, SPANS[:6])
    for k, span in enumerate(SPANS[:6]):
        for own, found in zip(given[k], kept[k], strict=True):
            for order in range(3):
                begin, end = (abs(exact(own, at, order) - exact(found, at, order)) for at in (0.0, span))
                # At most what a double has: of the shortest pieces the values are up to 1e12.
                assert begin + end <= 3e-10 + 1e-15 * float(
                    np.abs(own[order:] * span ** np.arange(6 - order)).max()
                )


def test_what_is_rounded_twice_is_as_rounded_once():
    once = rounded_coefficients(pieces(7), SPANS)
    assert np.array_equal(rounded_coefficients(once, SPANS), once)
    assert np.array_equal(rounded_coefficients(once, (SPANS + 17.3) - 17.3), once)  # later in the plan


def test_high_powers_of_short_pieces_have_few_decimals_and_of_long_ones_many():
    found = decimals_of(SPANS)
    assert found[2].tolist() == [11, 11, 11, 10, 9, 8]
    assert np.all(np.diff(found, axis=0) >= 0)
    assert found[-1, 5] > 15


@pytest.mark.parametrize("value", [0.0, -0.0, -1e-13])
def test_nothing_becomes_a_negative_zero(value):
    kept = rounded_coefficients(np.full((1, 1, 6), value), SPANS[2:3])
    assert not np.signbit(kept).any()
