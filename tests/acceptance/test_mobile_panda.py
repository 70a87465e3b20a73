"""A robot of others on a platform of boxes, between two tables: from the URDF to a verified plan, as a user runs it."""

from pathlib import Path

import pytest

import kabo
from kabo.language.recorded_paths import installed_folder

PUBLIC = installed_folder("example-robot-data")
PANDA = "robots/panda_description/urdf/panda.urdf"
PLATFORM = """
  <link name="platform">
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.6 0.45 0.38"/></geometry></collision>
  </link>
  <joint name="mount" type="fixed"><parent link="platform"/><child link="panda_link0"/><origin xyz="0.1 0 0.4"/></joint>
</robot>"""
LINKS = [f"panda_link{k}" for k in range(8)] + ["panda_hand", "panda_leftfinger", "panda_rightfinger"]
SCENE = f"""scene: two_tables
epsilon: 0.01
packages: {{example-robot-data: installed}}
robots:
  panda:
    urdf: mobile_panda.urdf
    base: {{moves: {{within: hall}}}}
    joints: [{", ".join(f"panda_joint{k}" for k in range(1, 8))}]
    inverse_kinematics: analytic
    hulls: [{", ".join(LINKS)}]
    gripper:
      joints: [panda_finger_joint1]
      open: {{panda_finger_joint1: 0.04}}
      closed: {{panda_finger_joint1: 0}}
      touch_links: [panda_leftfinger, panda_rightfinger]
    tool:
      frame: panda_hand
      features:
        tcp: {{point: [0, 0, 0.1]}}
        approach: {{line: {{through: [0, 0, 0.1], along: [0, 0, 1]}}}}
        closing: {{line: {{through: [0, 0, 0.1], along: [0, 1, 0]}}}}
    configurations: {{home: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
models:
  cup:
    cylinder: {{radius: 0.03, height: 0.12}}
    grasps:
      side:
        constraints:
          - coincident(tool.tcp, this.axis)
          - perpendicular(tool.approach, this.axis)
          - perpendicular(tool.closing, this.axis)
          - distance(tool.tcp, this.center) <= 0.02
        approach: {{along: tool.approach, distance: [0.05, 0.12]}}
        lift: {{along: world.up, distance: [0.03, 0.12]}}
        fingers: {{panda_finger_joint1: 0.032}}
    placements:
      standing:
        constraints:
          - coincident(this.bottom, support.top)
          - aligned(this.axis, world.up)
          - inside(this, region)
        retreat: {{against: tool.approach, distance: [0.05, 0.12]}}
objects:
  floor: {{box: [7, 5, 0.02], pose: {{position: [0, 0, -0.01]}}}}
  table_a: {{box: [0.8, 1.2, 0.7], pose: {{position: [-2.5, 0, 0.35]}}}}
  table_b: {{box: [0.8, 1.2, 0.7], pose: {{position: [2.5, 0.5, 0.35]}}}}
  wall: {{box: [0.1, 2.6, 1.6], pose: {{position: [1.1, 0.5, 0.8]}}}}
regions:
  hall: {{box: [6.6, 4.6, 0.1]}}
  there: {{box: [0.7, 1.1, 0.4], pose: {{frame: table_b, position: [0, 0, 0.54]}}, support: table_b}}
allowed_contacts:
  - [panda.platform, floor]
  - [table_a, floor]
  - [table_b, floor]
  - [wall, floor]
"""
DOMAIN = """domain: fetch
types: [robot, cup, location]
constants: {location: [there]}
predicates:
  holds: [robot, cup]
  at_location: [cup, location]
actions:
  take:
    parameters: {r: robot, o: cup}
    preconditions:
      - K(not holds(r, o))
    geometry: pick(r, o)
    effects:
      - add(Kf, holds(r, o))
  bring:
    parameters: {r: robot, o: cup, l: location}
    preconditions:
      - K(holds(r, o))
    geometry: place(r, o, l)
    effects:
      - add(Kf, not holds(r, o), at_location(o, l))
"""
PROBLEM = """problem: one_cup
domain: domain.yaml
scene: scene.yaml
objects: {robot: [panda], cup: [cup]}
bodies:
  cup: {model: cup, pose: {frame: table_a, position: [0.1, 0.3, 0.41]}}
initial:
  - add(Kf, not holds(panda, cup))
goal:
  - K(at_location(cup, there))
"""


@pytest.mark.slow
@pytest.mark.skipif(PUBLIC is None, reason="example-robot-data is not installed")
def test_a_panda_on_a_platform_brings_a_cup_from_one_table_to_the_other(tmp_path: Path) -> None:
    assert PUBLIC is not None
    urdf = (Path(PUBLIC) / PANDA).read_text().replace("</robot>", PLATFORM)
    for name, text in {"mobile_panda.urdf": urdf, "scene.yaml": SCENE, "domain.yaml": DOMAIN}.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "problem.yaml").write_text(PROBLEM)
    problem = kabo.load_problem(tmp_path / "problem.yaml")
    result = kabo.solve(problem)
    assert result.status == "solved" and result.plan is not None
    assert kabo.verify(problem, result.plan).ok
