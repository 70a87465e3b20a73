"""`kabo robot`: from a URDF to a scene that `kabo check` accepts."""

import numpy as np
import pytest

from kabo import robot_scene
from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.scene import link_poses, load_scene
from tests.support.broken_robots import SRDF
from tests.support.small_robots import write_arm


def test_a_scene_is_written_that_check_accepts(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    said = kabo("robot", urdf, "-o", tmp_path / "scene.yaml")
    assert said.code == 0 and said.out == ""
    assert "plans 3 joints: shoulder, elbow, turn" in said.err and "gripper finger: -9 to 111 mm" in said.err
    checked = kabo("check", tmp_path / "scene.yaml")
    assert checked.code == 0 and "0 errors, 0 warnings" in checked.err
    assert "urdf: small.urdf" in (tmp_path / "scene.yaml").read_text()


def test_without_an_output_the_scene_is_printed_and_json_is_one_object(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    assert kabo("robot", urdf).out.startswith("scene: small\n")
    found = kabo("robot", urdf, "--json").json
    assert found["joints"] == ["shoulder", "elbow", "turn"] and found["gripper_joints"] == ["finger"]
    assert found["opening"] == pytest.approx([0.111, -0.009])


def test_without_the_library_of_pictures_the_scene_is_written_and_the_command_says_what_is_missing(
    kabo, tmp_path, monkeypatch
):
    monkeypatch.setattr("kabo.pictures.files.find_spec", lambda _: None)
    said = kabo("robot", write_arm(tmp_path), "-o", tmp_path / "scene.yaml", "--picture", tmp_path / "arm.png")
    assert said.code == 2 and "kabo[pictures]" in said.err
    assert kabo("check", tmp_path / "scene.yaml").code == 0
    assert not (tmp_path / "arm.png").exists()


def test_joints_without_a_velocity_limit_are_warned_of(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    urdf.write_text(urdf.read_text().replace('velocity="2"', 'velocity="0"').replace(' velocity="3"', ""))
    assert kabo("robot", urdf, "-o", tmp_path / "scene.yaml").code == 0
    said = kabo("check", tmp_path / "scene.yaml").err
    assert 'the URDF of robot "small" has no velocity limit above 0 and below 100 for elbow, turn' in said
    assert "0 errors, 1 warning" in said


def test_a_gripper_stands_at_its_pose_on_the_mount(tmp_path):
    write_arm(tmp_path)
    (tmp_path / "fork.urdf").write_text('<robot name="fork"><link name="prong"/></robot>')
    gripper = "{urdf: fork.urdf, mount: hand, pose: {position: [0, 0, 0.1], rpy: [0, 90 deg, 0]}, joints: []}"
    text = f"scene: s\nepsilon: 0.01\nrobots:\n  arm: {{urdf: small.urdf, gripper: {gripper}}}\n"
    (tmp_path / "scene.yaml").write_text(text)
    robot = load_scene(load_scene_description(tmp_path / "scene.yaml")).robots["arm"]
    poses = link_poses(robot, [0.1] * len(robot.joint_names))
    local = np.linalg.inv(poses["hand"]) @ poses["prong"]
    assert np.allclose(local, [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0.1], [0, 0, 0, 1]])
    (tmp_path / "scene.yaml").write_text(text.replace("rpy", "frame: hand, rpy"))
    with pytest.raises(InputError, match='unknown key "frame"'):
        load_scene_description(tmp_path / "scene.yaml")


def test_groups_that_include_each_other_are_warned_of_with_the_line(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    circle = '<group name="a"><group name="b"/></group>\n  <group name="b"><group name="a"/></group>\n</robot>'
    (tmp_path / "small.srdf").write_text(SRDF.replace("</robot>", circle))
    assert kabo("robot", urdf, "--srdf", tmp_path / "small.srdf", "-o", tmp_path / "scene.yaml").code == 0
    said = kabo("check", tmp_path / "scene.yaml").err
    assert 'small.srdf:9:17: warning: group "a" includes itself by way of group "b"' in said


def test_a_group_or_a_tip_chooses_the_arm(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    (tmp_path / "small.srdf").write_text(SRDF.replace('tip_link="hand"', 'tip_link="lower"'))
    found = kabo("robot", urdf, "--srdf", tmp_path / "small.srdf", "--group", "arm", "--json").json
    assert found["joints"] == ["shoulder", "elbow"]
    assert kabo("robot", urdf, "--tip", "lower", "--json").json["joints"] == ["shoulder", "elbow"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("absent.urdf",), "there is no such file"),
        (("package://absent/a.urdf",), 'unknown package "absent"'),
        (("small.urdf", "--tip", "hnad"), 'did you mean "hand"'),
        (("small.urdf", "--group", "arm"), 'unknown group "arm"'),
        (("small.urdf", "--name", "My Arm"), "such as my_arm"),
    ],
)
def test_what_does_not_exist_is_told_with_a_remedy(kabo, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    write_arm(tmp_path)
    said = kabo("robot", *arguments, "-o", "scene.yaml")
    assert said.code == 2 and words in said.err and "Traceback" not in said.err
    assert not (tmp_path / "scene.yaml").exists()


def test_all_faults_of_a_urdf_are_told_and_nothing_is_written(kabo, tmp_path):
    path = write_arm(tmp_path)
    path.write_text(
        path.read_text().replace('multiplier="2"', 'multiplier="x"').replace('xyz="0 1 0"', 'xyz="0 0 0"')
    )
    said = kabo("robot", path, "-o", tmp_path / "scene.yaml")
    assert said.code == 2 and said.err.count("small.urdf:") == 2
    assert not (tmp_path / "scene.yaml").exists()


def test_the_function_writes_what_the_command_writes(kabo, tmp_path):
    urdf = write_arm(tmp_path)
    assert kabo("robot", urdf, "--name", "arm", "-o", tmp_path / "scene.yaml").code == 0
    assert robot_scene(urdf, name="arm", folder=tmp_path) == (tmp_path / "scene.yaml").read_text()
    with pytest.raises(InputError, match="there is no such file"):
        robot_scene(tmp_path / "none.urdf")
    with pytest.raises(InputError, match='"An Arm" is no name'):
        robot_scene(urdf, name="An Arm")
