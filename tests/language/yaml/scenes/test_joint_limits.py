"""Limits of joints in a robot's entry: numbers for all joints, mappings, and the long form of `limits`."""

import math

import pytest

from kabo.language import load_problem
from kabo.language.scene_description import RobotDescription
from tests.language.conftest import SCENE, Kitchen

URDF = "    urdf: arm.urdf\n"
WRONG_LIMITS = [
    ("acceleration: «0»", "the acceleration of a robot is not above 0", None),
    ("velocity: «1e-32»", "the velocity of a robot is not from 1e-06 to 100000: 1e-32", None),
    ("jerk: {a: 4, b: «1e300»}", 'the jerk of "b" is not from 1e-06 to 100000: 1e+300', None),
    ("jerk: {a: 4, b: «-1»}", 'the jerk of "b" is not above 0', None),
    ("velocity: «[1, 2]»", "`velocity` is a number for all joints, or a mapping of joints to numbers",
     "write velocity: {joint: number}"),
    ("velocity: «fast»", 'the velocity of a robot must be a number, this is "fast"', None),
    ("velocity: {a: «90 deg/s»}", 'the velocity of "a" must be a number, this is "90 deg/s"',
     "units are rad, m and s: write 90 deg"),
    ("acceleration: «0.2 m/s^2»", 'the acceleration of a robot must be a number, this is "0.2 m/s^2"',
     "units are rad, m and s: write 0.2"),
    ("acceleration: {a: «200 mm/s²»}", 'the acceleration of "a" must be a number, this is "200 mm/s²"',
     "units are rad, m and s: write 0.2"),
    ("acceleration: {a: «[1]»}", 'the acceleration of "a" must be a number, this is a list', None),
    ("acceleration: {a: «{b: 1}»}", 'the acceleration of "a" must be a number, this is a mapping', None),
    ("limits: {a: «[10 deg, -10 deg]»}", 'the limits of "a" are crossed', "the lower one comes first"),
    ("limits: {a: {position: «[1, -1]»}}", 'the limits of "a" are crossed', "the lower one comes first"),
    ("limits: {a: {position: «3»}}", 'the limits of "a" must be a list of 2 numbers: [0, 0]', None),
    ("limits: {a: {«velocty»: 3}}", 'unknown key "velocty" of the limits of "a"', 'did you mean "velocity"?'),
    ("limits: {a: {velocity: «0»}}", 'the velocity of "a" is not above 0', None),
    ("jerk: {a: 3}\n    limits: {a: {«jerk»: 3}}", 'the jerk of "a" is given twice',
     "write it in `jerk` or in `limits`, not in both"),
    ("«accelerations»: 3", 'unknown key "accelerations" of a robot model', 'did you mean "acceleration"?'),
]  # fmt: skip
WRONG_GRIPPERS = [
    ("force: «0»", "the force of a gripper must be greater than 0", None),
    ("force: «40 N»", 'the force of a gripper must be a number, this is "40 N"', None),
    ("force: 40, friction: «-0.1»", "the friction of a gripper must be greater than 0", None),
    ("«friction»: 0.5", "`friction` counts only beside `force`",
     "write the force with which the gripper holds, in N: without it nothing slips"),
    ("«forse»: 40", 'unknown key "forse" of a gripper', 'did you mean "force"?'),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message", "hint"), WRONG_LIMITS, ids=[row[0] for row in WRONG_LIMITS])
def test_wrong_limits_are_reported_at_their_place(
    kitchen: Kitchen, given: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", URDF, f"{URDF}    {given}\n", message, hint)


@pytest.mark.parametrize(("given", "message", "hint"), WRONG_GRIPPERS, ids=[row[0] for row in WRONG_GRIPPERS])
def test_a_wrong_force_is_reported_at_its_place(
    kitchen: Kitchen, given: str, message: str, hint: str | None
) -> None:
    lines = "".join(f"      {each}\n" for each in given.split(", "))
    kitchen.expect("scene", "      mount: tool0\n", f"      mount: tool0\n{lines}", message, hint)


def robot(kitchen: Kitchen, *lines: str) -> RobotDescription:
    text = SCENE.replace(URDF, URDF + "".join(f"    {line}\n" for line in lines))
    scene = load_problem(kitchen.write(scene=text)).scene
    assert scene is not None
    return scene.robots["left"]


def test_a_number_is_for_every_joint_and_a_mapping_for_some(kitchen: Kitchen) -> None:
    found = robot(kitchen, "velocity: 0.5", "acceleration: {a: 2, b: 90 deg}")
    assert found.velocity.every is not None and found.velocity.every.value == 0.5
    assert found.velocity.joints == {}
    assert found.acceleration.every is None
    assert {name: limit.value for name, limit in found.acceleration.joints.items()} == {"a": 2.0, "b": math.pi / 2}
    assert found.jerk.every is None and found.jerk.joints == {}


def test_the_long_form_of_limits_says_the_same_as_the_keys(kitchen: Kitchen) -> None:
    long = robot(
        kitchen,
        "velocity: 0.5",
        "limits: {a: {position: [-1, 1], velocity: 0.4, acceleration: 2, jerk: 30}, b: {jerk: 40}, c: [0, 90 deg]}",
    )
    short = robot(
        kitchen,
        "velocity: 0.5",
        "acceleration: {a: 2}",
        "jerk: {a: 30, b: 40}",
        "limits: {a: {position: [-1, 1], velocity: 0.4}, c: [0, 90 deg]}",
    )
    assert long == short
    assert long.limits == {"a": (-1.0, 1.0), "c": (0.0, math.pi / 2)}
    assert long.velocity.joints["a"].value == 0.4
    assert long.velocity.every is not None


def test_each_limit_remembers_where_it_is_written(kitchen: Kitchen) -> None:
    place = robot(kitchen, "velocity: {a: 1, elbow: 2}").velocity.joints["elbow"].place
    assert place is not None and (place.column, place.length) == (22, 5)


def test_a_gripper_has_a_force_and_a_friction(kitchen: Kitchen) -> None:
    for lines, force, friction in (("", None, 0.5), ("      force: 40\n", 40.0, 0.5)):
        text = SCENE.replace("      mount: tool0\n", f"      mount: tool0\n{lines}")
        scene = load_problem(kitchen.write(scene=text)).scene
        assert scene is not None
        gripper = scene.robots["left"].gripper
        assert gripper is not None and (gripper.force, gripper.friction) == (force, friction)
