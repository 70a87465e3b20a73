"""Xacro files: expanded with their packages, or refused with a remedy."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.scene.urdf_file import read_urdf

ARM = """<robot name="x" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find shapes)/box.xacro"/>
  <xacro:box name="base" size="${0.1 * 2}"/>
</robot>
"""
BOX = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="box" params="name size">
    <link name="${name}"><collision><geometry><box size="${size} 0.1 0.1"/></geometry></collision></link>
  </xacro:macro>
</robot>
"""


def _write(folder: Path, text: str = ARM) -> Path:
    (folder / "shapes").mkdir()
    (folder / "shapes" / "box.xacro").write_text(BOX)
    path = folder / "arm.urdf.xacro"
    path.write_text(text)
    return path


def test_macros_are_expanded_and_packages_are_found_beside_the_file(tmp_path: Path) -> None:
    file = read_urdf(_write(tmp_path), {}, None)
    (element,) = file.elements["base"]
    assert element.corners is not None
    assert element.corners[:, 0].max() == pytest.approx(0.1)
    assert [path.name for path in file.files] == ["arm.urdf.xacro", "box.xacro"]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("xacro:box", "xacro:bx", "unknown macro"),
        ("find shapes", "find shaps", 'unknown package "shaps"'),
        ("0.1 * 2", "1 / 0", "division by zero"),
        ("0.1 * 2", "nobody", "nobody"),
        ("</robot>", "", "ExpatError"),
    ],
)
def test_a_fault_is_one_finding_with_a_remedy(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(InputError) as raised:
        read_urdf(_write(tmp_path, ARM.replace(old, new)), {}, None)
    (found,) = raised.value.diagnostics
    assert words in found.message and found.hint and "Traceback" not in found.message


def test_without_the_package_the_remedy_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kabo.scene.urdf_files.xacro_files.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install \"kabo\[xacro\]\""):
        read_urdf(_write(tmp_path), {}, None)


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_of_ros_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    share = tmp_path / "ros" / ("share" if variable == "AMENT_PREFIX_PATH" else "")
    share.mkdir(parents=True)
    robot = tmp_path / "deep" / "robot"
    robot.mkdir(parents=True)
    path = _write(robot)
    (robot / "shapes").rename(share / "shapes")
    with pytest.raises(InputError, match="unknown package"):
        read_urdf(path, {}, None)
    monkeypatch.setenv(variable, str(tmp_path / "ros"))
    assert "base" in read_urdf(path, {}, None).elements
