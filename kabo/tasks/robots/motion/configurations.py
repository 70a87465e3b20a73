"""Configurations by name, by values or by joints, as the properties `goal` and `configurations` of stages have them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.errors import did_you_mean
from kabo.scene import Robot
from kabo.tasks.robots.scenes import TaskScene

OPEN, CLOSED = "open", "closed"
SAME_VALUE = 1e-9  # rad or m: values are rounded so


class NoConfigurationError(ValueError):
    """An error: the robot has no configuration, or no joint, of a given name."""


class BeyondLimitsError(NoConfigurationError):
    """An error: a joint of a configuration is beyond its limits."""


def goal_of(scene: TaskScene, name: str, wanted: Any) -> Array:
    """The configuration (n,) of all joints that a goal describes; joints that it does not mention keep their values.

    Args:
        scene: the scene with the robot's present configuration.
        name: the robot.
        wanted: the name of a configuration, `open`, `closed`, values of the arm's (or all) joints, {joint: value}.

    Raises:
        NoConfigurationError: the robot has no such configuration or joint.
        BeyondLimitsError: a joint is beyond its limits.
        ValueError: the number of values is wrong.
    """
    return configured(scene.robot(name), scene.configuration(name), wanted)


def configured(robot: Robot, q: Array, wanted: Any) -> Array:
    """As `goal_of`, from the configuration `q` (n,) of a robot.

    Raises:
        NoConfigurationError, BeyondLimitsError, ValueError: as `goal_of`.
    """
    if isinstance(wanted, str):
        if wanted in (OPEN, CLOSED) and wanted not in robot.configurations:
            return with_joints(robot, q, hand(robot, wanted))
        values: Any = robot.configurations.get(wanted)
        if values is None:
            hint = did_you_mean(wanted, robot.configurations) or ""
            raise NoConfigurationError(
                f"{robot.name} has no configuration {wanted!r}{', ' + hint if hint else ''}"
            )
        return rounded(np.concatenate([values, q[robot.planned :]]))
    if isinstance(wanted, Mapping):
        return _within(robot, with_joints(robot, q, wanted), wanted)
    if isinstance(wanted, (Sequence, np.ndarray)) and len(wanted) in (robot.planned, len(q)):
        given = rounded(np.concatenate([np.asarray(wanted, float), q[len(wanted) :]]))
        return _within(robot, given, robot.joint_names[: len(wanted)])
    raise ValueError(f"{robot.name} has {robot.planned} planned joints: {wanted!r} is no configuration of it")


def hand(robot: Robot, wanted: str) -> Mapping[str, float]:
    """The values of the gripper's joints when `open` or `closed`; empty without a gripper."""
    if robot.gripper is None:
        return {}
    values = robot.gripper.open if wanted == OPEN else robot.gripper.closed
    return {joint: value for joint, value in values.items() if joint in robot.gripper_joints}


def with_joints(robot: Robot, q: Array, values: Mapping[str, float]) -> Array:
    """The configuration with the values of some joints replaced.

    Raises:
        NoConfigurationError: the robot has no such joint.
    """
    result = q.copy()
    for joint, value in values.items():
        if joint not in robot.joint_names:
            hint = did_you_mean(joint, robot.joint_names) or f"it has {', '.join(robot.joint_names)}"
            raise NoConfigurationError(f"{robot.name} has no joint {joint!r}, {hint}")
        result[robot.joint_names.index(joint)] = float(value)
    return rounded(result)


def _within(robot: Robot, q: Array, joints: Iterable[str]) -> Array:
    """The configuration, if the given joints are within their limits.

    Raises:
        BeyondLimitsError: names the first that is not.
    """
    for joint in joints:
        i = robot.joint_names.index(joint)
        low, high = robot.tree.lower[i], robot.tree.upper[i]
        if not low - SAME_VALUE <= q[i] <= high + SAME_VALUE:
            raise BeyondLimitsError(
                f"{robot.name}.{joint} would be at {q[i]:.6g}, outside its limits {low:.6g} to {high:.6g}"
            )
    return q


def rounded(q: Array) -> Array:
    """A configuration rounded to the precision in which plans store it."""
    return np.asarray(np.round(q, 9) + 0.0)
