"""Reparameterise: replaces the motion of a solution by a faster one, without needless stops between phases [T 3.4.1]."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.geometry_server import Refusal, Situation
from kabo.scene import Scene
from kabo.tasks.core import Property, Result, Solution, Wrapper
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.motion.smoothing import MotionPart, TimingLimits, smoothed
from kabo.tasks.robots.scenes import Stretch

JOINT_TOLERANCE = 1e-6  # rad or m: ends that differ by less are the same


class Reparameterise(RobotStage, Wrapper):
    """Gives each solution of its child new motion: as fast as limits allow, with stops only where the scene changes.

    Consecutive phases between which nothing is attached, released or waited for form one group: transit and approach; lift,
    transit and lower; retreat and home. The ends of a group are reached exactly; between them the motion leaves the old
    path by `deviation` or less, and is proven anew to be free and to keep its constraints.
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
            float,
            0.25,
            "time from rest to that velocity, which limits acceleration [s]",
            meanings.at_least(0.0, above=True),
        ),
        "acceleration": Property(
            (float, dict, type(None)),
            None,
            "limit for all joints or by joint [rad/s2]; none: by `ramp`",
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
        for group in _groups(_parts(solution), properties["across"]):
            if not _smoothable(group[0].stretch):
                motion += [replace(part.stretch, stage=part.stage) for part in group]
                continue
            try:
                made = smoothed(group, properties["deviation"], _limits(group[0], properties))
            except ValueError as error:
                return [Refusal("timing", str(error))]
            if made is None:
                return [Refusal("timing", f"the motion of {group[0].stage} is not proven any more")]
            motion += made.stretches
            stops += made.stops
        comment = f"{solution.comment}, " if solution.comment else ""
        comment += f"stops at {stops} corners" if stops else "no stops inside"
        return [Result(cost=solution.cost, comment=comment, motion=tuple(motion))]


def _parts(solution: Solution) -> Iterator[MotionPart]:
    """The stretches of a solution in order of time, each with the scene in which it begins."""
    for leaf in solution.leaves:
        for each in leaf.motion or ():
            assert leaf.start is not None
            yield MotionPart(each, leaf.start.scene, each.stage or leaf.stage.path)


def _groups(parts: Iterator[MotionPart], across: bool) -> list[list[MotionPart]]:
    """The parts, in groups between which the motion must stop."""
    groups: list[list[MotionPart]] = []
    for part in parts:
        if across and groups and _joined(groups[-1][-1].stretch, part.stretch):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def _smoothable(each: Stretch) -> bool:
    moved = float(np.abs(np.diff(each.path, axis=0)).sum()) > JOINT_TOLERANCE
    return each.group == "arm" and moved and not (each.attach or each.detach or each.seconds or each.exact)


def _joined(first: Stretch, second: Stretch) -> bool:
    """Whether the second stretch follows the first without a change of the scene."""
    if first.robot != second.robot or not (_smoothable(first) and _smoothable(second)):
        return False
    return float(np.abs(first.path[-1] - second.path[0]).max()) <= JOINT_TOLERANCE


def _limits(part: MotionPart, properties: Values) -> TimingLimits:
    robot = part.scene.robot(part.stretch.robot)
    velocity = properties["haste"] * robot.tree.velocity[: robot.planned]
    given: Any = properties["acceleration"]
    if given is None:
        return TimingLimits(velocity, velocity / properties["ramp"])
    if isinstance(given, Mapping):
        default = velocity / properties["ramp"]
        pairs = zip(robot.planned_joints, default, strict=True)
        return TimingLimits(velocity, np.array([float(given.get(joint, value)) for joint, value in pairs]))
    return TimingLimits(velocity, np.full(robot.planned, float(given)))
