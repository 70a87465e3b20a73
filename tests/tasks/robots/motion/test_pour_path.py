"""The path of a lid."""

import numpy as np
import pytest

from kabo.tasks.robots.motion.pour_path import METRES_PER_RADIAN, PourPath

START, POURING = (0.1, 0.5, 0.0), (0.4, 0.3, 2.0)


@pytest.mark.parametrize("overshoot", [0.0, 0.8])
@pytest.mark.parametrize("t", [0.0, 0.01, 0.3, 1.0])
def test_it_is_the_path_of_the_thesis(t: float, overshoot: float) -> None:
    x = 0.1 + (t**0.2 + (1 - t) * t * overshoot) * 0.3
    found = PourPath(START, POURING, overshoot).at(t)
    assert found == pytest.approx([x, 0.5 - 0.2 * t * t, 2.0 * t])


def test_at_a_hundredth_of_the_parameter_it_is_two_fifths_across() -> None:
    assert PourPath(START, POURING).at(0.01)[0] == pytest.approx(0.1 + 0.3 * 0.398, abs=1e-3)


@pytest.mark.parametrize("overshoot", [0.0, 0.8])
def test_poses_are_equally_far_apart_along_the_path(overshoot: float) -> None:
    poses = PourPath(START, POURING, overshoot).by_length(0.02)
    gaps = np.linalg.norm(np.diff(poses, axis=0) * (1.0, 1.0, METRES_PER_RADIAN), axis=1)
    assert gaps.max() <= 0.02 + 1e-9
    assert gaps.min() >= 0.98 * gaps.max()


def test_it_begins_and_ends_exactly() -> None:
    poses = PourPath(START, POURING, 0.3).by_length(0.02)
    assert tuple(poses[0]) == START
    assert tuple(poses[-1]) == POURING


def test_overshooting_goes_farther_to_the_side_than_where_it_pours() -> None:
    assert PourPath(START, POURING, 1.5).at(np.linspace(0, 1, 50))[:, 0].max() > POURING[0] + 0.02
