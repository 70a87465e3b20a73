"""Proofs that something is out of reach, of arms, of two arms on one trunk, and of robots that drive."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from kabo.geometry_server import GeometryServer, candidate, grasp_roles, grasp_stream, standing_of, tool_frame
from kabo.geometry_server.frames import Frame
from kabo.geometry_server.reachability import grasp_missing, least_distance, region_missing
from kabo.kinematics import FrameFeature
from kabo.language.scene_description import Feature
from kabo.scene import Robot, load_scene
from tests.domains.scenes import DOMAINS, scene_of

SCENE = scene_of(DOMAINS / "waiter" / "two_cups.yaml")
ROBOT = SCENE.robots["waiter"]
CUP = SCENE.bodies["cup_1"]


def missing(x: float, y: float) -> float:
    """How far a cup on the floor there is beyond the reach of the waiter, at least [m]."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, 0.4
    family = CUP.grasps["side"]
    roles = grasp_roles(ROBOT, CUP, family, pose)
    assert roles is not None
    return grasp_missing(ROBOT, family.constraints, roles)


def test_nothing_that_a_sample_reaches_is_said_to_be_out_of_reach() -> None:
    standing = standing_of(GeometryServer(SCENE).surroundings, ROBOT)
    hand = SCENE.start.robots["waiter"][ROBOT.planned :]
    for x, y in ((-1.6, 0.8), (2.3, 0.0), (-2.4, -1.5), (0.0, 2.0)):
        pose = np.eye(4)
        pose[:3, 3] = x, y, 0.4
        made = grasp_stream(ROBOT, CUP, CUP.grasps["side"], pose, hand, 0, standing)
        assert made is not None
        if made.stream.samples(0, 64):
            assert missing(x, y) <= 0.0


def test_a_region_on_a_table_of_the_room_is_within_reach_and_one_far_outside_is_not() -> None:
    counter = SCENE.regions["counter"]
    tool = tool_frame(ROBOT)
    assert region_missing(ROBOT, CUP, counter, tool) <= 0.0
    far = counter.world_T_region.copy()
    far[0, 3] += 6.0
    told = region_missing(ROBOT, CUP, replace(counter, world_T_region=far), tool)
    assert told > 3.0


TRUNK = """<robot name="twins">
  <link name="base"/><link name="mast"/>
  <joint name="up" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="2.5 0 1"/></joint>
  {arms}
</robot>
"""
ARM = """<link name="{side}_upper"/><link name="{side}_lower"/><link name="{side}_hand"/>
  <joint name="{side}_shoulder" type="revolute"><parent link="base"/><child link="{side}_upper"/><origin xyz="0 {y} 0.5"/>
    <axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
  <joint name="{side}_elbow" type="revolute"><parent link="{side}_upper"/><child link="{side}_lower"/>
    <origin xyz="0.3 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="{side}_stroke" type="prismatic"><parent link="{side}_lower"/><child link="{side}_hand"/>
    <origin xyz="0.1 0 0"/><axis xyz="1 0 0"/><limit lower="0.05" upper="0.2" velocity="1" effort="1"/></joint>
"""
TWINS = """scene: twins
epsilon: 0.01
robots:
  twins:
    urdf: twins.urdf
    base: {position: [0.4, -0.2, 0.3]}
    joints: [left_shoulder, left_elbow, left_stroke, right_shoulder, right_elbow]
    tool: {frame: right_hand, features: {tcp: {point: [0.02, 0, 0.01]}}}
    configurations: {home: [0, 0, 0.1, 0, 0]}
"""


def twins(folder: Path) -> Robot:
    """A robot with two arms 1.6 m apart, of which the first has the first joints, and a mast that nothing moves."""
    arms = "".join(ARM.format(side=side, y=y) for side, y in (("left", 0.8), ("right", -0.8)))
    (folder / "twins.urdf").write_text(TRUNK.format(arms=arms))
    (folder / "scene.yaml").write_text(TWINS)
    return load_scene(folder / "scene.yaml").robots["twins"]


def test_no_point_of_a_robot_is_ever_nearer_than_its_least_distance(tmp_path: Path) -> None:
    numbers, told = np.random.default_rng(3), 0
    for robot in (twins(tmp_path), ROBOT, *scene_of(DOMAINS / "stacked" / "n2.yaml").robots.values()):
        low, high = np.maximum(robot.tree.lower, -4.0), np.minimum(robot.tree.upper, 4.0)
        for _ in range(300):
            link = list(robot.links.values())[numbers.integers(len(robot.links))]
            own = Feature("point", tuple(numbers.normal(0.0, 0.1, 3).tolist()))
            point = Frame(link.joint, link.joint_T_link, {}).moved(own)
            at = candidate(robot, numbers.uniform(low, high))
            where = at.pose(Frame(link.joint, link.joint_T_link, {})) @ (*own.origin, 1.0)
            other, along = numbers.normal(0.0, 2.0, 3), numbers.normal(0.0, 1.0, 3)
            along /= np.linalg.norm(along)
            there, direction = (float(v) for v in other), (float(v) for v in along)
            target = FrameFeature(0, "point", tuple(there))
            least = least_distance(robot, point, target)
            assert least <= np.linalg.norm(where[:3] - other) + 1e-9
            told += least > 0.0
            plane = FrameFeature(0, "plane", target.origin, tuple(direction))
            assert least_distance(robot, point, plane) <= abs(along @ (where[:3] - other)) + 1e-9
    assert told > 100


def test_the_reach_of_an_arm_is_counted_from_its_own_shoulder(tmp_path: Path) -> None:
    robot = twins(tmp_path)
    tcp = tool_frame(robot).feature("tcp")
    shoulder = np.array([0.4, -1.0, 0.8])
    lengths = (
        0.3 + 0.1 + 0.05 + float(np.hypot(0.02, 0.01))
    )  # the stroke is none of its joints: it stays at its least
    for away in (0.5, 1.0, 3.0):
        x, y, z = (shoulder + (0.0, -away, 0.0)).tolist()
        assert abs(least_distance(robot, tcp, FrameFeature(0, "point", (x, y, z))) - (away - lengths)) < 1e-5
