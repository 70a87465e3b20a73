"""Hulls of points that Qhull finds hard."""

import numpy as np
import pytest
from scipy.spatial import QhullError

from kabo.geometry.bounding.containment import hull_of

# Corners of a part of UR10's forearm: three of them are 2e-11 apart, and merging faces there makes one that is too wide.
NEAR_CORNERS = [
    [0.46398470808144543, 0.226094891246958, 0.11416289785442695],
    [0.30985431870173435, 0.5770345592240511, 0.05776375568194393],
    [0.3081433810810137, 0.560622953145602, 0.05374460112019834],
    [0.3081517586637876, 0.5605887580391611, 0.053746405289538744],
    [0.003485389050037916, 0.3144847605938704, 0.1393126617330121],
    [0.018971601658669787, 0.35643044411188635, 0.13110666464903092],
    [0.04564510476726546, 0.18513253419995152, 0.10283169927301462],
    [0.04564510477237231, 0.18513253422264783, 0.10283169927082639],
    [0.04564510477493234, 0.1851325342392362, 0.1028316992700323],
    [0.12639567022278894, 0.5344857298307081, 0.07593093594172125],
    [0.14629646774262206, 0.5420752493460781, 0.06846468649924979],
]


def test_corners_that_are_hardly_apart_have_a_hull_that_contains_them() -> None:
    points = np.array(NEAR_CORNERS)
    equations = hull_of(points).equations
    assert (points @ equations[:, :3].T + equations[:, 3]).max() < 1e-9


def test_points_in_a_plane_have_no_hull() -> None:
    with pytest.raises(QhullError):
        hull_of(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.3, 0.4, 0.0]]))
