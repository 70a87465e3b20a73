"""Tests of the trajectory as data."""

import numpy as np

from kabo.motion import Trajectory


def test_a_linear_trajectory_passes_its_way_points_at_their_times():
    made = Trajectory.linear(("a", "b"), [(0.0, 1.0), (0.5, 1.0), (0.5, -1.0)], (0.0, 1.0, 3.0))
    assert np.allclose(
        made.at([0.0, 0.5, 1.0, 2.0, 3.0, 9.0]), [(0, 1), (0.25, 1), (0.5, 1), (0.5, 0), (0.5, -1), (0.5, -1)]
    )
    assert np.allclose(made.at([0.5, 2.0, 9.0], 1), [(0.5, 0), (0, -1), (0, 0)])
    assert made.duration == 3.0
