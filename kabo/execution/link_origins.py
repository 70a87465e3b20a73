"""The origins of a robot's links, by which it is judged how far a robot is off and how fast it moves."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array, Integers
from kabo.execution.kernels.origins import farthest_origins, origins_of
from kabo.scene import KinematicTree, Robot


@dataclass(frozen=True)
class LinkOrigins:
    """The origins of all links of one robot, as points (L, 3) in the frames of joints (L,)."""

    tree: KinematicTree
    joints: Integers
    offsets: Array
    planned: int  # joints of a configuration, which come first

    @classmethod
    def of(cls, robot: Robot) -> "LinkOrigins":
        """Those of a robot, computed once."""
        found: LinkOrigins | None = robot.memory.get(cls)
        if found is None:
            links = robot.links.values()
            joints = np.array([link.joint for link in links], np.int64)
            offsets = np.array([link.joint_T_link[:3, 3] for link in links]).reshape(-1, 3)
            found = cls(robot.tree, joints, offsets, robot.planned)
            robot.memory[cls] = found
        return found

    def at(self, configurations: ArrayLike) -> Array:
        """The origins (N, L, 3) in the world at configurations (N, n) of all joints [m]."""
        found: Array = origins_of(np.asarray(configurations, np.float64), self.tree, self.joints, self.offsets)
        return found

    def farthest(self, configurations: ArrayLike, actual: ArrayLike) -> Array:
        """How far any origin is at configurations (N, n) from where it is at `actual` (n,): (N,) [m].

        Joints that are not planned are as they actually are: hands close as far as they find room.
        """
        rows, here = np.asarray(configurations, np.float64), np.asarray(actual, np.float64)
        found: Array = farthest_origins(rows, here, self.planned, self.tree, self.joints, self.offsets)
        return found
