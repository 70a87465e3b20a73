"""Baxter's right arm picks and places with the scene that `kabo robot` writes, and one pair allowed that it names."""

from pathlib import Path

import pytest

import kabo
from kabo.language.recorded_paths import installed_folder

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        installed_folder("example-robot-data") is None, reason="example-robot-data is not installed"
    ),
]

OBJECTS = """
models:
  can:
    cylinder: {radius: 0.018, height: 0.1}
    movable: true
    grasps:
      above:
        constraints:
          - coincident(tool.tcp, this.axis)
          - opposed(tool.approach, this.axis)
          - height(tool.tcp, this.top) in [-0.03, -0.015]
        approach: {along: tool.approach, distance: [0.06, 0.12]}
        lift: {along: world.up, distance: [0.05, 0.12]}
        fingers: {r_gripper_l_finger_joint: 0.0147}
    placements:
      standing:
        constraints:
          - coincident(this.bottom, support.top)
          - aligned(this.axis, world.up)
          - inside(this, region)
        retreat: {against: tool.approach, distance: [0.06, 0.12]}

objects:
  table: {box: [0.5, 0.9, 0.04], pose: {position: [0.85, -0.3, -0.12]}}
  can_1: {model: can, pose: {frame: table, position: [-0.1, 0.05, 0.07]}}
  tray: {box: [0.25, 0.25, 0.02], pose: {frame: table, position: [-0.1, -0.25, 0.03]}}

regions:
  bin: {box: [0.25, 0.25, 0.2], pose: {frame: tray, position: [0, 0, 0.09]}, support: tray}

allowed_contacts:
  - [tray, table]
  - [arm.right_wrist, arm.right_upper_forearm_visual]
"""
DOMAIN = """
domain: tidy_up
types: [robot, can, place]
constants:
  place: [bin]
predicates:
  free_hand: [robot]
  holds: [robot, can]
  binned: [can]
actions:
  pick_up:
    parameters: {r: robot, c: can}
    preconditions:
      - K(free_hand(r))
      - K(not binned(c))
    geometry: pick(r, c)
    effects:
      - add(Kf, holds(r, c), not free_hand(r))
  throw_away:
    parameters: {r: robot, c: can}
    preconditions:
      - K(holds(r, c))
    geometry: place(r, c, bin)
    effects:
      - add(Kf, not holds(r, c), free_hand(r), binned(c))
"""
PROBLEM = """
problem: one_can
domain: domain.yaml
scene: scene.yaml
objects:
  robot: [arm]
  can: [can_1]
initial:
  - add(Kf, free_hand(arm), not binned(can_1))
goal:
  - K(binned(can_1))
"""


def test_what_kabo_robot_writes_of_baxter_suffices_for_a_plan_that_is_verified(tmp_path: Path) -> None:
    folder = installed_folder("example-robot-data")
    assert folder is not None
    urdf = folder / "robots" / "baxter_description" / "urdf" / "baxter.urdf"
    # Its shoulder and its elbow are 1.1 mm apart at best: a coarser epsilon takes that for a contact, and says so.
    written = kabo.robot_scene(urdf, name="arm", tip="right_gripper", epsilon=0.001, folder=tmp_path)
    assert "#   - [right_wrist, right_upper_forearm_visual]  # at " in written
    (tmp_path / "scene.yaml").write_text(written + OBJECTS)
    (tmp_path / "domain.yaml").write_text(DOMAIN)
    (tmp_path / "problem.yaml").write_text(PROBLEM)
    problem = kabo.load_problem(tmp_path / "problem.yaml")
    result = kabo.solve(problem)
    assert result.plan is not None, result.reason
    report = kabo.verify(problem, result.plan)
    assert report.ok, str(report)
