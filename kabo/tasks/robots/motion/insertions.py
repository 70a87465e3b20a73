"""Insertions: how near to its line a motion must be on which parts are put together.

A mate grants contact along its insertion only while no point of what moves leaves its straight way by more than the
mate's tolerance [m]. Divided by the reach of the joints it says how near the joints must be to their path [rad].
"""

from collections.abc import Sequence

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Frame, candidate, carried_frame, poses_at, tool_frame
from kabo.scene import PRISMATIC, Attachment
from kabo.tasks.robots.motion.parts import MotionPart

NEARNESS_SHARE = 0.2  # of the tolerance is for how far joints leave chords, and the same for chords from the path
KEPT_SHARE = 0.9  # of the tolerance that a motion may use, as far as it is examined here
LEAST_NEARNESS = 1e-6  # rad
MOVED = 0.05  # m by which what is held may get farther from a joint during its insertion


def inserts(part: MotionPart) -> bool:
    """Whether parts may be put together on a stroke: bodies may touch, and it is as straight as a mate wants it.

    Mates speak of models, which bodies of a scene do not name; so all such strokes count where a scene has mates. Most
    lifts do not: their lines are not that straight, so no mate would grant their contacts.
    """
    if not part.touches or not part.scene.context.scene.mates:
        return False
    key = "inserts", part.stretch.robot, part.stretch.path.tobytes(), _held(part)
    surroundings = part.scene.context.surroundings
    return bool(surroundings.remembered(key, lambda: _offset(part, part.stretch.path, 0.0) <= _tolerance(part)))


def insertion_nearness(part: MotionPart) -> float:
    """How far any joint may leave its path on an insertion [rad or m]: together they use a share of the tolerance."""
    return max(LEAST_NEARNESS, NEARNESS_SHARE * _tolerance(part) / float(_reaches(part).sum()))


def keeps_insertion(part: MotionPart, rows: Array, deviations: Array) -> bool:
    """Whether a motion that stays near other way points keeps to the line of an insertion.

    Args:
        part: the insertion.
        rows: way points (m, n) over all joints of the robot.
        deviations: (m - 1, k) how far each joint that moves may leave each piece [rad or m].
    """
    return _offset(part, rows, deviations @ _reaches(part)) <= KEPT_SHARE * _tolerance(part)


def _tolerance(part: MotionPart) -> float:
    """The least tolerance of the scene's mates [m]: which one is meant is not known of bodies."""
    return min(mate.tolerance for mate in part.scene.context.scene.mates.values())


def _points(part: MotionPart) -> Array:
    """Corners (p, 3) of the boxes of all that the robot holds, and the tool's origin, in the frame of its tool."""
    held = _held(part)
    found: Array = part.scene.context.surroundings.remembered(
        ("held points", part.stretch.robot, held), lambda: _points_of(part, held)
    )
    return found


def _held(part: MotionPart) -> tuple[tuple[str, Attachment], ...]:
    """What the robot holds, with its places."""
    situation = part.scene.situation
    return tuple((name, situation.held(name)) for name in situation.carried(part.stretch.robot))


def _points_of(part: MotionPart, held: Sequence[tuple[str, Attachment]]) -> Array:
    robot = part.scene.robot(part.stretch.robot)
    frame = tool_frame(robot)
    tool_T_joint = np.linalg.inv(frame.joint_T_frame)
    found = [np.zeros((1, 3))]
    for name, attachment in held:
        body = part.scene.context.scene.bodies[name]
        own = carried_frame(robot, body, attachment)
        if own.joint != frame.joint:
            continue
        pose = tool_T_joint @ own.joint_T_frame
        found.append(body.mesh.box_corners @ pose[:3, :3].T + pose[:3, 3])
    return np.concatenate(found)


def _reaches(part: MotionPart) -> Array:
    """How far a point of what is held moves at most (k,), for each joint that moves: metres for 1 rad, or for 1 m."""
    robot = part.scene.robot(part.stretch.robot)
    at, tree, frame = candidate(robot, part.stretch.path[0]), robot.tree, tool_frame(robot)
    pose = at.pose(frame)
    points = _points(part) @ pose[:3, :3].T + pose[:3, 3]
    found, joint = np.zeros(robot.planned), frame.joint
    while joint > 0:
        if tree.source[joint] < robot.planned:
            origin = at.pose(Frame(joint, np.eye(4), {}))[:3, 3]
            reach = float(np.linalg.norm(points - origin, axis=1).max()) + MOVED
            found[tree.source[joint]] += abs(tree.ratio[joint]) * (1.0 if tree.kind[joint] == PRISMATIC else reach)
        joint = int(tree.parent[joint])
    return found


def _offset(part: MotionPart, rows: Array, strays: Array | float) -> float:
    """The greatest distance of a held point from the straight line between its first and last place [m].

    At way points and in the middle between them; `strays` (m - 1,) are added on each piece.
    """
    robot, points = part.scene.robot(part.stretch.robot), _points(part)
    frame = tool_frame(robot)

    def places(q: Array) -> Array:
        poses = poses_at(robot, frame, q)
        return np.asarray(points @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3])

    ends, middles = places(rows), places((rows[:-1] + rows[1:]) / 2)
    first, last = places(part.stretch.path[[0, -1]])[:, 0]
    way = last - first
    unit = way / max(float(np.linalg.norm(way)), 1e-12)

    def aside(found: Array) -> Array:
        moved = found - ends[0]
        off = moved - (moved @ unit)[..., None] * unit
        return np.asarray(np.linalg.norm(off, axis=-1).max(axis=1))

    off = aside(ends)
    corner = np.maximum(off[:-1], off[1:])
    return float((np.maximum(corner, aside(middles)) + strays).max())
