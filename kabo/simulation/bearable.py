"""How heavy guessed links may be: a robot that its maker's motors could not hold is guessed too heavy."""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.scene import REVOLUTE, Robot, motion_limits
from kabo.scene.kernels.poses import forward_kinematics
from kabo.streams import stream_key, uniforms

GRAVITY = 9.81  # [m/s²]
LARGEST_EFFORT = 1e6  # [N or Nm], from which on a limit means none
BORNE = 0.7  # of a motor's effort, which masses may need at most
GUESSED = (
    0.1  # of it, which guessed masses may need in any case: where given ones need too much, others are no reason
)
ROTORS = 0.2  # of a motor's effort, which its own inertia may need at most
LEAST_SHARE = 0.01  # of guessed masses
DRAWN = 64  # configurations in which motors are looked at
FARTHEST = 3.0  # [rad or m] of joints that are drawn: wider limits show nothing more


@dataclass(frozen=True)
class PointMasses:
    """Of each joint's frame the mass [kg] that it carries (n,), at its centre (n, 3) [m]; which are guessed (n,)."""

    masses: Array
    centres: Array
    guessed: Booleans


def bearable_share(robot: Robot, carried: PointMasses) -> float:
    """The share of guessed masses, at most 1, of which no motor needs more than a part of its effort.

    It is asked for at drawn configurations, for weight and for the joint's own acceleration at its limit. What a maker
    says of motors is better known than the density of links: drawn as capsules or boxes they would be far too heavy.
    """
    tree, share = robot.tree, 1.0
    limits = motion_limits(robot, robot.joint_names).acceleration
    low, high = np.maximum(tree.lower, -FARTHEST), np.minimum(tree.upper, FARTHEST)
    drawn = low + uniforms(stream_key("bearable", robot.name), 0, DRAWN, tree.size) * (high - low)
    poses = [_poses(robot, q) for q in drawn]
    for joint in range(1, len(tree.parent)):
        effort = _effort(robot, joint)
        if tree.ratio[joint] == 0.0 or effort is None:
            continue
        beyond = _beyond(tree.parent, joint)
        change = float(limits[int(tree.source[joint])]) * abs(float(tree.ratio[joint]))
        needs = [_needed(joint, tree.kind[joint] == REVOLUTE, pose, carried, beyond, change) for pose in poses]
        known, guess = np.max(needs, axis=0)
        if guess > 0.0:
            share = min(share, max(BORNE * effort - known, GUESSED * effort) / guess)
    return max(share, LEAST_SHARE)


def movable_inertia(robot: Robot, joint: int) -> float:
    """The inertia that the motor of a joint accelerates at the joint's limit with a small part of its effort."""
    effort, name = _effort(robot, joint), robot.joint_names[int(robot.tree.source[joint])]
    hardest = float(motion_limits(robot, (name,)).acceleration[0]) * abs(float(robot.tree.ratio[joint]))
    return float("inf") if effort is None or hardest == 0.0 else ROTORS * effort / hardest


def _effort(robot: Robot, joint: int) -> float | None:
    """The greatest force or torque of a joint; None if it has no limit."""
    given = float(robot.model.effortLimit[robot.model.joints[joint].idx_v])
    return given if 0.0 < given < LARGEST_EFFORT else None


def _poses(robot: Robot, q: Array) -> Array:
    """The poses (n, 12) of all joints' frames in the world."""
    tree = robot.tree
    found = np.zeros((len(tree.parent), 12))
    found[0, [0, 4, 8]] = 1.0
    forward_kinematics(q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, found)
    return found


def _beyond(parent: Integers, joint: int) -> list[int]:
    found = [joint]
    for other in range(joint + 1, len(parent)):
        if int(parent[other]) in found:
            found.append(other)
    return found


def _needed(
    joint: int, turns: bool, poses: Array, carried: PointMasses, beyond: list[int], change: float
) -> tuple[float, float]:
    """What a motor needs for known and for guessed masses [Nm or N]."""
    axis, origin = poses[joint, 2:9:3], poses[joint, 9:]
    turned = poses[beyond, :9].reshape(-1, 3, 3)
    places = poses[beyond, 9:] + np.einsum("nij,nj->ni", turned, carried.centres[beyond]) - origin
    masses, guessed = carried.masses[beyond], carried.guessed[beyond]
    if turns:
        weights = masses * GRAVITY * (places[:, 0] * axis[1] - places[:, 1] * axis[0])
        inert = masses * change * (np.einsum("ni,ni->n", places, places) - (places @ axis) ** 2)
    else:
        weights, inert = masses * GRAVITY * axis[2], masses * change
    known, guess = (abs(weights[which].sum()) + inert[which].sum() for which in (~guessed, guessed))
    return float(known), float(guess)
