"""Tests of the distance of motions from lines that are proportional to time."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import Trajectory, chord_deviations


@given(st.integers(0, 10**6), st.integers(1, 4), st.integers(1, 5))
def test_no_joint_is_farther_from_the_chord_than_the_deviation(seed, joints, pieces):
    """Against samples: the bound holds, and is not much greater than what is found."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(np.concatenate([[0.3], rng.uniform(0.01, 0.5, pieces)]))
    motion = Trajectory.of_arrays(
        [f"j{i}" for i in range(joints)], np.zeros((2, joints)), times, rng.normal(size=(pieces, joints, 6))
    )
    passing = np.unique(np.concatenate([times, rng.uniform(times[0], times[-1], 4)]))
    waypoints = motion.at(passing)
    waypoints[0] += 0.01  # a way point need not lie on the motion
    found = chord_deviations(times, motion.padded, waypoints, passing)
    for i in range(len(passing) - 1):
        at = np.linspace(passing[i], passing[i + 1] - 1e-12, 200)
        share = ((at - passing[i]) / (passing[i + 1] - passing[i]))[:, None]
        away = np.abs(motion.at(at) - waypoints[i] - share * (waypoints[i + 1] - waypoints[i])).max(axis=0)
        assert np.all(away <= found[i] + 1e-9)
        assert np.all(found[i] <= 2.0 * away + 0.02)


def test_constant_velocity_has_no_deviation():
    motion = Trajectory.linear(("a", "b"), [(0.0, 0.0), (1.0, 0.5), (0.0, 0.0)], (0.0, 1.0, 2.0))
    passing = np.array([0.0, 0.25, 1.0, 2.0])
    found = chord_deviations(np.asarray(motion.times), motion.padded, motion.at(passing), passing)
    assert np.abs(found).max() < 1e-15
