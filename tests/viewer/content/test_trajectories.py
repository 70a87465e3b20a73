"""Trajectories in the document: few digits, but enough, and those of reports must fit their segments."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import Trajectory
from kabo.viewer.content.trajectories import WITHIN, shown_trajectory, trajectory_of_report

POWERS = st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=6).map(tuple)
ROWS = ((0.0, 0.0), (1.0, 1.0))


@given(
    pieces=st.lists(st.tuples(POWERS, POWERS), min_size=1, max_size=3),
    spans=st.lists(st.floats(0.001, 4.0), min_size=3, max_size=3),
)
def test_what_is_shown_is_as_near_as_promised(pieces: list, spans: list[float]) -> None:
    times = tuple(np.cumsum([0.5, *spans[: len(pieces)]]).tolist())
    own = Trajectory(("a", "b"), ROWS, times, tuple(pieces))
    shown = shown_trajectory(own)
    there = Trajectory(("a", "b"), ROWS, tuple(shown["times"]), tuple(map(tuple, shown["coefficients"])))
    at = np.linspace(times[0], times[-1], 50)
    size = np.abs(own.at(at)).max()
    assert np.abs(own.at(at) - there.at(at)).max() <= WITHIN + 1e-13 * size
    assert WITHIN <= 1e-7


def test_short_pieces_have_fewer_digits() -> None:
    powers = (0.123456789012,) * 6
    shown = shown_trajectory(Trajectory(("a",), ((0.0,), (1.0,)), (0.0, 0.01), ((powers,),)))
    assert shown["coefficients"] == [[[0.12345679, 0.123457, 0.1235, 0.12, 0.0, 0.0]]]


GIVEN = {"times": [0.0, 1.0], "coefficients": [[[0.0, 1.0], [0.0, 1.0]]], "deviation": 0.0}


def test_the_trajectory_of_a_report_is_read() -> None:
    own = trajectory_of_report(("a", "b"), ROWS, (0.0, 1.0), GIVEN)
    assert own is not None and own.at(0.5).tolist() == [0.5, 0.5]
    assert trajectory_of_report(("a", "b"), ROWS, (0.0, 1.0), None) is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"times": [0.0, 2.0]},
        {"times": [0.0]},
        {"times": [0.0, 0.5, 1.0]},
        {"coefficients": []},
        {"coefficients": [[[0.0, 1.0]]]},
        {"coefficients": [[[0.0, 1.0], []]]},
        {"coefficients": [[[0.0, 1.0], [0.0] * 7]]},
    ],
)
def test_a_trajectory_that_does_not_fit_its_segment_is_refused(wrong: dict) -> None:
    with pytest.raises(ValueError, match="does not fit"):
        trajectory_of_report(("a", "b"), ROWS, (0.0, 1.0), GIVEN | wrong)
