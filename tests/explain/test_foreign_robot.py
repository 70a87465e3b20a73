"""The same reasons on a robot that kabo does not ship: a Panda at a table, with another epsilon and other sizes."""

import re
from pathlib import Path

import numpy as np
import pytest

from kabo.geometry_server import Stream, grasp_stream, limiting_joint, start_findings
from kabo.language import load_problem
from kabo.language.recorded_paths import installed_folder
from kabo.planner.solve import solve
from kabo.scene import load_scene, world_T
from tests.planner.gantry import DOMAIN, PROBLEM

pytestmark = pytest.mark.skipif(
    installed_folder("example-robot-data") is None, reason="the extra `robots` is not installed"
)

SCENE = """scene: panda
epsilon: 0.02
packages: {{example-robot-data: installed}}
robots:
  panda:
    urdf: package://example-robot-data/robots/panda_description/urdf/panda_collision.urdf
    base: {{position: [0, 0, 0]}}
    joints: [panda_joint1, panda_joint2, panda_joint3, panda_joint4, panda_joint5, panda_joint6, panda_joint7]
    {limits}
    gripper:
      joints: [panda_finger_joint1]
      open: {{panda_finger_joint1: 0.04}}
      closed: {{panda_finger_joint1: 0.0}}
      touch_links: [panda_leftfinger, panda_rightfinger]
    tool:
      frame: panda_hand
      features:
        tcp: {{point: [0, 0, 0.1034]}}
        approach: {{line: {{through: [0, 0, 0.1034], along: [0, 0, 1]}}}}
        closing: {{line: {{through: [0, 0, 0.1034], along: [0, 1, 0]}}}}
    configurations: {{home: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
models:
  can:
    cylinder: {{radius: {radius}, height: 0.12}}
    features:
      base: {{plane: {{through: [0, 0, -0.06], normal: [0, 0, 1]}}}}
    grasps:
      above:
        constraints:
          - coincident(tool.tcp, this.axis)
          - opposed(tool.approach, this.axis)
          - height(tool.tcp, this.base) in [0.08, 0.1]
        approach: {{along: tool.approach, distance: [0.05, 0.1]}}
        lift: {{along: world.up, distance: [0.05, 0.1]}}
        fingers: {{panda_finger_joint1: {fingers}}}
    placements:
      standing:
        constraints:
          - coincident(this.base, support.top)
          - aligned(this.axis, world.up)
          - inside(this, region)
        retreat: {{against: tool.approach, distance: [0.05, 0.1]}}
objects:
  table: {{box: [1.2, 1.6, 0.1], pose: {{position: [0.7, 0, -0.05]}}}}
regions:
  shelf:
    box: {box}
    pose: {{position: [0.45, 0.3, {middle}]}}
    support: table
"""


def panda(
    folder: Path,
    *,
    radius: float = 0.03,
    box: tuple[float, float, float] = (0.2, 0.2, 0.2),
    at: tuple[float, float, float] = (0.5, -0.2, 0.06),
    limits: str = "",
    more: str = "",
) -> Path:
    """A can that shall go from the table to a shelf that is flush with the table."""
    (folder / "scene.yaml").write_text(
        SCENE.format(radius=radius, fingers=min(radius, 0.04), box=list(box), middle=0.5 * box[2], limits=limits)
    )
    (folder / "domain.yaml").write_text(DOMAIN)
    bodies = f"can: {{model: can, pose: {{position: {list(at)}}}}}" + (f", {more}" if more else "")
    text = PROBLEM.format(things="can", bodies=bodies, goal="K(at(can, shelf))").replace("gantry", "panda")
    path = folder / "problem.yaml"
    path.write_text(text)
    return path


def warnings(path: Path) -> list[str]:
    scene = load_problem(path).scene
    assert scene is not None
    return [finding.message for finding in start_findings(scene)]


def reasons(path: Path) -> tuple[str, str]:
    result = solve(load_problem(path), max_samples=3000, timeout=300.0)
    assert result.reason is not None
    return result.status, "\n".join(result.reason.details)


def test_there_is_nothing_to_warn_of(tmp_path: Path) -> None:
    assert warnings(panda(tmp_path)) == []


def test_a_can_wider_than_the_hand_opens_is_told_with_both_and_proven(tmp_path: Path) -> None:
    path = panda(tmp_path, radius=0.0375 + 0.01)
    (said,) = warnings(path)
    assert "the gripper of panda opens 80 mm" in said and said.endswith("too little, proven")
    width = re.search(r"can is ([\d.]+) mm wide", said)
    assert width is not None and abs(float(width[1]) - 95.0) < 0.2


@pytest.mark.parametrize(
    ("box", "said"),
    [((0.2, 0.045, 0.2), "can is at least 60 mm wide along the y axis of shelf, which has 45 mm: 15 mm too much, proven"),
     ((0.2, 0.2, 0.113), "shelf is 7 mm too low, proven")],
)  # fmt: skip
def test_a_shelf_that_is_too_small_is_refused_by_a_proof(
    tmp_path: Path, box: tuple[float, float, float], said: str
) -> None:
    status, told = reasons(panda(tmp_path, box=box))
    assert status == "no_plan" and said in told


def test_a_joint_at_its_limit_is_named_with_a_value_that_does(tmp_path: Path) -> None:
    """The value is tried: with limits that reach as far there is a grasp, with less there is none."""

    def grasps(least: float) -> Stream:
        limits = f"limits: {{panda_joint4: [-140 deg, {least} deg]}}"
        scene = load_problem(panda(tmp_path, limits=limits, at=(0.68, -0.2, 0.06))).scene
        assert scene is not None
        loaded = load_scene(scene)
        robot, can = loaded.robots["panda"], loaded.bodies["can"]
        made = grasp_stream(robot, can, can.grasps["above"], world_T(loaded, loaded.start, "can"), (0.04,), 0)
        assert made is not None
        return made.stream

    short = limiting_joint(grasps(-130.0))
    assert short is not None and short.name == "panda.panda_joint4"
    need = float(np.degrees(short.found))
    assert (
        f"panda_joint4 of panda would have to be at {round(need, 1):g} deg, its limits are -140 deg" in short.text
    )
    assert grasps(need + 0.5).samples(0, 256) and not grasps(need - 3.0).samples(0, 256)


def test_a_can_that_begins_in_a_block_is_told(tmp_path: Path) -> None:
    (said,) = warnings(panda(tmp_path, more="block: {box: [0.3, 0.3, 0.3], pose: {position: [0.5, -0.2, 0.15]}}"))
    depth = re.match(r"can begins inside block, up to ([\d.]+) mm deep, proven", said)
    assert depth is not None and 110.0 < float(depth[1]) <= 120.0  # its highest point is 0.12 m above the floor
