"""How far a body is from its place when joints are off: never farther than the bound, against pinocchio."""

import numpy as np
import pytest

from kabo.language.scene_description import PoseDescription, RobotDescription
from kabo.scene import link_poses
from kabo.scene.urdf import load_robot
from kabo.viewer.content.plan.off_path import farthest_off
from tests.support.small_robots import write_arm


@pytest.mark.parametrize("link", ["upper", "lower", "left", "right"])
def test_a_body_is_never_farther_off_than_the_bound_nor_is_the_bound_far_off(tmp_path, link):
    robot = load_robot(RobotDescription("r", write_arm(tmp_path), PoseDescription()), np.eye(4), {})[0]
    random, tree = np.random.default_rng(1), robot.tree
    vertices = robot.links[link].mesh.vertices
    at_joint = vertices @ robot.links[link].joint_T_link[:3, :3].T + robot.links[link].joint_T_link[:3, 3]
    deviations = np.array([1e-3, 2e-3, 3e-3, 1e-3])
    radius = float(np.linalg.norm(at_joint, axis=1).max())
    bound = farthest_off(tree, robot.links[link].joint, radius, deviations)
    assert farthest_off(tree, robot.links[link].joint, radius, np.zeros(4)) == 0.0
    greatest = 0.0
    for _ in range(300):
        q = random.uniform(tree.lower, tree.upper)
        off = q + deviations * random.choice([-1.0, 1.0], 4)
        ends = [
            vertices @ pose[:3, :3].T + pose[:3, 3]
            for pose in (link_poses(robot, each)[link] for each in (q, off))
        ]
        greatest = max(greatest, float(np.linalg.norm(ends[1] - ends[0], axis=1).max()))
    assert 0.3 * bound < greatest <= bound
