"""Tests of the distance of motions from their paths."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import Trajectory, path_deviations

SEEDS = st.integers(0, 10**6)


def random_motion(rng, joints, pieces):
    """A motion that passes random way points at times among its borders, and leaves the straight lines between them."""
    waypoints = rng.normal(size=(pieces // 2 + 1, joints))
    times = np.cumsum(np.concatenate([[0.0], rng.uniform(0.05, 0.6, pieces)]))
    passing = np.concatenate(
        [[0.0], np.sort(rng.choice(times[1:-1], len(waypoints) - 2, replace=False)), times[-1:]]
    )
    padded = rng.normal(size=(pieces, joints, 6)) * 0.1
    padded[:, :, 0] += [np.interp(times[:-1], passing, column) for column in waypoints.T][0][:, None]
    return times, padded, waypoints, passing


@given(SEEDS, st.integers(1, 4), st.integers(4, 8))
def test_no_joint_is_farther_from_the_path_than_the_deviation(seed, joints, pieces):
    """Against brute force: samples of time, and for each the point of least distance on the piece by projection."""
    times, padded, waypoints, passing = random_motion(np.random.default_rng(seed), joints, pieces)
    found = path_deviations(times, padded, waypoints, passing)
    motion = Trajectory.of_arrays([f"j{i}" for i in range(joints)], waypoints, times, padded)
    for i, (w0, w1) in enumerate(zip(waypoints, waypoints[1:], strict=False)):
        places = motion.at(np.linspace(passing[i], passing[i + 1] - 1e-12, 400))
        step = w1 - w0
        shares = np.clip((places - w0) @ step / (step @ step), 0.0, 1.0)
        away = np.abs(places - w0 - shares[:, None] * step).max(axis=0)
        assert np.all(away <= found[i] + 1e-9)
        # The bound is at most the distance, the excess of λ, and what Bernstein coefficients add.
        assert found[i].max() <= 3.0 * np.abs(places - w0).max() + 3.0 * np.abs(step).max()


def test_a_straight_motion_has_no_deviation():
    motion = Trajectory.linear(("a", "b"), [(0.0, 0.0), (1.0, 0.5), (0.0, 0.0)], (0.0, 1.0, 2.0))
    found = path_deviations(
        np.asarray(motion.times), motion.padded, np.asarray(motion.waypoints), np.array([0.0, 1.0, 2.0])
    )
    assert np.abs(found).max() < 1e-15


def test_what_leaves_the_end_of_a_piece_counts_by_its_excess():
    padded = np.zeros((1, 1, 6))
    padded[0, 0, 1] = 1.0  # moves to 1.0, and the path ends at 0.75
    found = path_deviations(np.array([0.0, 1.0]), padded, np.array([[0.0], [0.75]]), np.array([0.0, 1.0]))
    assert np.allclose(found, [[0.25]])
