"""Tests of the fastest motion from rest to rest along a line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from kabo.motion import MotionLimits
from kabo.motion.s_curves import line_pieces, phases

LIMIT = st.floats(0.05, 50.0)


@given(LIMIT, LIMIT, LIMIT)
def test_the_phases_keep_all_limits_and_one_of_them_is_reached(velocity, acceleration, jerk):
    own = phases(velocity, acceleration, jerk)
    tj, ta, tv = (each * 1e-6 for each in own)
    needed = 1.0 / (tj * (tj + ta) * (2 * tj + ta + tv))
    uses = needed / jerk, needed * tj / acceleration, needed * tj * (tj + ta) / velocity
    assert max(uses) <= 1.0 + 1e-9
    assert max(uses) >= 1.0 - 1e-4
    assert sum(use > 0.999 for use in uses) >= 1 + (ta > 0 or tv > 0)


@pytest.mark.parametrize("limits", [(0.5, 2.0, 20.0), (3.0, 4.0, 8.0), (9.0, 2.0, 40.0), (0.4, 9.0, 3.0)])
def test_no_motion_of_discrete_steps_of_jerk_is_faster(limits):
    """Against a linear program: in a time shorter by 2 %, no jerk that is constant in 200 steps moves by 1."""
    velocity, acceleration, jerk = limits
    steps = 200
    span = 0.98 * phases(*limits).ticks * 1e-6 / steps
    a = np.tril(np.ones((steps, steps))) * span
    before_a = np.vstack([np.zeros(steps), a[:-1]])
    v = np.cumsum(before_a * span + np.eye(steps) * span**2 / 2, axis=0)
    before_v = np.vstack([np.zeros(steps), v[:-1]])
    way = (before_v * span + before_a * span**2 / 2 + np.eye(steps) * span**3 / 6).sum(axis=0)
    found = linprog(
        -way,
        A_ub=np.vstack([a, -a, v, -v]),
        b_ub=np.concatenate([np.full(2 * steps, acceleration), np.full(2 * steps, velocity)]),
        A_eq=np.vstack([a[-1], v[-1]]),
        b_eq=np.zeros(2),
        bounds=(-jerk, jerk),
    )
    assert found.status == 0
    assert 0.9 < -found.fun < 1.0


@given(st.integers(0, 10**6), st.sampled_from([1e-6, 1e-3, 1.0, 30.0]))
def test_pieces_are_smooth_exact_at_their_ends_and_on_the_line(seed, size):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 8))
    start, end = rng.normal(size=(2, n)) * size
    limits = MotionLimits.of(*(rng.uniform(0.1, 3.0, n) * k for k in (1.0, 4.0, 40.0)))
    spans, pieces = line_pieces(start, end, limits)
    state = np.stack([start, np.zeros(n), np.zeros(n)])
    for ticks, piece in zip(spans, pieces, strict=True):
        assert np.allclose(state, [piece[:, 0], piece[:, 1], 2 * piece[:, 2]], atol=1e-9)
        state = np.stack(
            [
                np.polynomial.polynomial.polyval(ticks * 1e-6, np.polynomial.polynomial.polyder(piece.T, k))
                for k in range(3)
            ]
        )
        unit = (end - start) / np.linalg.norm(end - start)
        away = piece.T[1:]
        assert np.allclose(away - np.outer(away @ unit, unit), 0.0, atol=1e-12)
    assert np.allclose(state, [end, np.zeros(n), np.zeros(n)], atol=1e-9)


def test_a_joint_that_moves_needs_limits():
    with pytest.raises(ValueError, match="jerk above 0"):
        line_pieces(np.zeros(2), np.ones(2), MotionLimits.of([1, 1], [1, 1], [0, 1]))
    with pytest.raises(ValueError, match="length"):
        line_pieces(np.zeros(2), np.zeros(2), MotionLimits.of([1, 1], [1, 1], [1, 1]))
