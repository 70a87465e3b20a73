"""Joints that the constraints of a sample do not read: at home in most samples, so that an arm is not in its own way."""

from pathlib import Path

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer
from kabo.geometry_server.sight.viewpoints import viewpoints
from kabo.geometry_server.situation import Situation
from kabo.language import load_scene_description
from kabo.scene import Scene, load_scene
from tests.support.small_robots import ARM

HEAD = """  <link name="head"/>
  <link name="eye"/>
  <joint name="pan" type="revolute"><parent link="base"/><child link="head"/><origin xyz="0 0 0.9"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="tilt" type="revolute"><parent link="head"/><child link="eye"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="3" velocity="1" effort="1"/></joint>
</robot>
"""
SCENE = """scene: s
epsilon: 0.01
robots:
  arm:
    urdf: small.urdf
    joints: [shoulder, elbow, turn, pan, tilt]
    gripper: {joints: [finger], open: {finger: 0.04}, closed: {finger: 0}, touch_links: [left, right]}
    configurations: {home: [0.4, -0.3, 0.2, 0, 0]}
    sensors:
      look: {frame: eye, field_of_view: 60 deg, range: [0.2, 3]}
      hand: {frame: hand, field_of_view: 60 deg, range: [0.1, 3]}
objects:
  box: {box: [0.05, 0.05, 0.05], pose: {position: [0.5, 0.1, 0.8]}}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    (tmp_path / "small.urdf").write_text(ARM.replace("</robot>\n", HEAD))
    (tmp_path / "scene.yaml").write_text(SCENE)
    return load_scene(load_scene_description(tmp_path / "scene.yaml"))


def samples(scene: Scene, sensor: str) -> np.ndarray:
    robot, server = scene.robots["arm"], GeometryServer(scene)
    found = viewpoints(server.surroundings, Situation.of(scene.start), robot, robot.sensors[sensor], "box", 0)
    return np.array([each.q for each in found.stream.samples(0, 64)])


def test_the_arm_stays_at_home_in_three_of_four_looks_of_the_head(scene: Scene) -> None:
    found = samples(scene, "look")
    assert len(found) > 20
    still = np.all(found[:, :3] == [0.4, -0.3, 0.2], axis=1)
    assert 0.6 < still.mean() < 0.9  # the others are at random: at home the arm may hide the box
    assert np.ptp(found[:, 3:5], axis=0).max() < 1e-5  # the head looks at the box in all of them


def test_the_head_stays_at_home_in_looks_of_the_hand(scene: Scene) -> None:
    found = samples(scene, "hand")
    assert len(found) > 10
    assert 0.6 < np.all(found[:, 3:5] == 0.0, axis=1).mean() < 0.95
    assert np.ptp(found[:, 0]) > 0.1


def test_which_values_move_a_joint(scene: Scene) -> None:
    robot = scene.robots["arm"]
    names = {link: robot.links[link].joint for link in ("eye", "right", "base")}
    moving = {
        link: [robot.joint_names[i] for i in np.flatnonzero(robot.moving([joint]))]
        for link, joint in names.items()
    }
    assert moving == {"eye": ["pan", "tilt"], "right": ["shoulder", "elbow", "turn", "finger"], "base": []}
    assert {robot.joint_names[i] for i in robot.values_between("left", "right")} == {"finger"}
    assert {robot.joint_names[i] for i in robot.values_between("upper", "eye")} == {"shoulder", "pan", "tilt"}
