"""Tests of bounds of polynomials."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion.bernstein import bernstein, derivative, halved, ranges, recentred, values

NUMBERS = st.floats(-10.0, 10.0)
POLYNOMIALS = st.lists(NUMBERS, min_size=6, max_size=6).map(np.array)
SPANS = st.floats(1e-3, 3.0)


@given(POLYNOMIALS, SPANS, st.integers(0, 3))
def test_values_are_within_their_bounds_and_the_bounds_are_tight(own, span, order):
    one = derivative(own, order)
    low, high = ranges(one, np.array(span), halvings=5)
    found = values(one, np.linspace(0.0, span, 2001)[:, None] + np.zeros((1, 1)))
    slack = 1e-9 * (1.0 + np.abs(found).max())
    assert low - slack <= found.min() <= found.max() <= high + slack
    width = np.ptp(bernstein(one, np.array(span)))
    assert found.min() - low <= 0.02 * width + slack
    assert high - found.max() <= 0.02 * width + slack


@given(POLYNOMIALS, SPANS)
def test_halves_have_the_ends_and_the_middle_of_the_whole(own, span):
    first, second = halved(bernstein(own, np.array(span)))
    ends = [np.polynomial.polynomial.polyval(t, own) for t in (0.0, span / 2, span)]
    assert np.allclose(
        [first[0], first[-1], second[0], second[-1]], [ends[0], ends[1], ends[1], ends[2]], atol=1e-9
    )


@given(POLYNOMIALS, SPANS)
def test_a_later_beginning_changes_powers_and_no_values(own, delay):
    moved = recentred(own[None], np.array([delay]))[0]
    assert np.allclose(
        np.polynomial.polynomial.polyval([0.0, 0.5], moved),
        np.polynomial.polynomial.polyval([delay, delay + 0.5], own),
        rtol=1e-9,
        atol=1e-9,
    )


def test_a_derivative_beyond_the_degree_is_zero():
    assert derivative(np.array([[3.0]]), 2).tolist() == [[0.0]]
