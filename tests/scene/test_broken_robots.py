"""Robots with one fault each: a finding with file, line and remedy, and nothing that a C++ library or Python would say."""

import re
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import load_scene_description
from kabo.requests import check_files
from kabo.scene import load_scene
from tests.support.broken_robots import ARM, SRDF, Broken, cases

CASES = list(cases())
RAW = re.compile(r"Traceback|\.cpp|\.hpp|\.py\b|0x[0-9a-f]{6}|urdfdom|pinocchio|Qhull|ValueError|Error:")


def test_there_are_forty_and_each_has_a_name_of_its_own() -> None:
    assert len(CASES) >= 40
    assert len({case.name for case in CASES}) == len(CASES)


def test_the_robot_without_a_fault_has_no_finding(tmp_path: Path) -> None:
    assert check_files([Broken("sound").place(tmp_path)]) == []


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_fault_is_told_with_its_place_and_remedy(
    case: Broken, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    scene = case.place(tmp_path)
    found = check_files([scene])
    assert capfd.readouterr() == ("", ""), "nothing is written but findings"
    here = [each for each in found if Path(each.file).name == case.where and each.severity == case.severity]
    assert here, [str(each) for each in found]
    line = case.line(tmp_path)
    told = [each for each in here if line is None or each.line == line]
    assert told, (line, [str(each) for each in here])
    text = "\n".join(map(str, told))
    for words in case.says:
        assert words in text, text
    assert not RAW.search("\n".join(map(str, found))), text
    if case.severity == "warning":
        assert not [each for each in found if each.severity == "error"], [str(each) for each in found]
    else:
        assert all(each.hint for each in found), text


def test_all_faults_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    text = ARM.replace('multiplier="2"', 'multiplier="x"').replace('<parent link="base"/>', '<parent link="bse"/>')
    text = text.replace('size="0.04 0.04 0.3"', 'size=".2 .2"').replace('xyz="0 1 0"', 'xyz="0 0 0"')
    found = check_files([Broken("many", urdf=text).place(tmp_path)])
    assert len(found) == 4
    assert len({each.line for each in found}) >= 3


def test_loading_raises_the_same_findings_as_checking(tmp_path: Path) -> None:
    scene = Broken("many", urdf=ARM.replace('xyz="0 1 0"', 'xyz="0 0 0"')).place(tmp_path)
    with pytest.raises(InputError) as raised:
        load_scene(load_scene_description(scene))
    assert list(raised.value.diagnostics) == check_files([scene])


def test_a_mimic_of_a_mimic_follows_the_joint_that_moves(tmp_path: Path) -> None:
    third = (
        '<link name="third"/><joint name="third_finger" type="prismatic"><parent link="hand"/><child link="third"/>'
        '<axis xyz="1 0 0"/><limit lower="0" upper="1"/>'
        '<mimic joint="other_finger" multiplier="3" offset="0.5"/></joint></robot>'
    )
    scene = Broken("chain", urdf=ARM.replace("</robot>", third)).place(tmp_path)
    robot = load_scene(load_scene_description(scene)).robots["r"]
    q = robot.expand((0.0, 0.0, 0.0, 0.01))
    assert q[robot.model.joints[robot.model.getJointId("third_finger")].idx_q] == pytest.approx(0.563)


def test_an_srdf_gives_configurations_and_pairs_that_may_touch(tmp_path: Path) -> None:
    text = SRDF.replace("</robot>", '<end_effector name="e" group="arm" parent_link="hand"/></robot>')
    scene = load_scene(load_scene_description(Broken("sound", srdf=text).place(tmp_path)))
    robot = scene.robots["r"]
    assert robot.configurations == {"up": (0.5, 0.0, 0.0)}
    assert frozenset(("base", "lower")) in robot.allowed
    assert frozenset(("r.base", "r.lower")) in scene.allowed
    assert robot.tool is not None and robot.tool.frame == "hand"
    assert robot.groups.links_of("arm") == ("upper", "lower", "hand")


def test_an_expression_of_xacro_in_a_plain_urdf_is_called_so(tmp_path: Path) -> None:
    found = check_files(
        [Broken("xacro", urdf=ARM.replace('size="0.04 0.04 0.3"', 'size="${w} ${w} 0.3"')).place(tmp_path)]
    )
    assert [each.hint for each in found] == ["expand it with xacro, or name it .xacro"]
