import numpy as np
import pytest

from kabo.tasks.robots.stages.poses import local_pose


def test_a_pose_is_a_rigid_motion_by_quaternion_or_by_angles():
    half = np.sqrt(0.5)
    turned = local_pose({"position": [1, 2, 3], "quaternion": [0, 0, half, half]})
    assert np.allclose(turned, local_pose({"position": [1, 2, 3], "rpy": [0, 0, np.pi / 2]}), atol=1e-12)
    assert np.allclose(turned[:3, :3] @ turned[:3, :3].T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    "given, said",
    [
        ({"position": [0.4, 0.0]}, "position: three finite numbers"),
        ({"position": [0.4, 0.0, float("nan")]}, "position: three finite numbers"),
        ({"quaternion": [0, 0, 1]}, "quaternion: four finite numbers"),
        ({"quaternion": [0, 0, 1, 1]}, "a quaternion has length 1"),
        ({"rpy": "up"}, "rpy: three finite numbers"),
        ({"quaternion": [0, 0, 0, 1], "rpy": [0, 0, 0]}, "not both"),
        ({"positon": [0, 0, 0]}, "did you mean 'position'"),
    ],
)
def test_what_is_no_pose_is_refused_with_what_is_wanted(given, said):
    with pytest.raises(ValueError, match=said):
        local_pose(given)
