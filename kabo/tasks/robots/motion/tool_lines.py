"""Straight strokes of the tool: approaches, lifts, lowerings and retreats keep their line where their corners are rounded.

The near end of a stroke is where the motion rests: where the hand takes or lets go. The part next to it stays straight;
farther away a corner may be rounded, but the stroke does not get longer.
"""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import LINE_DEVIATION, LINE_TILT, poses_at, tool_frame
from kabo.scene import Robot
from kabo.scene.transforms import length as vector_length
from kabo.tasks.robots.motion.parts import MotionPart

STRAIGHT_SHARE = 1.0 / 3  # of a stroke is straight
MAX_SLOPE = 0.15  # m per m of the way by which the tool may leave its line in the straight part
MAX_OFFSET = 1e-4  # m by which it may leave the line at the near end
MAX_TURN = 0.015  # rad of the tool in the straight part
MAX_GROWTH = 5e-4  # m by which a stroke may get longer
_UNIT = np.eye(3)


@dataclass(frozen=True)
class ToolLine:
    """The line of a stroke: the tool's pose (4, 4) at its near end, and the vector (3,) that leads away from it [m]."""

    robot: Robot
    near: Array
    away: Array

    def kept(self, q: Array) -> bool:
        """Whether a rounded stroke keeps its line; q (k, n) are configurations from the near end to the far one."""
        length = vector_length(self.away)
        unit = self.away / length
        for pose in poses_at(self.robot, tool_frame(self.robot), q)[1:]:
            moved = pose[:3, 3] - self.near[:3, 3]
            along = float(moved @ unit)
            if along > length + MAX_GROWTH:
                return False
            if along < STRAIGHT_SHARE * length:
                aside = vector_length(moved - along * unit)
                if aside > MAX_OFFSET + MAX_SLOPE * max(0.0, along) or _turn(self.near, pose) > MAX_TURN:
                    return False
        return True


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
    at = poses_at(robot, tool_frame(robot), np.concatenate([path, (path[:-1] + path[1:]) / 2]))
    near, away = at[0], at[len(path) - 1, :3, 3] - at[0, :3, 3]
    length = vector_length(away)
    if length < LINE_DEVIATION:
        return None
    for pose in at[1:]:
        moved = pose[:3, 3] - near[:3, 3]
        aside = vector_length(moved - (moved @ away) / length**2 * away)
        if aside > 2.0 * LINE_DEVIATION or _turn(near, pose) > 2.0 * LINE_TILT:
            return None
    return ToolLine(robot, near, away)


def _turn(first: Array, second: Array) -> float:
    sine = vector_length((first[:3, :3].T @ second[:3, :3] - _UNIT).ravel()) / np.sqrt(8.0)
    return 2.0 * float(np.arcsin(min(1.0, sine)))
