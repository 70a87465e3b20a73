"""The seconds that motion is expected to have: exact for a straight way, in order of what joints must do for others."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from kabo.motion import MotionLimits, timed_path
from kabo.plan import Segment
from kabo.planner.refine import estimating
from kabo.planner.refine.estimating import estimated_seconds

LIMITS = MotionLimits.of([1.0, 4.0], [4.0, 16.0], [80.0, 320.0])
ROBOTS = {"r": SimpleNamespace()}


@pytest.fixture(autouse=True)
def known_limits(monkeypatch):
    """Limits of two joints, of which the second is four times as fast."""
    monkeypatch.setattr(estimating, "motion_limits", lambda robot, joints: LIMITS)


def moved(*way, **events) -> Segment:
    rows = tuple(map(tuple, np.array(way, float).tolist()))
    return Segment("r", ("a", "b"), rows, tuple(map(float, range(len(rows)))), "go", **events)


def seconds(*motion) -> float:
    return estimated_seconds(ROBOTS, motion)  # type: ignore[arg-type]


def test_a_straight_way_is_expected_to_last_as_long_as_it_does():
    exact = timed_path(np.array([[0.0, 0.0], [1.0, 0.5]]), LIMITS).duration
    assert seconds(moved((0, 0), (1, 0.5))) == pytest.approx(exact, abs=1e-5)


def test_a_longer_path_of_a_fast_joint_is_expected_to_be_faster():
    slow, fast = moved((0, 0), (1, 0)), moved((0, 0), (0, 2))
    assert seconds(fast) < seconds(slow)


def test_a_way_that_winds_is_expected_to_last_longer():
    assert seconds(moved((0, 0), (0.5, 0.5), (1, 0))) > seconds(moved((0, 0), (1, 0)))


def test_motion_stops_where_something_is_taken():
    first, second = moved((0, 0), (1, 0)), moved((1, 0), (2, 0))
    taking = replace(first, attach=(("cup", "r.hand"),))
    assert seconds(taking, second) == pytest.approx(seconds(first) + seconds(second))
    assert seconds(first, second) < seconds(taking, second)


def test_no_motion_is_expected_to_take_no_time():
    assert seconds() == 0.0
    assert seconds(moved((1, 1), (1, 1))) == 0.0
