"""Tests of the distance of several motions at once from their joined path."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import Polynomials, Trajectory, joined_deviations

LEAST_JERK = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])  # from 0 to 1 in 1 s


@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(1, 4))
def test_no_joint_is_farther_from_the_joined_path_than_the_deviation(seed, robots, pieces):
    """Against samples: one place on the piece is as near to all joints as the bound says, and no joint is much nearer."""
    rng = np.random.default_rng(seed)
    motions = []
    for _ in range(robots):
        times = np.concatenate([[0.3], np.sort(rng.uniform(0.31, 1.0, pieces)), [1.1]])
        motions.append(Polynomials(times, rng.normal(size=(pieces + 1, 2, 6))))
    passing = np.unique(np.concatenate([*(own.times for own in motions), rng.uniform(0.3, 1.1, 4)]))
    waypoints = np.hstack([places(own, passing) for own in motions])
    waypoints[0] += 0.01  # a way point need not lie on the motion
    found = joined_deviations(motions, waypoints, passing)
    for i, step in enumerate(np.diff(waypoints, axis=0)):
        at = np.linspace(passing[i], passing[i + 1] - 1e-12, 200)
        here = np.hstack([places(own, at) for own in motions]) - waypoints[i]
        share = np.clip(here @ step / max(step @ step, 1e-300), 0.0, 1.0)[:, None]
        assert np.all(np.abs(here - share * step).max(axis=0) <= found[i] + 1e-9)
        beyond = np.ptp(here @ step) / max(step @ step, 1e-300)
        assert np.all(found[i] <= 2.0 * np.abs(here).max() * (1.0 + beyond) + 0.02)


def places(own: Polynomials, at: np.ndarray) -> np.ndarray:
    rows = np.zeros((2, 2))
    return Trajectory.of_arrays(("a", "b"), rows, own.times, own.padded).at(at)


def test_constant_velocity_has_no_deviation():
    motion = Trajectory.linear(("a", "b"), [(0.0, 0.0), (1.0, 0.5), (0.0, 0.0)], (0.0, 1.0, 2.0))
    passing = np.array([0.0, 0.25, 1.0, 2.0])
    found = joined_deviations([Polynomials(np.array(motion.times), motion.padded)], motion.at(passing), passing)
    assert np.abs(found).max() < 1e-15


@pytest.mark.parametrize(("late", "least", "most"), [(0.0, 0.0, 1e-12), (0.001, 5e-4, 5e-3)])
def test_two_robots_follow_their_joined_path_exactly_if_they_have_one_law(late, least, most):
    """From rest to rest, the first by 1 rad and the second by 2 rad, so much later."""
    robots = [way * LEAST_JERK[None, None] for way in (1.0, 2.0)]
    motions = [Polynomials(np.array([0.0, 1.0]), robots[0]), Polynomials(np.array([late, 1.0 + late]), robots[1])]
    passing = np.array([late, 0.5, 1.0])
    waypoints = np.hstack([places_of_one(own, passing) for own in motions])
    assert least <= joined_deviations(motions, waypoints, passing).max() <= most


def places_of_one(own: Polynomials, at: np.ndarray) -> np.ndarray:
    return np.polynomial.polynomial.polyval(at - own.times[0], own.padded[0, 0])[:, None]
