"""The fastest way along a path."""

import numpy as np
import pytest

from kabo.motion import blended, fastest

pytest.importorskip("toppra")
CORNERS = np.array([[0.0, 0.0], [1.0, 0.2], [0.8, 1.3], [-0.2, 1.0]])
VELOCITY, ACCELERATION = np.array([1.0, 2.0]), np.array([3.0, 4.0])


def test_a_straight_line_takes_what_its_slowest_joint_needs() -> None:
    _, times = fastest(blended([[0.0, 0.0], [2.0, 0.0]], 0.1), [1.0, 1.0], [2.0, 2.0])
    assert times[-1] == pytest.approx(2.0 + 0.5, rel=0.02)  # half a second to get to speed, and half to rest


def test_limits_are_kept_between_the_places_too() -> None:
    path = blended(CORNERS, 0.05)
    places, times = fastest(path, VELOCITY, ACCELERATION)
    steps = np.diff(times)
    velocities = np.diff(path.at(places), axis=0) / steps[:, None]
    assert (np.abs(velocities) / VELOCITY).max() <= 1.0
    accelerations = np.diff(velocities, axis=0) / ((steps[1:] + steps[:-1]) / 2)[:, None]
    assert (np.abs(accelerations) / ACCELERATION).max() <= 1.0


def test_it_does_not_stop_at_rounded_corners() -> None:
    path = blended(CORNERS, 0.05)
    places, times = fastest(path, VELOCITY, ACCELERATION)
    speeds = np.diff(places) / np.diff(times)
    assert speeds[10:-10].min() > 0.1


def test_more_room_at_corners_is_faster() -> None:
    slow, fast = (fastest(blended(CORNERS, d), VELOCITY, ACCELERATION)[1][-1] for d in (0.01, 0.1))
    assert fast < slow


def test_places_that_are_asked_for_are_among_the_answers() -> None:
    places, _ = fastest(blended(CORNERS, 0.05), VELOCITY, ACCELERATION, through=[0.777])
    assert np.abs(places - 0.777).min() < 1e-9


def test_a_joint_that_rests_needs_no_limits() -> None:
    path = blended(np.hstack([CORNERS, np.ones((4, 1))]), 0.05)
    _, times = fastest(path, [*VELOCITY, 0.0], [*ACCELERATION, 0.0])
    assert np.isfinite(times).all()
