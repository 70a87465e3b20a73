"""Robots: URDF, joints, gripper, tool, configurations."""

import math

import pytest

from kabo.language import check_files, load_problem
from tests.language.conftest import SCENE, Kitchen

WRONG_SENSORS = [
    ("{eye: «{field_of_view: 1, range: [0.1, 1]}»}", 'a sensor needs the key "frame"', None),
    ("{eye: «{frame: a, range: [0.1, 1]}»}", 'a sensor needs the key "field_of_view"', None),
    ("{eye: «{frame: a, field_of_view: 1}»}", 'a sensor needs the key "range"', None),
    (
        "{eye: {frame: a, field_of_view: «60», range: [0.1, 1]}}",
        "`field_of_view` lies between 0 and 180 deg, this is 3437.75 deg",
        "angles are radians: write 60 deg",
    ),
    (
        "{eye: {frame: a, field_of_view: «-60 deg», range: [0.1, 1]}}",
        "`field_of_view` must be greater than 0",
        None,
    ),
    (
        "{eye: {frame: a, field_of_view: {horizontal: 60 deg, «vertcal»: 1, vertical: 1}, range: [0.1, 1]}}",
        'unknown key "vertcal" of a field of view',
        'did you mean "vertical"?',
    ),
    (
        "{eye: {frame: a, field_of_view: 60 deg, range: «[1.5, 0.1]»}}",
        "`range` is [least, greatest] distance of what is seen, above 0 m and at most 1000 m",
        "write [0.1, 1.5]",
    ),
    ("{eye: {frame: a, field_of_view: 1, range: «0.5»}}", "`range` must be a list of 2 numbers: [0, 0]", None),
    (
        "{eye: {frame: a, field_of_view: 1, range: [0.1, 1], pose: {«frame»: b}}}",
        'unknown key "frame" of the pose of a sensor in its frame',
        "there are position, quaternion, rpy",
    ),
    (
        "{eye: {frame: a, field_of_view: 1, range: [0.1, 1], «fov»: 1}}",
        'unknown key "fov" of a sensor',
        "there are frame, pose, field_of_view, range, allowed",
    ),
    (
        "{«Eye»: {frame: a, field_of_view: 1, range: [0.1, 1]}}",
        '"Eye" cannot be the name of a sensor',
        'write "eye": names match [a-z][a-z0-9_]*',
    ),
]
WRONG_ROBOTS = [
    ("urdf: arm.urdf", "urdf: «armm.urdf»", 'URDF "armm.urdf": there is no such file', 'did you mean "arm.urdf"?'),
    (
        "urdf: arm.urdf",
        "urdf: «package://meshes/arm.urdf»",
        'unknown package "meshes"',
        "declare it: packages: {meshes: folder}",
    ),
    (
        "    urdf: arm.urdf\n",
        "    urdf: arm.urdf\n    inverse_kinematics: «fast»\n",
        '`inverse_kinematics` must be one of projection, analytic, not "fast"',
        "there are projection, analytic",
    ),
    (
        "    urdf: arm.urdf\n",
        "    urdf: arm.urdf\n    joints: [a, b, c, «a»]\n",
        '"a" stands twice in the list',
        None,
    ),
    (
        "    urdf: arm.urdf\n",
        "    urdf: arm.urdf\n    «joint»: [a, b]\n",
        'unknown key "joint" of a robot model',
        'did you mean "joints"?',
    ),
    (
        "    urdf: arm.urdf\n",
        "    urdf: arm.urdf\n    limits: {a: «[10 deg, -10 deg]»}\n",
        'the limits of "a" are crossed',
        "the lower one comes first",
    ),
    (
        "    urdf: arm.urdf\n",
        "    urdf: arm.urdf\n    acceleration: {a: 4, b: «0»}\n",
        'the acceleration of "b" is not above 0',
        None,
    ),
    (
        "      home: [0, -90 deg, 0.5]",
        "      home: [0, -90 deg, 0.5]\n      weigh: «[0, 1]»",
        'the configuration "weigh" must have 3 numbers, not 2',
        None,
    ),
    (
        "      home: [0, -90 deg, 0.5]",
        "      home: «[0, 1]»\n    joints: [a, b, c]",
        'the configuration "home" must have 3 numbers, not 2',
        "one for each of `joints`, in their order: a, b, c",
    ),
    (
        "      home: [0, -90 deg, 0.5]",
        "      home: [0, «90°», 0.5]",
        'every number of the configuration "home" must be a number, this is "90°"',
        None,
    ),
    (
        "      home: [0, -90 deg, 0.5]",
        "      «Home»: [0, 0, 0]",
        '"Home" cannot be the name of a configuration',
        'write "home": names match [a-z][a-z0-9_]*',
    ),
    (
        "      mount: tool0",
        "      mount: tool0\n      «mont»: x",
        'unknown key "mont" of a gripper',
        'did you mean "mount"?',
    ),
    (
        "      open: {finger_joint: 0.04}",
        "      joints: [finger_joint]\n      open: {«finger_jont»: 0.04}",
        '"finger_jont" is no joint of the gripper',
        'did you mean "finger_joint"?',
    ),
    *[
        ("    urdf: arm.urdf\n", f"    urdf: arm.urdf\n    sensors: {given}\n", message, hint)
        for given, message, hint in WRONG_SENSORS
    ],
    ("tcp: {point: [0, 0, 0.1]}", "tcp: {point: «[0, 0]»}", "a point must have 3 numbers, not 2", None),
    ("tcp: {point: [0, 0, 0.1]}", "«tcp»: {}", "a feature is exactly one of point, line and plane", None),
    ("along: [0, 0, 2]", "along: «[0, 0, 0]»", "`along` is zero and gives no direction", None),
    ("along: [0, 0, 2]", "along: «z»", "`along` must be a list of 3 numbers: [0, 0, 0]", None),
    (
        "{line: {through: [0, 0, 0.1], along: [0, 0, 2]}}",
        "{line: «{along: [0, 0, 2]}»}",
        'a line needs the key "through"',
        None,
    ),
]


@pytest.mark.parametrize(("old", "new", "message", "hint"), WRONG_ROBOTS, ids=[row[2] for row in WRONG_ROBOTS])
def test_a_wrong_robot_is_reported_at_its_place(
    kitchen: Kitchen, old: str, new: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", old, new, message, hint)


def test_where_closed_form_inverse_kinematics_are_asked_for_is_kept(kitchen: Kitchen) -> None:
    asked = "    urdf: arm.urdf\n    inverse_kinematics: analytic\n"
    scene = load_problem(kitchen.write(scene=SCENE.replace("    urdf: arm.urdf\n", asked))).scene
    assert scene is not None
    robot = scene.robots["left"]
    assert robot.inverse_kinematics == "analytic"
    assert robot.analytic is not None and robot.analytic.column == 25


def test_a_sensor_has_angles_range_and_a_pose_in_the_frame_of_its_link(kitchen: Kitchen) -> None:
    given = (
        "    urdf: arm.urdf\n    sensors:\n      eye: {frame: tool0, field_of_view: 60 deg, range: [0.1, 1.5]}\n"
        "      wide: {frame: tool0, field_of_view: {horizontal: 90 deg, vertical: 0.5}, range: [0.2, 3],"
        " pose: {position: [0, 0, 0.1]}, allowed: [palm]}\n"
    )
    scene = load_problem(kitchen.write(scene=SCENE.replace("    urdf: arm.urdf\n", given))).scene
    assert scene is not None
    sensors = scene.robots["left"].sensors
    assert sensors["eye"].field_of_view == (math.radians(60),)
    assert sensors["eye"].range == (0.1, 1.5)
    assert sensors["wide"].field_of_view == (math.radians(90), 0.5)
    assert sensors["wide"].position == (0.0, 0.0, 0.1)
    assert sensors["wide"].allowed == ("palm",)


def test_a_sensor_whose_range_looks_like_millimetres_is_warned_of(kitchen: Kitchen) -> None:
    sensor = "    urdf: arm.urdf\n    sensors:\n      eye: {{frame: tool0, field_of_view: 60 deg, range: {}}}\n"
    for asked, expected in (("[100, 600]", 1), ("[0.1, 0.6]", 0)):
        path = kitchen.write(scene=SCENE.replace("    urdf: arm.urdf\n", sensor.format(asked)))
        found = [each for each in check_files([path]) if "nearer than 100 m" in each.message]
        assert all(each.severity == "warning" for each in found)
        assert [each.hint for each in found] == [
            "lengths are metres: if these are millimetres, write [0.1, 0.6]"
        ] * expected
