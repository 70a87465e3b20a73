"""Tests of the limits of a motion."""

import numpy as np
import pytest

from kabo.motion import MotionLimits


def test_limits_of_groups_of_joints_are_joined_and_chosen():
    both = MotionLimits.of([1.0], [2.0], [3.0]) + MotionLimits.of([4.0], [5.0], [6.0])
    assert np.array_equal(np.stack(both.rows), [[1, 4], [2, 5], [3, 6]])
    assert np.array_equal(np.stack(both.chosen([False, True]).rows), [[4], [5], [6]])


def test_a_share_of_the_limits_stretches_time():
    half = MotionLimits.of([1.0], [1.0], [1.0]).scaled(0.5)
    assert [float(row[0]) for row in half.rows] == [0.5, 0.25, 0.125]


@pytest.mark.parametrize(
    ("rows", "words"), [(([1.0], [1.0, 2.0], [1.0]), "shape"), (([1.0], [-1.0], [1.0]), "negative")]
)
def test_limits_that_cannot_be_are_refused(rows, words):
    with pytest.raises(ValueError, match=words):
        MotionLimits.of(*rows)
