"""Straight strokes of the tool: approaches, lifts, lowerings and retreats keep their line where their corners are rounded.

The near end of a stroke is where the motion rests: where the hand takes or lets go. The part next to it stays straight;
farther away a corner may be rounded, but the stroke does not get longer.
"""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import LINE_DEVIATION, LINE_TILT, poses_at, tool_frame
from kabo.scene import Robot
from kabo.tasks.robots.motion.parts import MotionPart

STRAIGHT_SHARE = 1.0 / 3  # of a stroke is straight
MAX_SLOPE = 0.15  # m per m of the way by which the tool may leave its line in the straight part
MAX_OFFSET = 1e-4  # m by which it may leave the line at the near end
MAX_TURN = 0.015  # rad of the tool in the straight part
MAX_GROWTH = 5e-4  # m by which a stroke may get longer


@dataclass(frozen=True)
class ToolLine:
    """The line of a stroke: the tool's pose (4, 4) at its near end, and the vector (3,) that leads away from it [m]."""

    robot: Robot
    near: Array
    away: Array

    def kept(self, q: Array) -> bool:
        """Whether a rounded stroke keeps its line; q (k, n) are configurations from the near end to the far one."""
        length = float(np.linalg.norm(self.away))
        poses = poses_at(self.robot, tool_frame(self.robot), q)[1:]
        moved = poses[:, :3, 3] - self.near[:3, 3]
        along = moved @ (self.away / length)
        aside = np.linalg.norm(moved - along[:, None] * (self.away / length), axis=1)
        off = (aside > MAX_OFFSET + MAX_SLOPE * np.maximum(0.0, along)) | (_turns(self.near, poses) > MAX_TURN)
        return not ((along > length + MAX_GROWTH) | ((along < STRAIGHT_SHARE * length) & off)).any()


def tool_line(part: MotionPart, *, backward: bool) -> ToolLine | None:
    """The line of a part that is a straight stroke of the tool; None of another part.

    Args:
        part: a part of an arm's motion.
        backward: whether the near end is the end of the part, not its beginning.
    """
    robot = part.scene.robot(part.stretch.robot)
    if robot.tool is None:
        return None
    path = part.stretch.path[::-1] if backward else part.stretch.path
    # Branches of a plan move along the same strokes, and each is asked about several times.
    key = "tool line", robot.name, path.tobytes()
    found: tuple[ToolLine | None] = part.scene.context.surroundings.remembered(key, lambda: (_line(robot, path),))
    return found[0]


def _line(robot: Robot, path: Array) -> ToolLine | None:
    poses = poses_at(robot, tool_frame(robot), np.concatenate([path, (path[:-1] + path[1:]) / 2]))
    near, far = poses[0], poses[len(path) - 1]
    away = far[:3, 3] - near[:3, 3]
    length = float(np.linalg.norm(away))
    if length < LINE_DEVIATION:
        return None
    moved = poses[:, :3, 3] - near[:3, 3]
    aside = np.linalg.norm(moved - (moved @ away)[:, None] / length**2 * away, axis=1)
    if aside.max() > 2.0 * LINE_DEVIATION or _turns(near, poses).max() > 2.0 * LINE_TILT:
        return None
    return ToolLine(robot, near, away)


def _turns(first: Array, poses: Array) -> Array:
    """The angles (k,) of the rotations between one pose (4, 4) and others (k, 4, 4) [rad]."""
    squares = ((poses[:, :3, :3] - first[:3, :3]) ** 2).sum(axis=(1, 2))  # |A - B| = |AᵀB - 1|
    return np.asarray(2.0 * np.arcsin(np.minimum(1.0, np.sqrt(squares / 8.0))))
