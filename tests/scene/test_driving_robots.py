"""Robots whose base drives: three joints before the tree, their limits, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.scene import link_poses
from tests.support.carts import LOOSE, OWN_JOINTS, cart

CORNERS = [("body", (x, y, 0.0)) for x in (-0.2, 0.3) for y in (-0.15, 0.15)]
CORNERS += [("wheel", (x, y, 0.0)) for x in (-0.01, 0.01) for y in (-0.2, 0.2)]


def refused(folder: Path, *arguments: str, **options: str) -> str:
    """What is said about a cart that is wrong."""
    with pytest.raises(InputError) as error:
        cart(folder, *arguments, **options)
    return str(error.value)


def test_three_joints_come_first_and_move_the_base_from_its_written_pose(tmp_path: Path) -> None:
    robot = cart(tmp_path, "position: [0.3, 0.1, 0], rpy: [0, 0, 90 deg], moves: {within: hall}")
    assert robot.planned_joints == ("base_x", "base_y", "base_yaw", "shoulder", "elbow")
    pose = link_poses(robot, (0.2, -0.1, np.pi / 2, 0.0, 0.0))["body"]
    assert np.allclose(pose[:3, 3], [0.3 + 0.1, 0.1 + 0.2, 0.0])  # its x is the world's y
    assert np.allclose(pose[:2, :2], [[-1, 0], [0, -1]], atol=1e-9)


def test_limits_leave_what_the_footprint_leaves_of_the_floor(tmp_path: Path) -> None:
    robot = cart(tmp_path)
    edge = np.array([-0.05, 0.19]) / np.hypot(
        0.05, 0.19
    )  # normal to that from a wheel's end to a corner of the body
    inset = edge @ (-0.01, 0.2)  # the body is 0.3 m wide, its wheels 0.4 m: they are not planned, and count
    assert np.allclose(robot.tree.lower[:2], [-1.5 + inset, -1.0 + inset], atol=1e-6)
    assert np.allclose(robot.tree.upper[:2], [1.5 - inset, 1.0 - inset], atol=1e-6)
    assert robot.drive is not None and set(robot.drive.links) == {"body", "wheel"}  # the axle is not planned


def test_limits_of_the_scene_narrow_those_of_the_floor(tmp_path: Path) -> None:
    assert cart(tmp_path, "moves: {within: hall, turn: [-10 deg, 90 deg]}").tree.upper[2] == pytest.approx(
        np.pi / 2
    )


def test_configurations_of_the_arm_alone_leave_the_base_where_it_was_written(tmp_path: Path) -> None:
    robot = cart(tmp_path)
    assert robot.configurations["home"] == (0.0, 0.0, 0.0, 0.5, 1.0)
    assert robot.configurations["away"] == (0.6, -0.4, pytest.approx(np.pi / 2), 0.0, 0.0)


def test_a_urdf_with_x_y_and_yaw_of_its_own_keeps_them_and_their_limits(tmp_path: Path) -> None:
    robot = cart(tmp_path, hall="box: [4, 4, 0.1]", extra=OWN_JOINTS % "revolute")
    assert robot.planned_joints[:3] == ("base_x", "base_y", "base_yaw")
    assert robot.tree.upper[0] == 0.7  # of the URDF
    assert robot.tree.velocity[0] == 0.3
    pose, drive = (0.3, -0.2, 0.9), robot.drive
    assert drive is not None
    floor = np.array([[-2.0, -2.0], [2.0, 2.0]])  # in the world; here x of the base is the world's y
    every = [link_poses(robot, (*pose, 0.0, 0.0))[n] @ np.array([*c, 1.0]) for n, c in CORNERS]
    worst = max(max(*(p[:2] - floor[1]), *(floor[0] - p[:2])) for p in every)
    assert drive.outside(np.array([pose]))[0] == pytest.approx(worst, abs=1e-9)


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_planar_or_floating_joint_of_the_first_link_becomes_the_base(tmp_path: Path, kind: str) -> None:
    robot = cart(tmp_path, extra=LOOSE % kind)
    assert robot.planned_joints[:3] == ("base_x", "base_y", "base_yaw")
    assert link_poses(robot, (0.1, 0.0, 0.0, 0.0, 0.0))["body"][:3, 3] == pytest.approx([0.1, 0.0, 0.02])


def test_a_floating_joint_of_a_base_that_stands_is_refused_with_the_way_out(tmp_path: Path) -> None:
    said = refused(tmp_path, "position: [0, 0, 0]", extra=LOOSE % "floating", configurations="")
    assert "neither revolute nor prismatic" in said
    assert "base: {moves: {within: REGION}}" in said


def test_one_joint_of_that_name_is_refused(tmp_path: Path) -> None:
    own = '<link name="map"/><joint name="base_x" type="fixed"><parent link="map"/><child link="body"/></joint>'
    assert 'has the joint "base_x" and not all of' in refused(tmp_path, extra=own)


def test_a_base_that_leans_is_refused(tmp_path: Path) -> None:
    assert "give the base an upright pose" in refused(tmp_path, "rpy: [10 deg, 0, 0], moves: {within: hall}")


def test_joints_that_do_not_slide_and_turn_in_the_plane_are_refused(tmp_path: Path) -> None:
    said = refused(tmp_path, "moves: {within: hall, joints: [shoulder, elbow, axle]}")
    assert "do not slide along x, along y and turn about the vertical" in said


def test_a_floor_that_is_too_small_is_told_by_how_much(tmp_path: Path) -> None:
    said = refused(tmp_path, hall="box: [0.2, 0.2, 0.1]")
    assert 'the floor "hall" is too small for the base of "cart", at whatever turn' in said
    assert "it lacks" in said


def test_a_configuration_outside_of_the_floor_is_named(tmp_path: Path) -> None:
    said = refused(tmp_path, configurations=", door: [1.4, 0, 0, 0, 0]")
    assert 'in configuration "door" the base of "cart" reaches 0.2 m out of the floor "hall"' in said


def test_a_wrong_number_of_values_names_the_joints_of_the_base(tmp_path: Path) -> None:
    said = refused(tmp_path, configurations=", door: [1.4, 0, 0]")
    assert "3 values, but the robot has 5 planned joints (base_x, base_y, base_yaw first)" in said


def test_a_robot_that_drives_keeps_the_closed_form_of_its_arm() -> None:
    from tests.domains.scenes import DOMAINS, scene_of

    robot = scene_of(DOMAINS / "waiter" / "two_cups.yaml").robots["waiter"]
    still = scene_of(DOMAINS / "stacked" / "n3.yaml").robots["mobile"]
    assert robot.structure.form == still.structure.form == 2  # type: ignore[union-attr]
    assert np.allclose(robot.structure.axes, still.structure.axes)  # type: ignore[union-attr]
