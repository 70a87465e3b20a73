"""Reparameterise: replaces the motion of a solution by a faster one, without needless stops between phases [T 3.4.1]."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from kabo.geometry_server import Refusal, Situation
from kabo.motion import MotionLimits
from kabo.scene import Scene, motion_limits
from kabo.tasks.core import Property, Result, Solution, Wrapper
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.motion.exporting import parts
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.smoothing import smoothed
from kabo.tasks.robots.motion.timing import groups_of, passing
from kabo.tasks.robots.scenes import Stretch


class Reparameterise(RobotStage, Wrapper):
    """Gives each solution of its child new motion: as fast as limits allow, with stops only where the scene changes.

    All motion is timed so with the limits of the scene; this stage asks for gentler limits, or another deviation, and it
    makes the times part of the solution. Consecutive phases between which nothing is attached, released or waited for form
    one group: transit and approach; lift, transit and lower; retreat and home. The ends of a group are reached exactly;
    between them the motion leaves the old path by `deviation` or less, and is proven to be free and to keep its
    constraints.
    """

    PROPERTIES = {
        "deviation": Property(
            float,
            0.05,
            "distance from a way point at which the motion may pass [rad, L2 over the joints]; 0: it stops at each corner",
            meanings.at_least(0.0),
        ),
        "haste": Property(float, 1.0, "share of the joints' velocity limits", meanings.share),
        "ramp": Property(
            (float, type(None)),
            None,
            "time from rest to that velocity, which limits acceleration [s]; none: the limits of the scene",
            meanings.at_least(0.0, above=True),
        ),
        "acceleration": Property(
            (float, dict, type(None)),
            None,
            "limit for all joints or by joint [rad/s2], below those of the scene; none: by `ramp`",
            meanings.accelerations,
        ),
        "across": Property(bool, True, "whether phases of a group follow each other without a stop"),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for limits of joints that no robot has."""
        given = self.known("acceleration")
        joints = {joint for robot in scene.robots.values() for joint in robot.planned_joints}
        for joint in given if isinstance(given, Mapping) else ():
            if joint not in joints:
                yield f"no robot has a joint {joint!r} whose acceleration could be limited"

    def transform(self, solution: Solution, properties: Values, seed: int) -> Answers:
        """The solution with its new motion."""
        motion: list[Stretch] = []
        stops = 0
        for group in groups_of(parts(solution), across=properties["across"]):
            if not passing(group[0]):
                motion += [replace(part.stretch, stage=part.stage) for part in group]
                continue
            try:
                made = smoothed(group, _limits(group[0], properties), properties["deviation"], group[0].held)
            except ValueError as error:
                return [Refusal("timing", str(error))]
            motion += [part.along(timed.beginning(0.0)) for part, timed in zip(group, made.parts, strict=True)]
            stops += made.stops
        comment = f"{solution.comment}, " if solution.comment else ""
        comment += f"stops at {stops} corners" if stops else "no stops inside"
        return [Result(cost=solution.cost, comment=comment, motion=tuple(motion))]


def _limits(part: MotionPart, properties: Values) -> MotionLimits:
    """The limits of the robot, made slower by `haste`, `ramp` and `acceleration`."""
    robot = part.scene.robot(part.stretch.robot)
    own = motion_limits(robot, part.joints)
    velocity, given = properties["haste"] * own.velocity, properties["acceleration"]
    default = own.acceleration if properties["ramp"] is None else velocity / properties["ramp"]
    if isinstance(given, Mapping):
        pairs = zip(part.joints, default, strict=True)
        wanted = np.array([float(given.get(joint, value)) for joint, value in pairs])
    else:
        wanted = default if given is None else np.full(len(default), float(given))
    acceleration = np.minimum(own.acceleration, wanted)
    return MotionLimits(velocity, acceleration, own.jerk)
