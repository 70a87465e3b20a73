"""The limits of a robot's motion: velocities of its URDF, accelerations and jerks of its scene or by default."""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.motion import MotionLimits
from kabo.scene.robots import Robot

RAMP = 0.25  # s from rest to the limit of velocity, where the scene sets no acceleration
ONSET = 0.05  # s from rest to the limit of acceleration, where the scene sets no jerk


def motion_limits(robot: Robot, joints: Sequence[str]) -> MotionLimits:
    """The limits of some of a robot's joints; arms and grippers, plans and tasks are timed by these alone.

    A joint whose acceleration the scene does not limit reaches full velocity in `RAMP` seconds; one without a limit of
    jerk reaches full acceleration in `ONSET` seconds.
    """
    index = robot.columns(joints)
    velocity = np.asarray(robot.tree.velocity, float)[index]
    acceleration = _of(robot.acceleration, joints, velocity / RAMP)
    return MotionLimits(velocity, acceleration, _of(robot.jerk, joints, acceleration / ONSET))


def _of(given: Mapping[str, float], joints: Sequence[str], default: Array) -> Array:
    pairs = zip(joints, default, strict=True)
    return np.array([float(given.get(joint, value)) for joint, value in pairs])
