"""Curves: their values, and Bernstein coefficients on any interval, against scipy's polynomials."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly, PPoly

from kabo.motion import Trajectory
from kabo.plan import Segment
from kabo.verify.motion.trajectories.curves import Curve, bernstein, curve_of, derived, halves

numbers = st.integers(0, 2**32 - 1)


def random_curve(seed: int, pieces: int = 3, joints: int = 4) -> Curve:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.3], 0.3 + np.cumsum(rng.uniform(0.05, 1.5, pieces))])
    return Curve(times, rng.normal(size=(pieces, joints, 6)))


def oracle(curve: Curve) -> PPoly:
    """The curve in scipy's hands: coefficients in decreasing powers, (6, pieces, joints)."""
    return PPoly(np.moveaxis(curve.powers[:, :, ::-1], 2, 0), curve.times)


@given(seed=numbers)
def test_values_and_derivatives_are_those_of_scipy(seed):
    curve = random_curve(seed)
    times = np.random.default_rng(seed).uniform(curve.times[0], curve.times[-1], 20)
    for order in range(5):
        np.testing.assert_allclose(curve.at(times, order), oracle(curve)(times, order), rtol=1e-9, atol=1e-9)


@given(seed=numbers)
def test_bernstein_coefficients_on_an_interval_make_the_same_polynomial_and_enclose_it(seed):
    curve, rng = random_curve(seed), np.random.default_rng(seed)
    pieces = rng.integers(0, 3, 5)
    shares = np.sort(rng.uniform(0.0, 1.0, (5, 2)), axis=1)
    spans = np.diff(curve.times)[pieces]
    starts, ends = curve.times[pieces] + shares[:, 0] * spans, curve.times[pieces] + shares[:, 1] * spans
    found = curve.between(starts, ends)
    for coefficients, start, end in zip(found, starts, ends, strict=True):
        grid = np.linspace(start, end, 50)
        values = BPoly(coefficients.T[:, None, :], [start, end])(grid)
        np.testing.assert_allclose(values, oracle(curve)(grid), atol=1e-9)
        assert (values <= coefficients.max(axis=1) + 1e-9).all()
        assert (values >= coefficients.min(axis=1) - 1e-9).all()


@given(seed=numbers)
def test_halves_are_the_same_polynomial_on_either_half(seed):
    curve = random_curve(seed, pieces=1)
    (start, end), middle = curve.times, curve.times.mean()
    first, second = halves(bernstein(curve.powers, np.diff(curve.times)))
    np.testing.assert_allclose(first, curve.between(np.array([start]), np.array([middle])), atol=1e-9)
    np.testing.assert_allclose(second, curve.between(np.array([middle]), np.array([end])), atol=1e-9)


def test_the_derivative_of_coefficients_is_numpys():
    powers = np.arange(1.0, 7.0)
    assert derived(powers) == pytest.approx([*np.polynomial.polynomial.polyder(powers), 0.0])


def test_a_segment_without_trajectory_goes_straight_and_one_with_follows_its_polynomials():
    segment = Segment("arm", ("a", "b"), ((0.0, 1.0), (1.0, 3.0)), (2.0, 4.0), "move")
    assert curve_of(segment).at(np.array([3.0]))[0] == pytest.approx([0.5, 2.0])
    own = Trajectory(segment.joints, segment.waypoints, (2.0, 4.0), (((0.0, 0.0, 0.25), (1.0, 1.0)),))
    with_it = Segment("arm", ("a", "b"), segment.waypoints, (2.0, 4.0), "move", trajectory=own)
    assert curve_of(with_it).at(np.array([3.0]))[0] == pytest.approx([0.25, 2.0])
