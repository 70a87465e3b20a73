"""What a hand is said to be at, of measured values: within what it opens and closes, and ajar where its fingers meet."""

from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.execution.interruptions import hand_within_limits
from kabo.scene import Robot

DOMAINS = Path(__file__).parents[2] / "domains"


@pytest.fixture(scope="module")
def robot() -> Robot:
    """One finger joint, from 0 to 45 mm."""
    scene = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml").scene
    assert scene is not None
    return kabo.load_scene(scene).robots["mobile"]


def with_gripper(robot: Robot, opened: float, closed: float) -> Robot:
    assert robot.gripper is not None
    joint = robot.gripper_joints[0]
    return replace(robot, gripper=replace(robot.gripper, open={joint: opened}, closed={joint: closed}))


@pytest.mark.parametrize(
    ("opened", "closed", "measured", "said"),
    [
        (0.045, 0.0, 0.045, 0.045),  # open, at its stop
        (0.045, 0.0, 0.0452, 0.045),  # the stop gives way
        (0.03, 0.0, 0.0301, 0.03),  # open, before its stop
        (0.03, 0.0, 0.037, 0.037),  # opened farther
        (0.04, 0.0, 0.02, 0.02),
        (0.04, 0.0, 0.0, 0.0009),  # fingers that touch prove nothing
        (0.045, 0.045, 0.0449, 0.045),  # a joint that no grasp moves
        (0.02, 0.02, 0.0201, 0.02),
    ],
)
def test_an_open_hand_is_open_and_closed_fingers_are_ajar(
    robot: Robot, opened: float, closed: float, measured: float, said: float
) -> None:
    found = hand_within_limits(with_gripper(robot, opened, closed), [measured])
    assert list(found.values()) == pytest.approx([said], abs=1e-12)
