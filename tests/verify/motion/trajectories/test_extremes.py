"""The greatest values of polynomials, against the roots of their derivatives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from kabo.verify.motion.trajectories.curves import Curve
from kabo.verify.motion.trajectories.extremes import greatest, outside

numbers = st.integers(0, 2**32 - 1)


def random_curve(seed: int) -> Curve:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.5, 3))])
    return Curve(times, rng.normal(size=(3, 2, 6)))


def extremes(curve: Curve, order: int) -> np.ndarray:
    """The least and the greatest value (2, n) of each joint's derivative, by the roots of the next one."""
    rows = []
    for k, h in enumerate(np.diff(curve.times)):
        for j in range(curve.powers.shape[1]):
            own = Polynomial(curve.powers[k, j]).deriv(order) if order else Polynomial(curve.powers[k, j])
            roots = own.deriv().roots()
            inner = [r.real for r in roots if abs(r.imag) < 1e-9 and 0 < r.real < h]
            rows.append((j, *(f([own(t) for t in (0.0, h, *inner)]) for f in (min, max))))
    table = np.array(rows)
    return np.array(
        [
            [table[table[:, 0] == j, 1].min() for j in range(curve.powers.shape[1])],
            [table[table[:, 0] == j, 2].max() for j in range(curve.powers.shape[1])],
        ]
    )


@given(seed=numbers, order=st.integers(1, 3))
def test_the_greatest_share_of_a_limit_is_that_of_the_roots(seed, order):
    curve, limits = random_curve(seed), np.array([3.0, 5.0])
    low, high = extremes(curve, order)
    truth = float((np.maximum(-low, high) / limits).max())
    found = greatest(curve, order, limits)
    assert found.share == pytest.approx(truth, rel=2e-4)
    assert found.share <= truth * (1.0 + 1e-9)
    value = abs(curve.at(np.array([found.time - 1e-12]), order)[0, found.joint])
    later = abs(curve.at(np.array([found.time]), order)[0, found.joint])
    assert found.value in (pytest.approx(value, rel=1e-6), pytest.approx(later, rel=1e-6))


@given(seed=numbers, excess=st.sampled_from([1e-8, 1e-6, 1e-3]))
def test_a_limit_is_decided_exactly_even_when_greater_shares_are_known(seed, excess):
    curve = random_curve(seed)
    low, high = extremes(curve, 2)
    truth = np.maximum(-low, high)
    assert greatest(curve, 2, truth / (1.0 + excess), known=1.0).too_much
    assert not greatest(curve, 2, truth * (1.0 + 1e-12), known=0.5).too_much


@given(seed=numbers)
def test_positions_outside_of_their_limits_are_found_and_none_inside(seed):
    curve = random_curve(seed)
    low, high = extremes(curve, 0)
    assert outside(curve, low, high) is None
    infinite = np.full(2, np.inf)
    assert outside(curve, -infinite, infinite) is None
    above = outside(curve, -infinite, high - 1e-6)
    assert above is not None and above.value == pytest.approx(high[above.joint], abs=2e-6)
    below = outside(curve, low + 1e-6, infinite)
    assert below is not None and below.value == pytest.approx(low[below.joint], abs=2e-6)


def test_a_joint_that_must_not_move_may_stand():
    still = Curve(np.array([0.0, 1.0]), np.array([[[0.3, 0, 0, 0, 0, 0]]], float))
    assert not greatest(still, 1, np.zeros(1)).too_much
    moving = Curve(np.array([0.0, 1.0]), np.array([[[0.3, 1e-9, 0, 0, 0, 0]]], float))
    assert greatest(moving, 1, np.zeros(1)).too_much
