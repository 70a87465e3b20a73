"""How fast joints may move: by the URDF, by the scene, by default."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.motion import MotionLimits
from kabo.scene import Robot, load_scene, motion_limits
from tests.support.small_robots import write_arm

SCENE = """\
scene: small
epsilon: 0.01
robots:
  arm:
    urdf: small.urdf
    tool: {frame: hand}
    gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}}
"""
JOINTS = ("shoulder", "elbow", "turn", "finger")
URDF_VELOCITY = [1.0, 2.0, 3.0, 0.1]


def robot(folder: Path, *lines: str) -> Robot:
    write_arm(folder)
    path = folder / "scene.yaml"
    path.write_text(SCENE + "".join(f"    {line}\n" for line in lines))
    return load_scene(path).robots["arm"]


def limits_of(found: Robot) -> MotionLimits:
    return motion_limits(found, found.joint_names)


def rows(folder: Path, *lines: str) -> list[list[float]]:
    return [row.tolist() for row in limits_of(robot(folder, *lines)).rows]


def test_without_a_word_in_the_scene_limits_follow_from_velocities_of_the_urdf(tmp_path: Path) -> None:
    velocity, acceleration, jerk = rows(tmp_path)
    assert robot(tmp_path).joint_names == JOINTS
    assert velocity == URDF_VELOCITY
    assert acceleration == pytest.approx([4.0, 8.0, 12.0, 0.4])
    assert jerk == pytest.approx([80.0, 160.0, 240.0, 8.0])


def test_a_number_narrows_the_velocities_of_all_joints_and_defaults_follow(tmp_path: Path) -> None:
    velocity, acceleration, jerk = rows(tmp_path, "velocity: 1.5")
    assert velocity == [1.0, 1.5, 1.5, 0.1]
    assert acceleration == pytest.approx([4.0, 6.0, 6.0, 0.4])
    assert jerk == pytest.approx([80.0, 120.0, 120.0, 8.0])


def test_a_number_makes_a_gripper_slower_but_not_faster(tmp_path: Path) -> None:
    _, acceleration, jerk = rows(tmp_path, "acceleration: 0.2", "jerk: 3")
    assert acceleration == [0.2] * 4 and jerk == [3.0] * 4
    _, acceleration, jerk = rows(tmp_path, "acceleration: 10", "jerk: 300")
    assert acceleration == pytest.approx([10.0, 10.0, 10.0, 0.4])
    assert jerk == pytest.approx([300.0, 300.0, 300.0, 8.0])


def test_joints_by_name_have_their_own_limits(tmp_path: Path) -> None:
    given = "limits: {elbow: {acceleration: 3, jerk: 20}, finger: {velocity: 0.05, acceleration: 1}}"
    velocity, acceleration, jerk = rows(tmp_path, "velocity: {shoulder: 0.5}", "acceleration: 5", given)
    assert velocity == [0.5, 2.0, 3.0, 0.05]
    assert acceleration == [5.0, 3.0, 5.0, 1.0]
    assert jerk == pytest.approx([100.0, 20.0, 100.0, 20.0])


@pytest.mark.parametrize("none", ["0", "100", "1e4"])
def test_a_velocity_stands_where_the_urdf_has_none_that_a_joint_can_have(none: str, tmp_path: Path) -> None:
    write_arm(tmp_path)
    text = (tmp_path / "small.urdf").read_text().replace('velocity="2"', f'velocity="{none}"')
    robot(tmp_path)
    (tmp_path / "small.urdf").write_text(text)
    path = tmp_path / "scene.yaml"
    assert load_scene(path).robots["arm"].tree.velocity[1] == pytest.approx(3.14159265)
    path.write_text(path.read_text() + "    velocity: {elbow: 5}\n")
    assert load_scene(path).robots["arm"].tree.velocity.tolist() == [1.0, 5.0, 3.0, 0.1]


@pytest.mark.parametrize("slow", ["1e-9", "9e-7"])
def test_a_joint_that_is_too_slow_for_any_motion_is_told_with_the_limit_of_its_urdf(
    slow: str, tmp_path: Path
) -> None:
    robot(tmp_path)
    urdf = tmp_path / "small.urdf"
    urdf.write_text(urdf.read_text().replace('velocity="2"', f'velocity="{slow}"'))
    with pytest.raises(InputError) as caught:
        load_scene(tmp_path / "scene.yaml")
    (found,) = caught.value.diagnostics
    assert (
        found.message == f'the URDF limits the velocity of "elbow" to {slow[0]}e-0{slow[-1]}, 1e-06 is the least'
    )
    assert found.hint == "write a velocity that the joint can have, or 0 where it is not known"


SLOWER = "a scene can only make a robot slower; change the URDF if it is wrong"
WRONG = [
    ("acceleration: {shoulder: 1, elbo: 2}", 8, 33, 'unknown joint "elbo" in the acceleration limits',
     'did you mean "elbow"?'),
    ("jerk: {other_finger: 2}", 8, 12, 'unknown joint "other_finger" in the jerk limits', 'did you mean "finger"?'),
    ("limits: {wrist: {velocity: 1}}", 8, 14, 'unknown joint "wrist" in the limits',
     "there are shoulder, elbow, turn, finger"),
    ("limits: {elbo: [0, 1]}", 8, 14, 'unknown joint "elbo" in the limits', 'did you mean "elbow"?'),
    ("velocity: {shoulder: 1.5}", 8, 26, 'velocity 1.5 of "shoulder" is above the 1 of its URDF',
     SLOWER),
    ("limits: {elbow: [3, 4]}", 8, 14, 'the limits [3, 4] of "elbow" are outside those of its URDF, -2.5 to 2.5',
     "a scene can only make the range of a joint narrower; change the URDF if it is wrong"),
    ("limits: {turn: [-2000, 0]}", 8, 14,
     'the limits [-2000, 0] of the continuous joint "turn" reach beyond 1000 rad',
     "leave them out: it then turns by 360 deg to either side"),
    ("velocity: 30", 8, 15, "velocity 30 is above those of all joints in the URDF: 3 at most", SLOWER),
]  # fmt: skip


@pytest.mark.parametrize(("given", "line", "column", "message", "hint"), WRONG, ids=[row[0] for row in WRONG])
def test_wrong_limits_are_told_at_their_place(
    tmp_path: Path, given: str, line: int, column: int, message: str, hint: str
) -> None:
    with pytest.raises(InputError) as caught:
        robot(tmp_path, given)
    told = [(each.line, each.column, each.message, each.hint) for each in caught.value.diagnostics]
    assert told == [(line, column, message, hint)]


def test_all_wrong_limits_are_told_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        robot(tmp_path, "velocity: {elbow: 9, a: 1}", "acceleration: {b: 1}", "jerk: {c: 1}")
    assert len(caught.value.diagnostics) == 4


def test_all_these_limits_may_come_from_a_robot_model(tmp_path: Path) -> None:
    write_arm(tmp_path)
    path = tmp_path / "scene.yaml"
    path.write_text(
        "scene: two\nepsilon: 0.01\nrobot_models:\n  small: {urdf: small.urdf, acceleration: 2, jerk: 9}\n"
        "robots:\n  one: {model: small}\n  two: {model: small, acceleration: 3, base: {position: [1, 0, 0]}}\n"
    )
    scene = load_scene(path)
    assert limits_of(scene.robots["one"]).acceleration.tolist() == [2.0] * 4
    assert limits_of(scene.robots["two"]).acceleration.tolist() == [3.0] * 4
    assert limits_of(scene.robots["two"]).jerk.tolist() == [9.0] * 4


@pytest.mark.parametrize(
    ("given", "lower", "upper"), [("[-7, 7]", -7.0, 7.0), ("[3 deg, 720 deg]", 0.05236, 12.56637)]
)
def test_limits_of_a_continuous_joint_are_kept_as_given(
    given: str, lower: float, upper: float, tmp_path: Path
) -> None:
    tree = robot(tmp_path, f"limits: {{turn: {given}}}").tree
    assert (tree.lower[2], tree.upper[2]) == pytest.approx((lower, upper), abs=1e-5)
