"""Bounds of how far the points of a body leave the chord between two way points, from the robot's joints alone.

Between two way points, straight in joint space, |x - chord| <= max |x''| / 8, and for joints i before j
|d2x / dq_i dq_j| <= distance to axis j if both turn, 1 if only i turns, 0 if i slides [K Eq. 4.19-4.22, with the
distance that each joint really has to the point].
"""

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Mount
from kabo.verify.motion.sweep import Path, SweptBody

ROUNDING_FACTOR = 1.0 + 1e-12  # covers the rounding errors of the sums


def frame_of(path: Path, first: SweptBody, second: SweptBody) -> tuple[str | None, int]:
    """The robot, and the number of its last joint that carries both bodies; joint 0 is the world."""
    a, b = first.mount, second.mount
    if a is None or b is None or a.robot != b.robot:
        return None, 0
    parents, chain = path.arms[a.robot].parents, {0}
    joint = a.joint
    while joint > 0:
        chain.add(joint)
        joint = parents[joint]
    joint = b.joint
    while joint not in chain:
        joint = parents[joint]
    return a.robot, joint


def reach(mount: Mount, vertices: Array, beyond: Array | float = 0.0) -> float:
    """How far points may be from the joint that carries their body [m]: `beyond` (V,) from a body's vertices (V, 3)."""
    placed = vertices @ mount.joint_T_body[:3, :3].T + mount.joint_T_body[:3, 3]
    return float((np.linalg.norm(placed, axis=1) + beyond).max()) * ROUNDING_FACTOR


def deviations(path: Path, mount: Mount | None, frame: int, radius: float) -> tuple[Array, bool]:
    """The most that points leave their chords on each piece of a path (K,) [m], and whether they move at all.

    Args:
        path: the path.
        mount: the attachment of the points to a robot; None if they stand still.
        frame: the joint in whose frame the motion is measured, which carries the mount; 0 for the world.
        radius: the greatest distance of the points from the joint of their mount [m].
    """
    pieces = len(path.configurations) - 1
    if mount is None:
        return np.zeros(pieces), False
    arm, q = path.arms[mount.robot], path.configurations[:, path.columns[mount.robot]]
    actuation, joints, joint = arm.robot.actuation, [], mount.joint
    while joint != frame:
        joints.append(joint)
        joint = arm.parents[joint]
    values = [actuation.ratio[j] * q[:, actuation.source[j]] + actuation.shift[j] for j in joints]
    steps = [np.abs(np.diff(value)) for value in values]
    before = np.zeros((len(joints) + 1, pieces))  # the rotation of the body that carries each joint
    for k in range(len(joints) - 1, -1, -1):
        before[k] = before[k + 1] + (steps[k] if arm.revolute[joints[k]] else 0.0)
    bend, distance = np.zeros(pieces), np.full(pieces, radius)
    for k, j in enumerate(joints):
        if arm.revolute[j]:
            bend += distance * steps[k] * (steps[k] + 2.0 * before[k + 1])
        else:
            bend += 2.0 * steps[k] * before[k + 1]
            distance = distance + np.maximum(np.abs(values[k][:-1]), np.abs(values[k][1:]))
        distance = distance + float(np.linalg.norm(arm.robot.model.jointPlacements[j].translation))
    return 0.125 * bend * ROUNDING_FACTOR, any(step.any() for step in steps)


def strays(path: Path, mount: Mount | None, frame: int, radius: float) -> Array:
    """The most that points are away from where the path has them, as the trajectory deviates, on each piece (K,) [m].

    The arguments are those of `deviations`. A joint that turns by d moves a point by its distance from the joint times
    d at most, one that slides by d.
    """
    pieces = len(path.configurations) - 1
    if mount is None or path.exact:
        return np.zeros(pieces)
    arm, columns = path.arms[mount.robot], path.columns[mount.robot]
    q, off, actuation = path.configurations[:, columns], path.deviations[:, columns], arm.robot.actuation
    found, distance, joint = np.zeros(pieces), np.full(pieces, radius), mount.joint
    while joint != frame:
        source, ratio = actuation.source[joint], actuation.ratio[joint]
        own = np.abs(ratio) * off[:, source]
        if arm.revolute[joint]:
            found += distance * own
        else:
            value = np.abs(ratio * q[:, source] + actuation.shift[joint])
            found += own
            distance = distance + np.maximum(value[:-1], value[1:]) + own
        distance = distance + float(np.linalg.norm(arm.robot.model.jointPlacements[joint].translation))
        joint = arm.parents[joint]
    return found * ROUNDING_FACTOR
