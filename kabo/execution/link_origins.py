"""The origins of a robot's links, by which it is judged how far a robot is off and how fast it moves."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array, Integers
from kabo.execution.kernels.origins import origins_of
from kabo.scene import KinematicTree, Robot


@dataclass(frozen=True)
class LinkOrigins:
    """The origins of all links of one robot, as points (L, 3) in the frames of joints (L,)."""

    tree: KinematicTree
    joints: Integers
    offsets: Array

    @classmethod
    def of(cls, robot: Robot) -> "LinkOrigins":
        """Those of a robot, computed once."""
        found: LinkOrigins | None = robot.memory.get(cls)
        if found is None:
            links = robot.links.values()
            joints = np.array([link.joint for link in links], np.int64)
            found = cls(robot.tree, joints, np.array([link.joint_T_link[:3, 3] for link in links]).reshape(-1, 3))
            robot.memory[cls] = found
        return found

    def at(self, configurations: ArrayLike) -> Array:
        """The origins (N, L, 3) in the world at configurations (N, n) of all joints [m]."""
        found: Array = origins_of(np.asarray(configurations, np.float64), self.tree, self.joints, self.offsets)
        return found

    def farthest(self, first: Sequence[float], second: Sequence[float]) -> float:
        """How far any origin is from where it is at another configuration [m]."""
        found = self.at([first, second])
        off = found[0] - found[1]
        return float(np.sqrt(np.einsum("ij,ij->i", off, off).max(initial=0.0)))
