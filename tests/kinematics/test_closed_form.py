"""Inverse kinematics of the robots that come with kabo: all branches, limits, singular poses, out of reach [K A.3]."""

import math
from pathlib import Path

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.kinematics import OutOfReach, Reached, solutions
from kabo.kinematics.closed_form import branches, end_poses, with_the_same_pose
from kabo.language.formulas import Place
from kabo.language.recorded_paths import installed_folder
from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.scene import NoStructure, Robot, Structure, link_pose
from kabo.scene.transforms import transform
from kabo.scene.urdf import load_robot
from kabo.streams import stream_key

MESHES = Path(__file__).resolve().parent.parent.parent / "meshes"
FIVE = tuple(f"arm_joint_{k}" for k in range(1, 6))
PUBLIC = installed_folder("example-robot-data")
KEY = stream_key("test", 7)
BASE = transform((0.3, -0.2, 0.1), (0.0, 0.0, math.sin(0.35), math.cos(0.35)))


def load(name: str, **changes: object) -> Robot:
    """A robot of kabo's meshes, turned and moved, with the tool at its flange."""
    values = {"tool_frame": "gripper_base" if name == "mobile5" else "tool0", **changes}
    described = RobotDescription("r", MESHES / name / f"{name}.urdf", PoseDescription(), **values)  # type: ignore[arg-type]
    return load_robot(described, BASE, {})[0]


@pytest.fixture(scope="module")
def arm6() -> Robot:
    return load("arm6")


@pytest.fixture(scope="module")
def mobile5() -> Robot:
    return load("mobile5", joints=FIVE)


@pytest.fixture(scope="module")
def arm7() -> Robot:
    return load("arm7")


def tool_pose(robot: Robot, q: object) -> np.ndarray:
    """Where the tool is, by pinocchio."""
    values = np.zeros(robot.tree.size)
    values[: robot.planned] = np.asarray(q)[: robot.planned]
    assert robot.tool is not None
    return link_pose(robot, values, robot.tool.frame)


def reached(robot: Robot, pose: np.ndarray, number: int = 1) -> Reached:
    """The solutions, each of which pinocchio puts at the pose."""
    found = solutions(robot, pose, KEY, number)
    assert isinstance(found, Reached), str(found)
    for q in found.configurations:
        assert np.abs(tool_pose(robot, q) - pose).max() < 2e-9
        assert np.all((robot.tree.lower <= q) & (q <= robot.tree.upper))
    return found


def test_six_axes_reach_a_pose_by_shoulder_elbow_and_wrist_in_eight_ways(arm6: Robot) -> None:
    wide = load("arm6")
    tree = wide.tree._replace(lower=np.full(6, -np.pi), upper=np.full(6, np.pi))
    q = np.radians([20.0, -30.0, 100.0, 40.0, 50.0, -60.0])
    known = wide.structure
    assert isinstance(known, Structure)
    every, _ = with_the_same_pose(tree, known, q)
    assert len(every) == 8 and np.abs(every - q).max(axis=1).min() < 1e-9
    assert len({(round(b[0], 6), round(b[2], 6), b[4] > 0) for b in every}) == 8
    within = reached(arm6, tool_pose(arm6, q)).configurations
    inside = [b for b in every if np.all((arm6.tree.lower <= b) & (b <= arm6.tree.upper))]
    assert len(inside) >= 2 and all(np.abs(within - b).max(axis=1).min() < 1e-9 for b in inside)


def test_axes_that_turn_further_than_once_give_the_whole_turns_too(arm6: Robot) -> None:
    """Axes 4 and 6 turn by 270 degrees to either side."""
    q = np.radians([20.0, -30.0, 100.0, 120.0, 50.0, -160.0])
    found = reached(arm6, tool_pose(arm6, q)).configurations
    for fourth in (120.0, -240.0):
        for sixth in (-160.0, 200.0):
            wanted = np.radians([20.0, -30.0, 100.0, fourth, 50.0, sixth])
            assert np.abs(found - wanted).max(axis=1).min() < 1e-9


def test_an_aligned_wrist_is_said_and_one_of_its_family_given(arm6: Robot) -> None:
    q = np.radians([20.0, -30.0, 100.0, 40.0, 0.0, -60.0])
    found = reached(arm6, tool_pose(arm6, q))
    aligned = [i for i, words in enumerate(found.singular) if "wrist aligned" in words]
    assert aligned and all(abs(found.configurations[i, 4]) < 1e-7 for i in aligned)


def test_straight_up_the_wrist_lies_on_the_first_axis_but_for_its_offset(arm6: Robot) -> None:
    """The flange looks up from above the first axis: aligned, and the arm's offset to the side leaves two ways."""
    found = reached(arm6, tool_pose(arm6, np.zeros(6)))
    assert any(np.allclose(q, 0.0, atol=1e-6) or "wrist aligned" in m for q, m in zip(*_parts(found), strict=True))


def _parts(found: Reached) -> tuple[np.ndarray, tuple[tuple[str, ...], ...]]:
    return found.configurations, found.singular


def test_a_wrist_on_the_first_axis_is_said(mobile5: Robot) -> None:
    """The upper arm leans back until the hand, which looks up, is above the turret."""
    shoulder = -math.asin(0.03 / 0.26)
    q = np.array([0.4, shoulder, -shoulder, 0.0, 0.3])
    found = reached(mobile5, tool_pose(mobile5, q))
    assert any("on the first axis" in words for words in found.singular)


def test_five_axes_reach_position_pitch_and_roll(mobile5: Robot) -> None:
    """As [K A.3] states it: the pose with the last axis in the plane of the arm, at a pitch, and rolled."""
    first, hand = BASE @ transform((0.12, 0.0, 0.24)), np.array([0.42, 0.15, 0.1])
    yaw = math.atan2(hand[1], hand[0])
    for pitch in (1.5, 2.4, math.pi):
        for roll in (-1.0, 0.2, 2.5):
            frame = first @ transform(tuple(hand)) @ _turn(2, yaw) @ _turn(1, pitch) @ _turn(2, roll)
            found = reached(mobile5, frame).configurations
            sums = found[:, 1:4].sum(axis=1)
            front = np.abs(np.angle(np.exp(1j * (found[:, 0] - yaw)))) < 1e-9
            assert np.any(front)
            assert np.allclose(np.angle(np.exp(1j * (sums[front] - pitch))), 0.0, atol=1e-9)
            assert np.allclose(np.angle(np.exp(1j * (found[front, 4] - roll))), 0.0, atol=1e-7)


def _turn(axis: int, angle: float) -> np.ndarray:
    quaternion = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    quaternion[axis] = math.sin(angle / 2)
    return transform((0.0, 0.0, 0.0), tuple(quaternion))  # type: ignore[arg-type]


def test_what_five_axes_cannot_turn_is_told_as_a_tilt(mobile5: Robot) -> None:
    q = np.array([0.3, 0.5, 0.6, 0.4, 0.2])
    answer = solutions(mobile5, tool_pose(mobile5, q) @ _turn(0, 0.05), KEY, 1)
    assert isinstance(answer, OutOfReach) and 0.01 < answer.tilt < 0.06
    assert "tilted by" in str(answer)


def test_out_of_reach_says_by_how_much(arm6: Robot) -> None:
    q = np.radians([20.0, 60.0, 0.0, 0.0, 20.0, 0.0])  # upper arm and forearm in line
    pose = tool_pose(arm6, q)
    wrist = pose[:3, 3] - 0.1 * pose[:3, 2]
    shoulder = link_pose(arm6, q, "link_2")[:3, 3]
    pose[:3, 3] += 0.12 * (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    answer = solutions(arm6, pose, KEY, 1)
    assert isinstance(answer, OutOfReach) and answer.missing == pytest.approx(0.12, abs=0.005)
    assert str(answer) == f"{answer.missing:.3f} m out of reach"


def test_a_limit_that_is_in_the_way_is_named(arm6: Robot) -> None:
    limits = {"joint_5": (math.radians(10.0), math.radians(20.0)), "joint_1": (0.3, 0.4), "joint_4": (-0.5, 0.5)}
    narrow = load("arm6", limits=limits)
    q = np.radians([20.0, -30.0, 100.0, 20.0, 25.0, -60.0])
    answer = solutions(narrow, tool_pose(narrow, q), KEY, 1)
    assert isinstance(answer, OutOfReach)
    assert answer.joint == 4 and answer.beyond == pytest.approx(math.radians(5.0), abs=1e-9)
    assert str(answer) == "beyond the limits of joint 5 by 5.00 deg"
    assert isinstance(solutions(arm6, tool_pose(arm6, q), KEY, 1), Reached)


def test_seven_axes_are_sampled_along_their_redundancy(arm7: Robot) -> None:
    q = np.array([0.4, 0.7, -0.3, -1.2, 0.5, 0.9, 0.2])
    structure = arm7.structure
    assert isinstance(structure, Structure) and structure.lock == 2
    found = reached(arm7, tool_pose(arm7, q), 40).configurations
    held = np.unique(np.round(found[:, 2], 9))
    assert 10 < len(held) <= 40 and np.ptp(held) > 3.0
    again = solutions(arm7, tool_pose(arm7, q), KEY, 40)
    assert isinstance(again, Reached) and again.configurations.tobytes() == found.tobytes()
    other = solutions(arm7, tool_pose(arm7, q), stream_key("other"), 40)
    assert isinstance(other, Reached) and other.configurations.tobytes() != found.tobytes()


def test_robots_without_a_structure_are_projected_from_many_seeds() -> None:
    """Platform and arm: eight joints, of which two slide."""
    robot = load("mobile5", joints=("base_x", "base_y", "base_yaw", *FIVE))
    assert isinstance(robot.structure, NoStructure) and "slides" in robot.structure.reason
    q = np.array([0.5, -0.3, 0.4, 0.3, 0.5, 0.6, 0.4, 0.2])
    found = solutions(robot, tool_pose(robot, q), KEY, 30)
    assert isinstance(found, Reached) and len(found.configurations) > 5
    for each in found.configurations:
        assert np.abs(tool_pose(robot, each) - tool_pose(robot, q)).max() < 1e-5


def test_analytic_is_refused_at_its_place_where_the_axes_do_not_allow_it() -> None:
    with pytest.raises(InputError) as caught:
        joints = ("base_x", "base_y", "base_yaw", *FIVE)
        load("mobile5", joints=joints, inverse_kinematics="analytic", analytic=Place("scene.yaml", 7, 25))
    (finding,) = caught.value.diagnostics
    assert (finding.line, finding.column) == (7, 25)
    assert finding.message.startswith(
        'no closed form (`analytic`) of the inverse kinematics of "r" is known: a planned'
    )
    assert finding.hint == "write `projection`, or leave the key out"
    assert load("mobile5", joints=FIVE, inverse_kinematics="analytic").inverse_kinematics == "analytic"


@pytest.mark.parametrize(
    "pose", [np.full((4, 4), np.nan), np.eye(3), np.diag([1.0, 1.0, -1.0, 1.0]), np.diag([1.1, 1.0, 1.0, 1.0])]
)
def test_what_is_no_pose_is_refused(arm6: Robot, pose: np.ndarray) -> None:
    with pytest.raises(ValueError, match="pose"):
        solutions(arm6, pose, KEY, 1)


def test_rounding_of_a_pose_is_put_right(arm6: Robot) -> None:
    q = np.radians([20.0, -30.0, 100.0, 40.0, 50.0, -60.0])
    found = solutions(arm6, np.round(tool_pose(arm6, q), 8), KEY, 1)
    assert isinstance(found, Reached) and np.abs(found.configurations - q).max(axis=1).min() < 1e-6


def test_the_kernel_is_its_own_python_original(arm6: Robot, mobile5: Robot, arm7: Robot) -> None:
    from kabo.kinematics.closed_form import chain_of
    from kabo.kinematics.kernels import closed_form as kernels

    for robot in (arm6, mobile5, arm7):
        known, tree = robot.structure, robot.tree
        assert isinstance(known, Structure)
        q = np.zeros(tree.size)
        q[: robot.planned] = np.linspace(0.2, 0.9, robot.planned)
        made = branches(tree, known, end_poses(tree, known, q), q, q[[2]])
        found, counts, free = np.empty((1, 8, tree.size)), np.zeros(1, np.int64), np.zeros((1, 8), np.int64)
        answers = kernels.Answers(found, counts, free, np.empty((1, 4)))
        kernels.solve_poses.py_func(end_poses(tree, known, q), q[[2]], q, chain_of(known), tree, answers)
        assert counts[0] == made.counts[0] > 0
        assert found[0, : counts[0]] == pytest.approx(made.configurations[0, : counts[0]], abs=1e-9)


@pytest.mark.skipif(PUBLIC is None, reason="the extra `robots` is not installed")
@pytest.mark.parametrize(
    ("name", "joints", "lock"),
    [
        ("ur_description/urdf/ur3_robot.urdf", None, -1),
        ("ur_description/urdf/ur5_robot.urdf", None, -1),
        ("panda_description/urdf/panda.urdf", tuple(f"panda_joint{k}" for k in range(1, 8)), 6),
    ],
)
def test_arms_of_public_packages_are_known_by_their_axes(
    name: str, joints: tuple[str, ...] | None, lock: int
) -> None:
    assert PUBLIC is not None
    described = RobotDescription("r", PUBLIC / "robots" / name, PoseDescription(), joints)
    robot = load_robot(described, BASE, {"example-robot-data": PUBLIC})[0]
    known, rng = robot.structure, np.random.default_rng(1)
    assert isinstance(known, Structure) and known.lock == lock
    Q = np.tile(robot.tree.lower, (200, 1))
    Q[:, : robot.planned] = rng.uniform(robot.tree.lower, robot.tree.upper, Q.shape)[:, : robot.planned]
    found, owner = with_the_same_pose(robot.tree, known, Q)
    for i, q in enumerate(Q):
        apart = np.abs((found[owner == i] - q + np.pi) % (2 * np.pi) - np.pi)
        assert apart.max(axis=1).min() < 1e-6
