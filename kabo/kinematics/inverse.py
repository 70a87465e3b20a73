"""Inverse kinematics: in closed form where the axes allow it, with a sampled joint for seven axes, else by projection."""

import numpy as np

from kabo.arrays import Array
from kabo.kinematics.closed_form import OutOfReach, Reached, branches, with_turns
from kabo.kinematics.constraints import FrameFeature, Rows, rows_of, stacked
from kabo.kinematics.kernels import streams
from kabo.kinematics.projection import arrays_of
from kabo.kinematics.sampling import sample
from kabo.scene.kernels.poses import forward_kinematics
from kabo.scene.robots import Robot
from kabo.scene.structure import Structure
from kabo.scene.transforms import flat, inverse, unflat
from kabo.streams import Key

SAME_SOLUTION_DISTANCE = 1e-6  # [rad or m] within which projections count as one solution
ROTATION_TOLERANCE = 1e-6  # of the entries of a rotation matrix


def solutions(
    robot: Robot, world_T_tool: Array, key: Key, number: int, *, hand: tuple[float, ...] = ()
) -> Reached | OutOfReach:
    """Configurations (N, n) at which a robot's tool is at a pose, or the reason why there are none.

    A closed form gives all such configurations, with whole turns where limits allow several, and ignores `key` and
    `number`. Of seven axes, one is locked at each of `number` evenly spread values. Other robots are projected
    from `number` random seeds: then "out of reach" means that none was found, not that there is none.

    Args:
        robot: a robot with a tool.
        world_T_tool: the pose (4, 4) of the tool [m], with a rotation matrix orthogonal within 1e-6.
        key: the key of the stream of random numbers, from `stream_key`.
        number: the number of values of the locked joint, or of seeds, to try.
        hand: the values of the gripper's joints; if empty, zeros clipped to the limits.

    Raises:
        ValueError: the robot has no tool, or the matrix is not a pose.
    """
    if robot.tool is None:
        raise ValueError(f"robot {robot.name} has no tool")
    link = robot.links[robot.tool.frame]
    return reaching(robot, link.joint, link.joint_T_link, world_T_tool, key, number, hand=hand)


def reaching(
    robot: Robot,
    joint: int,
    joint_T_frame: Array,
    world_T_frame: Array,
    key: Key,
    number: int,
    *,
    hand: tuple[float, ...] = (),
) -> Reached | OutOfReach:
    """Configurations (N, n) that bring a frame on a joint of the robot's tree to a pose, found as in `solutions`."""
    goal, base = as_pose(world_T_frame), _base(robot, hand)
    structure = robot.structure
    if not isinstance(structure, Structure) or not is_carried(robot, structure, joint):
        return _projected(robot, joint, joint_T_frame, goal, key, number, base)
    goals = end_goal(robot, structure, joint, joint_T_frame, goal, base)[None, :]
    locked = None
    if structure.lock >= 0:
        locked = lock_values(robot, structure, key, 0, number)
        goals = np.repeat(goals, number, axis=0)
    made = branches(robot.tree, structure, goals, base, locked)
    answers = [made.answer(i, robot.tree, structure) for i in range(len(goals))]
    reached = [answer for answer in answers if isinstance(answer, Reached)]
    if not reached:
        return min((a for a in answers if isinstance(a, OutOfReach)), key=_shortfall, default=OutOfReach())
    found, marks = [], []
    for answer in reached:
        for q, mark in zip(answer.configurations, answer.singular, strict=True):
            every = with_turns(robot.tree, structure, q)
            found.append(every)
            marks.extend([mark] * len(every))
    return Reached(np.concatenate(found), tuple(marks))


def lock_values(robot: Robot, structure: Structure, key: Key, first: int, count: int) -> Array:
    """Values (count,) of the locked joint of seven, evenly spread over its limits, from sample `first` of a sequence."""
    i = int(robot.tree.source[structure.joints[structure.lock]])
    low, high = robot.tree.lower[i], robot.tree.upper[i]
    shares = [streams.stratified(key, first + k, 0, 1) for k in range(count)]
    return np.asarray(low + (high - low) * np.array(shares, np.float64))


def is_carried(robot: Robot, structure: Structure, joint: int) -> bool:
    """Whether a joint is the chain's last joint, or is carried by the chain's last joint."""
    while joint > structure.end:
        joint = int(robot.tree.parent[joint])
    return joint == structure.end


def end_goal(
    robot: Robot, structure: Structure, joint: int, joint_T_frame: Array, world_T_frame: Array, base: Array
) -> Array:
    """The pose (12,) of the chain's last joint at which a frame attached to it has a given pose."""
    world_T = np.zeros((len(robot.tree.parent), 12))
    world_T[0, [0, 4, 8]] = 1.0
    forward_kinematics(base, *arrays_of(robot.tree), world_T)
    end_T_frame = inverse(unflat(world_T[structure.end])) @ unflat(world_T[joint]) @ joint_T_frame
    return np.asarray(flat(world_T_frame @ inverse(end_T_frame)))


def as_pose(matrix: Array) -> Array:
    """The pose (4, 4) with its rotation made exactly orthogonal.

    Raises:
        ValueError: the matrix is not (4, 4), not finite, or has no rotation within 1e-6.
    """
    pose = np.array(matrix, np.float64)
    if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
        raise ValueError(f"a pose is (4, 4) and finite, not {pose.shape}")
    left, _, right = np.linalg.svd(pose[:3, :3])
    turn = left @ right
    if np.max(np.abs(turn - pose[:3, :3])) > ROTATION_TOLERANCE or np.linalg.det(turn) < 0.0:
        raise ValueError("the upper left of a pose is a rotation within 1e-6")
    pose[:3, :3] = turn
    return pose


def pose_rows(joint: int, joint_T_frame: Array, world_T_frame: Array) -> Rows:
    """Constraint rows that hold exactly if a frame on a joint is at a given pose in the world."""

    def feature(of: int, pose: Array, axis: int | None) -> FrameFeature:
        x, y, z = (float(v) for v in pose[:3, 3])
        if axis is None:
            return FrameFeature(of, "point", (x, y, z))
        unit = pose[:3, axis] / np.linalg.norm(pose[:3, axis])
        return FrameFeature(of, "line", (x, y, z), (float(unit[0]), float(unit[1]), float(unit[2])))

    own, goal = joint_T_frame, world_T_frame
    kinds = (("coincident", None), ("aligned", 2), ("aligned", 0))
    return stacked([rows_of(kind, feature(joint, own, axis), feature(0, goal, axis)) for kind, axis in kinds])


def _projected(
    robot: Robot, joint: int, joint_T_frame: Array, goal: Array, key: Key, number: int, base: Array
) -> Reached | OutOfReach:
    rows, tree = pose_rows(joint, joint_T_frame, goal), robot.tree
    active = np.arange(tree.size) < robot.planned
    limits = tree.lower, tree.upper
    found, valid = sample(tree, rows, key, 0, number, *limits, active, base=base)
    kept: list[Array] = []
    for q in found[valid]:
        if all(np.max(np.abs(q - other)) > SAME_SOLUTION_DISTANCE for other in kept):
            kept.append(q)
    return Reached(np.array(kept), ((),) * len(kept)) if kept else OutOfReach()


def _base(robot: Robot, hand: tuple[float, ...]) -> Array:
    start = np.clip(0.0, robot.tree.lower, robot.tree.upper)
    if hand:
        start[robot.planned :] = hand
    return np.asarray(start)


def _shortfall(answer: OutOfReach) -> tuple[float, float, float]:
    return answer.missing, answer.tilt, answer.beyond
