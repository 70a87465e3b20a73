"""Grippers that are too weak for what they may grasp are told by `kabo check`."""

from pathlib import Path

import pytest

from kabo.language import load_scene_description
from kabo.scene import load_scene
from kabo.scene.findings import findings_in_scene
from tests.support.small_robots import write_arm

SCENE = """\
scene: small
epsilon: 0.01
robots:
  arm:
    urdf: small.urdf
    tool: {frame: hand, features: {tip: {point: [0, 0, 0]}}}
    gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}, «FORCE»}
models:
  can:
    box: [0.05, 0.05, 0.1]
    mass: 0.5
    grasps: {top: {constraints: ["coincident(tool.tip, this.center)"]}}
objects:
  can_1: {model: can, movable: true, pose: {position: [1, 0, 0]}}
  can_2: {model: can, movable: true, pose: {position: [2, 0, 0]}, mass: 2}
  other: {model: can, movable: true, pose: {position: [3, 0, 0]}, mass: 9, grasps: {}}
  fixed: {model: can, pose: {position: [4, 0, 0]}, mass: 9}
"""


def warnings(folder: Path, force: str) -> list[str]:
    write_arm(folder)
    path = folder / "scene.yaml"
    path.write_text(SCENE.replace("«FORCE»", force))
    found = findings_in_scene(load_scene_description(path))
    assert all((each.severity, each.line) == ("warning", 7) for each in found)
    return [f"{each.message} = {each.hint}" for each in found]


def test_what_cannot_be_held_at_rest_is_told_with_the_force_that_would_hold_it(tmp_path: Path) -> None:
    assert warnings(tmp_path, "force: 20, friction: 0.6") == [
        '"arm" cannot hold "can_2", even at rest: 2 kg weigh 19.6 N, friction 0.6 times force 20 N holds 12 N'
        " = write a force of at least 32.7 N, or the true mass and friction"
    ]
    assert 'cannot hold "can_1", "can_2", even' in warnings(tmp_path, "force: 5")[0]


@pytest.mark.parametrize("force", ["force: 40", "force: 32.8, friction: 0.6", "touch_links: []"])
def test_strong_grippers_and_those_without_a_force_are_not_warned_of(tmp_path: Path, force: str) -> None:
    assert warnings(tmp_path, force) == []


def test_the_bound_of_the_acceleration_is_friction_times_force_by_mass(tmp_path: Path) -> None:
    warnings(tmp_path, "force: 20, friction: 0.6")
    gripper = load_scene(tmp_path / "scene.yaml").robots["arm"].gripper
    assert gripper is not None and gripper.greatest_acceleration(0.5) == pytest.approx(24.0)
    assert gripper.greatest_acceleration(None) is None
