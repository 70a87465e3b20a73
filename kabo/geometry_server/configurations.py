"""Configurations of a tree of joints, and the poses that joints and frames have there."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.frames import Frame
from kabo.kinematics import joint_poses
from kabo.scene import KinematicTree, Robot
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.transforms import unflat


@dataclass(frozen=True)
class Candidate:
    """A configuration (n,) of all joints of a tree."""

    q: Array
    tree: KinematicTree = field(compare=False, repr=False)

    @cached_property
    def joints(self) -> Array:
        """The poses (J, 12) of the tree's joints, which most candidates are not asked for."""
        return joints_at(self.tree, self.q)

    def pose(self, frame: Frame) -> Array:
        """The pose (4, 4) in the world of a frame of the robot's tree."""
        return unflat(self.joints[frame.joint]) @ frame.joint_T_frame


def joints_at(tree: KinematicTree, q: Array) -> Array:
    """The poses (J, 12) of all joints of a tree in the world."""
    world_T = np.zeros((len(tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T)
    return world_T


def candidate(robot: Robot, q: Sequence[float] | Array) -> Candidate:
    """The candidate with a given configuration."""
    return Candidate(np.array(q, dtype=np.float64), robot.tree)


def poses_at(robot: Robot, frame: Frame, configurations: Array) -> Array:
    """The poses (N, 4, 4) in the world of a frame of a robot's tree at configurations (N, n)."""
    joint_T: Array = np.zeros((len(configurations), 4, 4))
    found = joint_poses(robot.tree, frame.joint, configurations)
    joint_T[:, :3, :3], joint_T[:, :3, 3] = found[:, :9].reshape(-1, 3, 3), found[:, 9:]
    joint_T[:, 3, 3] = 1.0
    return joint_T @ frame.joint_T_frame
