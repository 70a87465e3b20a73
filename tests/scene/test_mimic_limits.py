"""Mimic joints keep their own limits: they narrow those of the joints that they follow."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.scene import Robot, load_scene

FINGER = '<mimic joint="finger" multiplier="{}" offset="{}"/>'
URDF = """<robot name="r">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="arm"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="left"><collision><geometry><box size="0.01 0.02 0.05"/></geometry></collision></link>
  <link name="right"><collision><geometry><box size="0.01 0.02 0.05"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="finger" type="prismatic"><parent link="arm"/><child link="left"/><axis xyz="1 0 0"/>
    <limit lower="-0.02" upper="0.04" velocity="0.1" effort="1"/></joint>
  <joint name="other" type="prismatic"><parent link="arm"/><child link="right"/><axis xyz="-1 0 0"/>
    LIMIT MIMIC</joint>
</robot>
"""


def robot(folder: Path, limit: str, mimic: str, *lines: str, joints: str = "[turn, finger]") -> Robot:
    (folder / "r.urdf").write_text(URDF.replace("LIMIT", limit).replace("MIMIC", mimic))
    path = folder / "scene.yaml"
    text = f"scene: s\nepsilon: 0.01\nrobots:\n  r:\n    urdf: r.urdf\n    joints: {joints}\n"
    path.write_text(text + "".join(f"    {line}\n" for line in lines))
    return load_scene(path).robots["r"]


@pytest.mark.parametrize(
    ("limit", "multiplier", "offset", "lower", "upper", "velocity"),
    [
        ("lower='-1' upper='1' velocity='1'", "1", "0", -0.02, 0.04, 0.1),
        ("lower='0' upper='0.03' velocity='1'", "1", "0", 0.0, 0.03, 0.1),
        ("lower='0' upper='0.05' velocity='1'", "2", "0.01", -0.005, 0.02, 0.1),
        ("lower='-0.03' upper='0.01' velocity='1'", "-1", "0", -0.01, 0.03, 0.1),
        ("lower='-1' upper='1' velocity='0.1'", "-2", "0", -0.02, 0.04, 0.05),
        ("lower='-1' upper='1' velocity='0'", "2", "0", -0.02, 0.04, 0.1),
        ("velocity='0.1'", "1", "0", -0.02, 0.04, 0.1),  # none is written
        ("lower='1' upper='2'", "0", "0", -0.02, 0.04, 0.1),  # it stands still
        ("lower='0.04' upper='0.1'", "1", "0", -0.02, 0.04, 0.1),  # a single value: the limits are not meant
    ],
)
def test_the_limits_of_a_mimic_joint_narrow_those_of_the_joint_that_it_follows(
    tmp_path: Path, limit: str, multiplier: str, offset: str, lower: float, upper: float, velocity: float
) -> None:
    tree = robot(tmp_path, f"<limit {limit}/>", FINGER.format(multiplier, offset)).tree
    assert (tree.lower[1], tree.upper[1]) == pytest.approx((lower, upper))
    assert tree.velocity[1] == pytest.approx(velocity)


def test_a_mimic_joint_that_is_never_within_its_limits_is_refused_at_its_place(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        robot(tmp_path, "<limit lower='0.1' upper='0.2'/>", FINGER.format("1", "0.01"))
    (found,) = caught.value.diagnostics
    assert (Path(found.file).name, found.line) == ("r.urdf", 9)
    assert found.message == (
        'joint "other" follows "finger" (1 times its value plus 0.01), and is outside its own limits 0.1 to 0.2 wherever '
        "that is within -0.02 to 0.04"
    )
    assert found.hint == "correct the limits of one of them, or multiplier and offset"


def test_a_mimic_joint_of_a_joint_that_is_not_planned_stands_where_its_rule_puts_it(tmp_path: Path) -> None:
    found = robot(tmp_path, "<limit lower='-1' upper='1'/>", FINGER.format("2", "0.01"), joints="[turn]")
    q = found.expand((0.0,))
    assert q[found.model.joints[found.model.getJointId("other")].idx_q] == pytest.approx(0.01)


def test_a_configuration_outside_the_limits_of_a_mimic_joint_is_told_with_where_they_are_from(
    tmp_path: Path,
) -> None:
    with pytest.raises(InputError, match=r"finger = 0\.035 is outside its limits \[0, 0\.03\]") as caught:
        robot(
            tmp_path,
            "<limit lower='0' upper='0.03'/>",
            FINGER.format("1", "0"),
            "configurations: {wide: [0, 0.035]}",
        )
    assert "joints that mimic it" in str(caught.value)


def test_the_end_of_a_narrowed_range_can_be_named(tmp_path: Path) -> None:
    limit, mimic = "<limit lower='0' upper='0.03'/>", FINGER.format("0.8", "0.002")
    found = robot(tmp_path, limit, mimic, "configurations: {wide: [0, 0.035]}")
    assert found.tree.upper[1] == 0.035
