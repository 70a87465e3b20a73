"""Robots from URDF files: trees agree with pinocchio, grippers follow, neighbours are known."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.errors import InputError
from kabo.language.scene_description import (
    GripperDescription,
    PoseDescription,
    RobotDescription,
    SensorDescription,
)
from kabo.scene import Robot, link_pose, link_poses
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.transforms import transform, unflat
from kabo.scene.urdf import load_robot
from tests.support.small_robots import write_arm

GRIPPER = GripperDescription(
    joints=("finger",), open={"finger": 0.04}, closed={"finger": 0.0}, touch_links=("left", "right")
)


def description(folder: Path, **changes: object) -> RobotDescription:
    values = {"gripper": GRIPPER, "tool_frame": "hand", **changes}
    return RobotDescription("r", write_arm(folder), PoseDescription(), **values)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    base = transform((0.3, -0.2, 0.5), (0.0, 0.6, 0.0, 0.8))
    return load_robot(description(tmp_path_factory.mktemp("robot")), base, {})[0]


@given(share=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_the_tree_has_the_poses_that_pinocchio_has(robot: Robot, share: list[float]) -> None:
    tree = robot.tree
    q = tree.lower + np.array(share) * (tree.upper - tree.lower)
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, *tree[:6], world_T)
    for name, pose in link_poses(robot, q).items():
        link = robot.links[name]
        assert unflat(world_T[link.joint]) @ link.joint_T_link == pytest.approx(pose, abs=1e-12), name
        assert (link_pose(robot, tuple(q), name) == pose).all(), name


def test_the_kernel_is_its_own_python_original(robot: Robot) -> None:
    tree, q = robot.tree, np.array([0.3, -0.7, 1.1, 0.02])
    compiled, plain = np.zeros((2, len(tree.parent), 12))
    compiled[0, [0, 4, 8]] = plain[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, *tree[:6], compiled)
    forward_kinematics.py_func(q, *tree[:6], plain)
    assert compiled == pytest.approx(plain, abs=1e-15)


def test_planned_joints_come_first_and_mimic_joints_follow(robot: Robot) -> None:
    assert robot.planned_joints == ("shoulder", "elbow", "turn")
    assert robot.gripper_joints == ("finger",)
    expanded = robot.expand((0.0, 0.0, 0.0, 0.03))
    assert expanded[-2:] == pytest.approx([0.03, 0.061])


def test_limits_of_the_scene_narrow_those_of_the_urdf(tmp_path: Path) -> None:
    limits = {"shoulder": (-3.0, 1.0), "turn": (-1.5, 1.5)}
    tree = load_robot(description(tmp_path, limits=limits), np.eye(4), {})[0].tree
    assert tree.lower.tolist() == [-2.0, -2.5, -1.5, 0.0]
    assert tree.upper.tolist() == [1.0, 2.5, 1.5, 0.04]


def test_limits_of_an_unknown_joint_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='unknown joint "sholder" in the limits'):
        load_robot(description(tmp_path, limits={"sholder": (0.0, 1.0)}), np.eye(4), {})


def test_a_joint_that_is_not_planned_stands_still(tmp_path: Path) -> None:
    robot = load_robot(description(tmp_path, joints=("shoulder",)), np.eye(4), {})[0]
    assert robot.joint_names == ("shoulder", "finger")
    assert np.linalg.norm(link_poses(robot, (0.5, 0.0))["hand"][:3, 3]) == pytest.approx(
        np.linalg.norm(link_poses(robot, (0.5, 0.04))["hand"][:3, 3])
    )
    assert robot.neighbours("base", "hand"), "what stands between them does not move"


def test_neighbours_hang_on_one_moving_joint_or_on_a_joint_and_its_parent(robot: Robot) -> None:
    assert robot.neighbours("base", "upper")
    assert robot.neighbours("lower", "hand")
    assert not robot.neighbours("base", "lower")
    assert not robot.neighbours("left", "right")


def test_only_what_no_moving_joint_carries_stands(robot: Robot) -> None:
    """Regression: the first moving link once counted as fixed, and was not checked against what stands around."""
    assert [name for name in robot.links if robot.stands(name)] == ["base"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tool_frame": "hnad"}, 'unknown link "hnad" as tool frame'),
        ({"joints": ("sholder",)}, 'unknown joint "sholder"'),
        ({"configurations": {"home": (0.0,)}}, 'configuration "home" has 1 value,'),
        ({"configurations": {"home": (0.0, 3.0, 0.0)}}, "elbow = 3 is outside its limits"),
        ({"gripper": GripperDescription(joints=("finger",), open={"fingr": 0.1})}, 'unknown joint "fingr"'),
        ({"gripper": GripperDescription(joints=("finger",), touch_links=("lft",))}, 'unknown link "lft"'),
        ({"gripper": GripperDescription(joints=("finger",), touch_links=("jaw_1",))}, "there are base, "),
        (
            {"sensors": {"eye": SensorDescription("eye", "hnd", (1.0,), (0.1, 1.0))}},
            'unknown link "hnd" of robot "r", in its sensor "eye"',
        ),
        (
            {"sensors": {"eye": SensorDescription("eye", "hand", (1.0,), (0.1, 1.0), allowed=("lft",))}},
            'unknown link "lft" of robot "r", in its sensor "eye"',
        ),
    ],
)
def test_what_the_urdf_does_not_have_is_refused_by_name(
    tmp_path: Path, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        load_robot(description(tmp_path, **changes), np.eye(4), {})


@pytest.mark.parametrize(
    "text", ["", "<robot", "<sdf/>", '<robot name="x"><link name="a"><collision/></link></robot>']
)
def test_a_file_that_is_no_robot_is_one_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.urdf"
    path.write_text(text)
    with pytest.raises(InputError, match="broken.urdf"):
        load_robot(RobotDescription("r", path, PoseDescription()), np.eye(4), {})
