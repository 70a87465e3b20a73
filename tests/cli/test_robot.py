"""`kabo robot`: from a URDF to a scene that `kabo check` accepts."""

import pytest

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
