"""Checks the numbers of a segment: its joints, first configuration, joint limits, velocities and times."""

from collections.abc import Iterator

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.scene import Robot
from kabo.verify.report import Finding

CONTINUITY_TOLERANCE = 1e-6  # [rad, m, s] between the end of one motion and the beginning of the next
LIMIT_TOLERANCE = 1e-8  # [rad, m] by which rounded way points may exceed limits


def check_joints(node: str, segment: Segment, robot: Robot) -> Iterator[Finding]:
    """A finding unless the segment names all planned joints, or all gripper joints, in their order."""
    if segment.joints not in (robot.planned_joints, robot.gripper_joints) or not segment.joints:
        moved = ", ".join(segment.joints)
        text = f"a segment of {robot.name} moves {moved}: neither its planned joints nor its gripper's"
        yield Finding(node, text, segment.times[0])


def check_times(node: str, segment: Segment, earliest: float) -> Iterator[Finding]:
    """A finding unless the times increase, and begin no earlier than `earliest` [s], when the robot is free."""
    times = np.asarray(segment.times)
    if times[0] < earliest - CONTINUITY_TOLERANCE:
        text = f"a segment of {segment.robot} begins before the one before it has ended"
        yield Finding(node, text, float(times[0]))
    steps = np.diff(times)
    if (steps <= 0).any():
        yield Finding(node, "times do not increase", float(times[int((steps <= 0).argmax())]))


def check_numbers(node: str, segment: Segment, robot: Robot, start: Array) -> Iterator[Finding]:
    """The findings about continuity, limits and velocities of a segment.

    Args:
        node: the id of its node.
        segment: the segment, whose joints fit the robot, and whose times increase.
        robot: the robot.
        start: the configuration (n,) of all the robot's joints when the segment begins.
    """
    waypoints, times = np.asarray(segment.waypoints), np.asarray(segment.times)
    index = [robot.joint_names.index(joint) for joint in segment.joints]
    jump = np.abs(waypoints[0] - start[index])
    if jump.max() > CONTINUITY_TOLERANCE:
        joint = segment.joints[int(jump.argmax())]
        text = f"the motion jumps: {joint} of {robot.name} is {jump.max():.6g} away from where it was"
        yield Finding(node, text, float(times[0]), depth=float(jump.max()))
    if segment.trajectory is None:  # else its polynomials are judged
        yield from _check_velocities(node, segment, robot, waypoints, times, index)
    yield from _check_limits(node, segment, robot, waypoints, times, index)


def _check_velocities(node, segment, robot, waypoints, times, index) -> Iterator[Finding]:  # type: ignore[no-untyped-def]
    steps = np.diff(times)[:, None]
    over = np.abs(np.diff(waypoints, axis=0)) - robot.tree.velocity[index] * steps - LIMIT_TOLERANCE
    k, j = np.unravel_index(int(over.argmax()), over.shape)
    if over[k, j] > 0:
        speed = abs(waypoints[k + 1, j] - waypoints[k, j]) / steps[k, 0]
        limit = robot.tree.velocity[index[j]]
        text = f"{segment.joints[j]} of {robot.name} moves at {speed:.4g} per second, its limit is {limit:.4g}"
        yield Finding(node, text, float(times[k]), depth=float(speed - limit))


def _check_limits(node, segment, robot, waypoints, times, index) -> Iterator[Finding]:  # type: ignore[no-untyped-def]
    over = np.maximum(robot.tree.lower[index] - waypoints, waypoints - robot.tree.upper[index]) - LIMIT_TOLERANCE
    k, j = np.unravel_index(int(over.argmax()), over.shape)
    if over[k, j] > 0:
        where = f"at {waypoints[k, j]:.6g}, beyond its limit by {over[k, j]:.3g}"
        text = f"{segment.joints[j]} of {robot.name} is {where}"
        yield Finding(node, text, float(times[k]), depth=float(over[k, j]))
