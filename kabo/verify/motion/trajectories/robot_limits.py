"""The limits of a robot's joints as the scene gives them: velocity, acceleration and jerk [docs/reference/scenes.md]."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.scene import Robot
from kabo.verify.motion.arms import Arm

ACCELERATION_TIME = 0.25  # [s] from rest to the velocity limit, where the scene names no acceleration
JERK_TIME = 0.05  # [s] from no acceleration to the limit, where the scene names no jerk
KINDS = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class JointLimits:
    """The limits of all joints of a robot (n,), in rad or m, and s: positions, and sizes of three derivatives."""

    lower: Array
    upper: Array
    derivatives: tuple[Array, Array, Array]


def joint_limits(robot: Robot) -> JointLimits:
    """The limits of a robot: of the URDF, narrowed by the scene, and the defaults for what neither of them says."""
    tree, names = robot.tree, robot.joint_names
    velocity = np.asarray(tree.velocity, np.float64)
    acceleration = _named(robot.acceleration, velocity / ACCELERATION_TIME, names)
    jerk = _named(robot.jerk, acceleration / JERK_TIME, names)
    return JointLimits(np.asarray(tree.lower), np.asarray(tree.upper), (velocity, acceleration, jerk))


def _named(given: Mapping[str, float], default: Array, names: tuple[str, ...]) -> Array:
    """The values that the scene gives to some of the joints; the default for the others."""
    return np.array([given.get(name, float(value)) for name, value in zip(names, default, strict=True)])


def unit_of(arm: Arm, index: int, order: int = 0) -> str:
    """The unit of a joint's value or of a derivative: `rad`, `m/s²`."""
    sources, ratios = arm.robot.actuation.source, arm.robot.actuation.ratio
    own = [j for j in range(1, len(arm.parents)) if ratios[j] != 0.0 and sources[j] == index]
    length = "rad" if own and arm.revolute[own[0]] else "m"
    return length + ("", "/s", "/s²", "/s³")[order]
