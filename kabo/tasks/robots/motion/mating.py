"""Targets of mates: configurations at which the constraints between a held part and a fixed part are satisfied."""

from collections.abc import Iterator
from dataclasses import dataclass

from kabo.geometry_server import WORLD, Candidate, Pair, Stream, fits, from_home, rows, standing_of, tool_frame
from kabo.language.scene_description import Mate
from kabo.scene import Robot
from kabo.streams import stream_key
from kabo.tasks.robots.motion.directions import frame_of
from kabo.tasks.robots.scenes import TaskScene


@dataclass(frozen=True)
class MateTarget:
    """All configurations of one robot at which the part that it holds is mated with the fixed part."""

    robot: str
    stream: Stream

    def batches(self) -> Iterator[list[Candidate]]:
        """The configurations that reach the target, in batches; those near the home configuration come first."""
        number = 0
        while True:
            yield from_home(self.stream.robot, self.stream.batch(number))
            number += 1

    def blocked(self, scene: TaskScene) -> Pair | None:
        """None: no blocking pair can be found before sampling, because a mate permits many poses."""
        return None

    def refused(self, scene: TaskScene, at: Candidate) -> str | None:
        """None: every configuration that satisfies the constraints is acceptable."""
        return None


def mate_target(scene: TaskScene, robot: Robot, moving: str, fixed: str, mate: Mate) -> MateTarget | None:
    """The target of a mate; None if a body lacks a feature that the mate names."""
    roles = {
        "moving": frame_of(scene, robot.name, moving),
        "fixed": frame_of(scene, robot.name, fixed),
        "world": WORLD,
    }
    if robot.tool is not None:
        roles["tool"] = tool_frame(robot)
    if not fits(mate.constraints, roles):
        return None
    held, where = scene.situation.held(moving), scene.pose(fixed)
    numbers = [float(v) for v in (*held.position, *held.quaternion, *where[:3].round(9).ravel())]
    key = stream_key(scene.context.seed, "mate", robot.name, moving, fixed, mate.name, *numbers)
    hand = tuple(scene.situation.configuration(robot.name)[robot.planned :])
    standing = standing_of(scene.context.surroundings, robot)
    return MateTarget(robot.name, Stream(robot, rows(mate.constraints, roles), key, hand, standing))
