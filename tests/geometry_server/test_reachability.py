"""Proofs that something is out of reach, of robots that drive: wherever on its floor the base stands."""

from dataclasses import replace

import numpy as np

from kabo.geometry_server import GeometryServer, grasp_roles, grasp_stream, standing_of, tool_frame
from kabo.geometry_server.reachability import base_distance, grasp_missing, region_missing
from kabo.kinematics import FrameFeature
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
            point = FrameFeature(0, "point", (x, y, 0.4))
            drive = ROBOT.drive
            assert drive is not None
            for found in made.stream.samples(0, 64):
                axis = drive.world_T_floor[:3, :2] @ found.q[:2] + drive.world_T_floor[:3, 3]
                assert base_distance(ROBOT, point) <= np.linalg.norm(axis - np.array([x, y, 0.4])) + 1e-9


def test_a_region_on_a_table_of_the_room_is_within_reach_and_one_far_outside_is_not() -> None:
    counter = SCENE.regions["counter"]
    tool = tool_frame(ROBOT)
    assert region_missing(ROBOT, CUP, counter, tool) <= 0.0
    far = counter.world_T_region.copy()
    far[0, 3] += 6.0
    told = region_missing(ROBOT, CUP, replace(counter, world_T_region=far), tool)
    assert told > 3.0
