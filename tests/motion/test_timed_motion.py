"""Tests of the motion along a path: limits, borders, ends, distances from the path."""

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.motion import MotionLimits, rounded_path, timed_path

SEEDS = st.integers(0, 10**6)


def judge(made, limits):
    """A motion is within its limits, smooth, at rest at its ends, near its path; by plain evaluation and by bounds."""
    n = made.waypoints.shape[1]
    motion = made.trajectory([f"j{i}" for i in range(n)])
    times = np.asarray(motion.times)
    assert np.array_equal(np.round(times, 6), times)
    for order, limit in enumerate(limits.rows, 1):
        low, high = motion.bounds(order)
        assert np.all(np.maximum(-low, high) <= limit), f"derivative {order}"
    for k, span in enumerate(np.diff(times)[:-1]):
        for order in range(3):
            ends = [
                np.polynomial.polynomial.polyval(t, np.polynomial.polynomial.polyder(own.T, order))
                for t, own in ((span, motion.padded[k]), (0.0, motion.padded[k + 1]))
            ]
            assert np.abs(ends[0] - ends[1]).max() <= 1e-9
    for order in (1, 2):
        assert np.abs(motion.at(times[[0, -1]], order)).max() <= 1e-9
    assert np.allclose(motion.at(times[[0, -1]]), made.waypoints[[0, -1]], atol=1e-9)
    samples = motion.sampled(min(1000.0, 1e5 / motion.duration))
    assert np.all(np.abs(samples.velocities) <= limits.velocity)
    assert np.all(np.abs(samples.accelerations) <= limits.acceleration)
    k = np.clip(np.searchsorted(made.passing, samples.times, side="right") - 1, 0, len(made.waypoints) - 2)
    start, step = made.waypoints[k], made.waypoints[k + 1] - made.waypoints[k]
    shares = np.clip(
        ((samples.positions - start) * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-300), 0, 1
    )
    away = np.abs(samples.positions - start - shares[:, None] * step)
    assert away.max() <= motion.deviation
    assert np.all(away <= made.deviations[k] + 1e-12)
    return motion


@given(SEEDS, st.integers(1, 20), st.sampled_from([1e-6, 1e-2, 1.0]), st.integers(2, 12))
def test_a_motion_that_stops_at_corners_keeps_limits_and_path(seed, joints, size, count):
    rng = np.random.default_rng(seed)
    limits = MotionLimits.of(*(np.exp(rng.uniform(-1.0, 2.0, joints)) * k for k in (1.0, 4.0, 80.0)))
    made = timed_path(rng.normal(size=(count, joints)) * size, limits)
    motion = judge(made, limits)
    assert motion.deviation == 1e-9
    assert np.allclose(motion.at(made.passing), made.waypoints, atol=1e-9)
    assert np.abs(motion.at(made.passing, 1)).max() <= 1e-9


@given(
    SEEDS,
    st.integers(1, 12),
    st.sampled_from([1e-5, 1e-2, 1.0]),
    st.integers(2, 7),
    st.sampled_from([0.003, 0.05]),
)
def test_a_motion_that_rounds_corners_keeps_limits_and_path(seed, joints, size, count, deviation):
    rng = np.random.default_rng(seed)
    limits = MotionLimits.of(*(np.exp(rng.uniform(-1.0, 2.0, joints)) * k for k in (1.0, 4.0, 80.0)))
    corners = rng.normal(size=(count, joints)) * size
    shares = rng.choice([0.0, 0.3, 1.0, 1.0], count)
    made = timed_path(corners, limits, deviation=deviation, shares=shares.tolist())
    judge(made, limits)
    away = [np.linalg.norm(made.waypoints[i] - corner) for i, corner in zip(made.corners, corners, strict=True)]
    assert max(away) <= deviation + 1e-4 * np.sqrt(joints)  # the tolerance is of each joint
    event("faster" if made.duration < 0.99 * timed_path(corners, limits).duration else "not faster")


def test_the_path_of_a_motion_is_known_before_its_times():
    """At unit speed on straight pieces; where the motion does not stop it passes the same corners, as near to them."""
    limits, deviation = MotionLimits.of(np.ones(2), np.full(2, 4.0), np.full(2, 80.0)), 0.05
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
    options = {"deviation": deviation, "shares": [1.0, 1.0, 1.0, 1.0, 1.0], "chord": 1e-3}
    path, trims = rounded_path(corners, **options)
    made = timed_path(corners, limits, tolerance=1e-6, **options)
    assert path.corners == made.corners and trims[1] == trims[2] == 0.0 < trims[3]
    assert np.allclose(path.waypoints[list(path.corners)], made.waypoints[list(made.corners)], atol=1e-5)
    assert np.allclose(path.at(np.array([0.5])), [[0.5, 0.0]]) and path.duration == pytest.approx(3.0)
    assert path.deviations.max() <= 1e-3


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e7, np.inf])
def test_tiny_and_huge_limits_are_kept(scale):
    limits = MotionLimits.of(np.full(2, scale), np.full(2, 4.0 * scale), np.full(2, 80.0 * scale))
    judge(timed_path([[0.0, 0.0], [0.01, -0.02], [0.01, 0.0]], limits), limits)


def test_corners_are_found_again_and_a_motion_is_cut_at_them():
    limits = MotionLimits.of([1.0, 1.0], [4.0, 4.0], [80.0, 80.0])
    made = timed_path([[0, 0], [1, 0], [1, 0], [1, 1], [0, 0]], limits)
    assert made.corners == (0, 1, 1, 2, 3)
    first, second = made.parts(("a", "b"), [3], start=2.0)
    assert first.times[0] == 2.0
    assert first.times[-1] == second.times[0]
    assert second.waypoints == ((1.0, 1.0), (0.0, 0.0))
    assert first.joined(second) == made.trajectory(("a", "b"), start=2.0)
    assert made.passed(2, 3, start=2.0) == second.times[:: len(second.times) - 1]


def test_corners_that_differ_by_rounding_are_one_and_the_end_is_exact():
    limits = MotionLimits.of([1.0], [4.0], [80.0])
    made = timed_path([[0.0], [0.5], [0.500000001], [1.0], [1.000000001]], limits, deviation=0.1, shares=[1.0] * 5)
    assert made.corners == (0, 1, 1, 2, 2)
    assert made.waypoints[-1].tolist() == [1.000000001]


def test_the_same_corners_give_the_same_bytes():
    limits = MotionLimits.of([1.0, 1.0], [4.0, 4.0], [80.0, 80.0])
    corners = [[0, 0], [1, 0.3], [1, 1]]
    assert repr(timed_path(corners, limits)) == repr(timed_path(corners, limits))


def test_a_motion_that_stays_takes_one_microsecond():
    made = timed_path([[0.5], [0.5]], MotionLimits.of([0.0], [0.0], [0.0]))
    assert made.duration == 1e-6
    assert made.corners == (0, 1)
    assert made.waypoints.tolist() == [[0.5], [0.5]]
    assert made.trajectory(("a",)).at([0.0, 1.0]).tolist() == [[0.5], [0.5]]


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="do not fit"):
        timed_path([[0.0, 1.0]], MotionLimits.of([1.0], [1.0], [1.0]))
