"""What a robot server checks of a motion before its robots move: whatever a client sends, limits hold.

Names are those of the scene; no joint is in two trajectories at once; each begins and ends at rest or goes on where the one
before has ended; positions, velocities, accelerations and jerks are within the limits of the joints; and it begins where
the robots are.
"""

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.execution import CLOSED_ON_NOTHING, SAME_TIME, Motion, RobotState, Stretch
from kabo.motion import Trajectory
from kabo.remote.messages import MAX_SECONDS
from kabo.scene import Robot, Scene, motion_limits
from kabo.service import Unreadable

BEGIN_WITHIN = 0.01  # rad or m by which a joint of an arm may be away from where its motion begins
ROOM = 1e-3  # share of a limit by which bounds may exceed it: they are a little wider than what they bound
SAME_PLACE, SAME_VELOCITY = 1e-6, 1e-5  # rad or m, and per second, at borders of pieces and of trajectories
SAME_ACCELERATION = 1e-3  # share of the limit, at borders of pieces
HALVINGS = 5
ORDERS = (("velocity", 1), ("acceleration", 2), ("jerk", 3))


def check_motion(motion: Motion, scene: Scene) -> None:
    """Checks all of a motion that does not depend on where the robots are.

    Raises:
        Unreadable: says what is wrong.
    """
    if not (isfinite(motion.begin) and isfinite(motion.end) and 0.0 <= motion.end - motion.begin <= MAX_SECONDS):
        raise Unreadable(f"a motion lasts from 0 to {MAX_SECONDS:g} s")
    for stretch in motion.stretches:
        robot = scene.robots.get(stretch.robot)
        if robot is None:
            raise Unreadable(f"there is no robot {stretch.robot!r}")
        unknown = sorted(set(stretch.trajectory.joints) - set(robot.joint_names))
        if unknown or len(set(stretch.trajectory.joints)) < len(stretch.trajectory.joints):
            raise Unreadable(
                f"{stretch.robot} has no joint {unknown[0]!r}" if unknown else "a joint is named twice"
            )
        if not motion.begin - SAME_TIME <= stretch.begin < stretch.end <= motion.end + SAME_TIME:
            raise Unreadable("a trajectory begins before its motion, or ends after it")
        _require_limits(stretch, robot)
        _require_smooth(stretch.trajectory, stretch.robot, robot)
    for (name, joint), parts in _by_joint(motion).items():
        _require_joined(f"{name}.{joint}", parts, scene.robots[name], joint)


def check_begin(motion: Motion, state: RobotState, scene: Scene) -> None:
    """Checks that a motion begins where the robots are, as far as it is known by how much joints may be off.

    Raises:
        Unreadable: names a joint, where it is, and where the motion begins.
    """
    for (name, joint), parts in _by_joint(motion).items():
        robot = scene.robots[name]
        index = robot.joint_names.index(joint)
        here, there = state.positions[name][index], _at(parts[0], 0)[0]
        if abs(here - there) > _within(robot, joint):
            raise Unreadable(
                f"{name}.{joint} is at {here:.6g}, and the motion begins at {there:.6g}: "
                f"{_within(robot, joint):.3g} apart at most"
            )


def _within(robot: Robot, joint: str) -> float:
    """How far a joint may be from where its motion begins; fingers close as far as they find room."""
    if robot.gripper is None or joint not in robot.gripper.joints:
        return BEGIN_WITHIN
    stroke = abs(robot.gripper.open.get(joint, 0.0) - robot.gripper.closed.get(joint, 0.0))
    return max(BEGIN_WITHIN, CLOSED_ON_NOTHING * stroke)


def _require_limits(stretch: Stretch, robot: Robot) -> None:
    """Bounds of each joint's whole range are compared with its limits."""
    trajectory = stretch.trajectory
    index = robot.columns(trajectory.joints)
    lower, upper = np.asarray(robot.tree.lower)[index], np.asarray(robot.tree.upper)[index]
    low, high = trajectory.bounds(halvings=HALVINGS)
    room = ROOM * np.where(np.isfinite(upper - lower), upper - lower, 0.0)
    _require(trajectory, (low >= lower - room) & (high <= upper + room), f"of {stretch.robot} leaves its range")
    limits = motion_limits(robot, trajectory.joints)
    for name, order in ORDERS:
        low, high = trajectory.bounds(order, halvings=HALVINGS)
        within = np.maximum(np.abs(low), np.abs(high)) <= getattr(limits, name) * (1.0 + ROOM)
        _require(trajectory, within, f"of {stretch.robot} exceeds its limit of {name}")


def _require_smooth(trajectory: Trajectory, name: str, robot: Robot) -> None:
    """Neither position, velocity nor acceleration jumps between two pieces."""
    powers, spans = trajectory.padded, trajectory.spans[:-1, None, None]
    for most in _jumps(robot, trajectory.joints):
        before = (powers[:-1] * spans ** np.arange(powers.shape[-1])).sum(axis=-1)
        jump = np.abs(before - powers[1:, :, 0]).max(axis=0, initial=0.0)
        _require(trajectory, jump <= most, f"of {name} jumps between two pieces")
        powers = powers[..., 1:] * np.arange(1, powers.shape[-1])


def _jumps(robot: Robot, joints: Sequence[str]) -> tuple[Array, Array, Array]:
    """By how much position, velocity and acceleration of joints may differ at a border."""
    acceleration = SAME_ACCELERATION * motion_limits(robot, joints).acceleration
    same = np.ones(len(joints))
    return SAME_PLACE * same, SAME_VELOCITY * same, acceleration


def _by_joint(motion: Motion) -> dict[tuple[str, str], list[tuple[Trajectory, int]]]:
    """The trajectories of each joint in the order of time, with the joint's column."""
    found: dict[tuple[str, str], list[tuple[Trajectory, int]]] = defaultdict(list)
    for stretch in sorted(motion.stretches, key=lambda each: each.begin):
        for column, joint in enumerate(stretch.trajectory.joints):
            found[stretch.robot, joint].append((stretch.trajectory, column))
    return found


def _at(part: tuple[Trajectory, int], end: int) -> tuple[float, float, float]:
    """Position, velocity and acceleration of a joint where a trajectory begins (0) or ends (-1)."""
    trajectory, column = part
    first, second, third = (float(trajectory.at(trajectory.times[end], order)[column]) for order in range(3))
    return first, second, third


def _require_joined(name: str, parts: Sequence[tuple[Trajectory, int]], robot: Robot, joint: str) -> None:
    """A joint begins and ends at rest, and from one trajectory to the next nothing jumps, time included."""
    jumps = [float(most[0]) for most in _jumps(robot, [joint])]
    for before, after in pairwise(parts):
        apart = after[0].times[0] - before[0].times[-1]
        if apart < -SAME_TIME:
            raise Unreadable(f"{name} is in two trajectories at once")
        ends, begins = _at(before, -1), _at(after, 0)
        if any(abs(a - b) > most for a, b, most in zip(ends, begins, jumps, strict=True)):
            raise Unreadable(f"{name} jumps between two trajectories")
        if apart > SAME_TIME and max(abs(ends[1]), abs(begins[1])) > SAME_VELOCITY:
            raise Unreadable(f"{name} does not rest between two trajectories that are apart in time")
    for part, end in ((parts[0], 0), (parts[-1], -1)):
        if abs(_at(part, end)[1]) > SAME_VELOCITY:
            raise Unreadable(f"{name} {'ends' if end else 'begins'} in motion, not at rest")


def _require(trajectory: Trajectory, fine: Any, what: str) -> None:
    if not fine.all():
        raise Unreadable(f"{trajectory.joints[int(np.argmin(fine))]} {what}")
