"""Poses: conventions of angles, unit quaternions, chains of frames."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.language import check_files, load_problem
from kabo.language.yaml.scenes.poses import quaternion_of_rpy
from tests.language.conftest import SCENE, Kitchen

Matrix = list[list[float]]


def _product(a: Matrix, b: Matrix) -> Matrix:
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def _about(axis: int, angle: float) -> Matrix:
    cosine, sine = math.cos(angle), math.sin(angle)
    matrix = [[float(i == j) for j in range(3)] for i in range(3)]
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i][i] = matrix[j][j] = cosine
    matrix[i][j], matrix[j][i] = -sine, sine
    return matrix


def _rotation(x: float, y: float, z: float, w: float) -> Matrix:
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]


@given(rpy=st.tuples(*[st.floats(-7, 7)] * 3))
def test_rpy_turns_about_the_fixed_axes_x_then_y_then_z(rpy: tuple[float, float, float]) -> None:
    """URDF's convention: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    expected = _product(_about(2, rpy[2]), _product(_about(1, rpy[1]), _about(0, rpy[0])))
    found = _rotation(*quaternion_of_rpy(rpy))
    assert all(abs(found[i][j] - expected[i][j]) < 1e-12 for i in range(3) for j in range(3))


def test_degrees_become_radians(kitchen: Kitchen) -> None:
    scene = load_problem(kitchen.write()).scene
    assert scene is not None
    half = math.sqrt(0.5)
    assert scene.bodies["tray"].pose.quaternion == pytest.approx((0, 0, half, half), abs=1e-15)
    assert scene.bodies["tray"].pose.frame == "table"


def test_a_quaternion_within_a_millionth_of_unit_length_is_normalised(kitchen: Kitchen) -> None:
    kitchen.write(scene=SCENE.replace("rpy: [0, 0, 90 deg]", "quaternion: [0, 0, 0, 1.0000009]"))
    scene = load_problem(kitchen.problem).scene
    assert scene is not None and scene.bodies["tray"].pose.quaternion == (0.0, 0.0, 0.0, 1.0)
    kitchen.write(scene=SCENE.replace("rpy: [0, 0, 90 deg]", "quaternion: [0, 0, 0, 1.0000011]"))
    assert "length 1" in check_files([kitchen.problem])[0].message


def test_a_circle_of_frames_through_a_robot_is_found_once(kitchen: Kitchen) -> None:
    text = SCENE.replace("base: {position: [0, 0.5, 0]}", "base: {frame: tray}")
    kitchen.write(scene=text.replace("{frame: table, rpy", "{frame: left.tool0, rpy"))
    (one,) = check_files([kitchen.problem])
    assert one.message == "the frames form a circle: left → tray → left"


def test_frames_may_be_chained(kitchen: Kitchen) -> None:
    kitchen.write(scene=SCENE.replace("{position: [0, 0, -0.02]}", "{frame: left.link_3}"))
    assert check_files([kitchen.problem]) == []
