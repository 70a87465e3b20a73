"""Ramps and greatest speeds: within the limits for motion that goes evenly between way points, and no slower than that."""

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.motion import from_rest_to_rest, trapezoid

LIMITS = st.lists(st.floats(0.2, 5.0), min_size=2, max_size=2).map(np.array)
POINTS = st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=2).map(np.array)


@given(start=POINTS, end=POINTS, velocity=LIMITS, acceleration=LIMITS)
def test_speeds_and_their_changes_stay_within_the_limits(start, end, velocity, acceleration):
    if np.abs(end - start).max() < 1e-3:
        return
    shares, times = trapezoid(start, end, velocity, acceleration)
    speeds = np.diff(start + shares[:, None] * (end - start), axis=0) / np.diff(times)[:, None]
    assert np.all(np.abs(speeds) <= velocity * (1.0 + 1e-9))
    # Even speeds change at way points: from the middle of one piece to the middle of the next.
    middles = (times[1:] + times[:-1]) / 2
    rates = np.diff(speeds, axis=0) / np.diff(middles)[:, None]
    assert np.all(np.abs(rates) <= acceleration * (1.0 + 1e-6))
    fastest = np.abs(speeds / velocity).max()
    event("reaches the greatest speed" if fastest > 0.999 else "too short for it")
    assert np.isclose(fastest, 1.0) or np.isclose(np.abs(rates / acceleration).max(), 1.0)


def test_a_long_way_takes_its_length_by_speed_and_one_ramp():
    shares, times = trapezoid([0.0], [4.0], [2.0], [4.0])
    assert np.isclose(times[-1], 2.5)
    assert shares[0] == 0.0
    assert shares[-1] == 1.0


def test_a_short_way_never_reaches_the_greatest_speed():
    assert np.isclose(trapezoid([0.0], [1.0], [10.0], [4.0])[1][-1], 1.0)


def test_a_path_rests_at_its_corners_and_its_times_are_whole_microseconds():
    rows, times = from_rest_to_rest([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [1.0, 1.0], [2.0, 2.0])
    assert any(np.array_equal(row, [1.0, 0.0]) for row in rows)
    assert np.array_equal(times, np.round(times, 6))
    assert np.all(np.diff(times) > 0.0)
    assert np.isclose(times[-1], 3.0, atol=1e-4)


def test_what_does_not_move_or_has_no_limit_is_refused():
    with pytest.raises(ValueError, match="length"):
        trapezoid([1.0], [1.0], [1.0], [1.0])
    with pytest.raises(ValueError, match="limits"):
        trapezoid([1.0], [2.0], [0.0], [1.0])
