"""Scenes with one fault each, of robots that are sound: a finding with its line and a remedy that helps."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

import kabo
from kabo.requests import check_files
from tests.support.broken_robots import MESH, SCENE, Broken, mesh

CRATE = """objects:
  crate:
    box: [0.02, 0.02, 0.1]
    pose: {position: [0.5, 0, 0.05]}
    movable: true
    grasps: {middle: {constraints: ["coincident(tool.tcp, this.center)"], fingers: {finger: 0.01}}}
"""
TOOL = "    tool: {frame: hand, features: {tcp: {point: [0, 0, 0.05]}}}\n"
EYE = "    sensors: {eye: {frame: hand, field_of_view: 300 deg, range: [0.1, 1]}}\n"


@dataclass(frozen=True)
class Fault:
    """What is added to the robot's entry or to the scene, a text in the line of the finding, and words of it."""

    robot: str = ""
    things: str = ""
    at: str = "urdf: robot.urdf"
    says: tuple[str, ...] = ()


FAULTS = {
    "a short configuration beside states of an SRDF": Fault(
        "    configurations: {home: [0]}\n", says=('"home" has 1 value,', "3 planned joints", "shoulder, elbow, turn")
    ),
    "a configuration beyond its limits": Fault(
        "    configurations: {home: [9, 0, 0]}\n", says=("shoulder = 9 is outside", "`limits`")
    ),
    "crossed limits": Fault("    limits: {shoulder: [1, -1]}\n", at="shoulder: [1", says=("lower one comes first",)),
    "a planned joint that is none": Fault("    joints: [shoulder, tip]\n", says=('joint "tip"', "elbow")),
    "a field of view in degrees": Fault(EYE, at="300 deg", says=("this is 300 deg",)),
    "fingers of no gripper": Fault(
        TOOL, CRATE.replace("{finger: 0.01}", "{fingr: 0.01}"), "box: [0.02", ('a joint "fingr"', '"finger"?')
    ),
    "no rotation": Fault(
        things=CRATE.replace("0.05]}", "0.05], quaternion: [0, 0, 0, 0]}"),
        at="quaternion",
        says=("length 1", "[0, 0, 0, 1]"),
    ),
    "a circle of frames": Fault(
        things="objects:\n  a: {box: [1, 1, 1], pose: {frame: b}}\n  b: {box: [1, 1, 1], pose: {frame: a}}\n",
        at="frame: b",
        says=("a → b → a", "world"),
    ),
    "a fixed body on a link that moves": Fault(
        things="objects:\n  eye: {box: [0.02, 0.02, 0.02], pose: {frame: r.hand, position: [0, 0, 0.1]}}\n",
        at="frame: r.hand",
        says=('fixed body "eye"', "r.hand, which moves", "URDF", "movable: true"),
    ),
    "a region on a link that moves": Fault(
        things="regions:\n  reach: {box: [0.02, 0.02, 0.02], pose: {frame: r.hand}}\n",
        at="frame: r.hand",
        says=('region "reach"', "stay behind"),
    ),
    "a length with its unit": Fault(
        things=CRATE.replace("[0.5, 0", "[50 cm, 0"), at="50 cm", says=('"50 cm"', "write 0.5")
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_a_scene_is_told_with_its_line(name: str, tmp_path: Path) -> None:
    fault = FAULTS[name]
    scene = Broken(name, scene=SCENE + fault.robot + fault.things).place(tmp_path)
    found = check_files([scene])
    text = "\n".join(map(str, found))
    assert len(found) == 1 and found[0].severity == "error", text
    shown = scene.read_text().splitlines()
    assert found[0].line == 1 + next(i for i, line in enumerate(shown) if fault.at in line), text
    for words in fault.says:
        assert words in text, text
    assert "angles are radians" not in text, "it is given in degrees"


def _object(content: str) -> Callable[[Path], None]:
    return lambda folder: (folder / "part.obj").write_text(content) and None


MESHES = [
    mesh("a folder", lambda folder: (folder / "part.stl").mkdir(), "is a folder"),
    mesh("a link to the web", lambda folder: None, "https:// is not read", "download", tag=MESH.replace("part", "https://x.org/part")),
    mesh("a model of Gazebo", lambda folder: None, "model:// is not read", tag=MESH.replace("part", "model://arm/part")),
    mesh("xacro left over", lambda folder: None, "$( ) is xacro", tag=MESH.replace("part", "$(find arm)/part")),
    mesh(
        "corners that are not there",
        _object("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        "its faces name vertices that it does not have",
        tag=MESH.replace("stl", "obj"),
    ),
]  # fmt: skip


@pytest.mark.parametrize("case", MESHES, ids=lambda case: case.name)
def test_a_mesh_that_cannot_be_read_is_told_with_what_helps(case: Broken, tmp_path: Path) -> None:
    found = check_files([case.place(tmp_path)])
    text = "\n".join(map(str, found))
    assert [each.line for each in found] == [case.line(tmp_path)], text
    for words in case.says:
        assert words in text, text


def test_a_robot_without_a_tool_has_no_grasps_and_that_is_said(tmp_path: Path) -> None:
    Broken("no tool", scene=SCENE + CRATE).place(tmp_path)
    (tmp_path / "domain.yaml").write_text(
        "domain: d\ntypes: [robot, thing]\npredicates: {held: [robot, thing]}\nactions:\n  get:\n"
        "    parameters: {r: robot, o: thing}\n    geometry: pick(r, o)\n    effects:\n      - add(Kf, held(r, o))\n"
    )
    (tmp_path / "problem.yaml").write_text(
        "problem: p\ndomain: domain.yaml\nscene: scene.yaml\nobjects: {robot: [r], thing: [crate]}\n"
        "initial:\n  - add(Kf, not held(r, crate))\ngoal:\n  - K(held(r, crate))\n"
    )
    result = kabo.solve(kabo.load_problem(tmp_path / "problem.yaml"))
    assert result.status == "no_plan" and result.reason is not None
    assert "r has no `tool` in the scene" in str(result.reason.details), result.reason
