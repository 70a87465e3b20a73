"""Times: strictly increasing whole microseconds, within velocity limits; the law is in tests/properties."""

import numpy as np
import pytest

from kabo.motion import retime


def test_the_slowest_joint_sets_the_pace():
    times = retime([[0.0, 0.0], [1.0, 0.1], [1.0, 0.6]], [2.0, 0.5])
    assert np.array_equal(times, [0.0, 0.5, 1.5])


def test_a_factor_slows_everything_down():
    assert np.array_equal(retime([[0.0], [1.0]], [2.0], factor=0.5), [0.0, 1.0])


def test_standing_still_takes_a_microsecond():
    assert np.array_equal(retime([[1.0], [1.0], [1.0]], [1.0]), [0.0, 1e-6, 2e-6])
    assert np.array_equal(retime([[1.0]], [1.0]), [0.0])


def test_a_joint_that_moves_needs_a_velocity_limit():
    assert len(retime([[0.0, 1.0], [1.0, 1.0]], [1.0, 0.0])) == 2
    with pytest.raises(ValueError, match="positive velocity limits"):
        retime([[0.0, 1.0], [1.0, 2.0]], [1.0, 0.0])
    with pytest.raises(ValueError, match="do not fit"):
        retime([[0.0, 1.0]], [1.0])
