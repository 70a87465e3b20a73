"""Legs: the segments of a node's motion, each with the scene in which it is executed, for proving it again.

A motion may be executed in a situation other than the one for which it was planned: other robots may be elsewhere,
and objects that it does not move may have other poses, or several possible ones.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import ProcedureContext, Situation, contacts, supports
from kabo.plan import Segment
from kabo.scene import attachment
from kabo.scene.transforms import inverse
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration
from kabo.tasks.robots.timed_paths import TimedPath

JOINED = 1e-6  # rad or m: a leg begins where the one before it ended, or it is another motion


@dataclass(frozen=True)
class Leg:
    """A segment, with its path over all joints of the robot and the scene in which it begins."""

    segment: Segment
    part: MotionPart

    @property
    def arm(self) -> bool:
        """Whether the leg moves the joints of the arm; False if it moves the gripper."""
        return self.part.stretch.group == "arm"

    @property
    def path(self) -> Array:
        """The way points (m, n) of the leg, over all joints of the robot."""
        return self.part.stretch.path

    def along(self, path: Iterable[Sequence[float]] | Array) -> Segment:
        """The segment along other way points (m, n), given over all joints; its times only count them."""
        robot = self.part.scene.robot(self.segment.robot)
        index = robot.columns(self.segment.joints)
        rows = tuple(tuple(configuration(np.asarray(q)[index])) for q in path)
        kept = (*(a for a, b in zip(rows, rows[1:], strict=False) if a != b), rows[-1])
        kept = kept if len(kept) > 1 else (kept[0], kept[0])
        times = tuple(float(k) for k in range(len(kept)))
        return replace(self.segment, waypoints=kept, times=times, trajectory=None)


def legs_of(context: ProcedureContext, situation: Situation, motion: Sequence[Segment]) -> list[Leg] | None:
    """The legs of a motion that begins in a situation, or None if legs cannot represent it.

    Legs cannot represent a motion of several robots, of a robot with several possible configurations, nor a motion that
    does not start at the robot's configuration.
    """
    if len({segment.robot for segment in motion}) > 1:
        return None
    scene, found = TaskScene.of(context, situation), list[Leg]()
    for segment in motion:
        if len(situation.robots[segment.robot]) != 1:
            return None
        leg = _leg(replace(scene, permitted=contacts(segment.allowed_contacts), _known={}), segment)
        if leg is None:
            return None
        found.append(leg)
        after = _after(scene.at(segment.robot, leg.part.stretch.end), segment)
        if after is None:
            return None
        scene = after
    return found


def proven(context: ProcedureContext, situation: Situation, motion: Sequence[Segment]) -> bool:
    """Whether a motion is proven free of collision, and to keep its constraints, for all values in a situation."""
    legs = legs_of(context, situation, motion)
    return legs is not None and all(leg_proven(leg) for leg in legs)


def scene_after(context: ProcedureContext, situation: Situation, motion: Sequence[Segment]) -> TaskScene | None:
    """The scene after a motion that begins in a situation; None if legs cannot represent the motion."""
    legs = legs_of(context, situation, motion)
    if not legs:
        return None
    last = legs[-1]
    return _after(last.part.scene.at(last.segment.robot, last.part.stretch.end), last.segment)


def leg_proven(leg: Leg) -> bool:
    """Whether every straight piece of a leg's path is proven collision-free and within its constraint."""
    path = leg.path
    return all(leg.part.proven(a, b) for a, b in zip(path, path[1:], strict=False))


def _leg(scene: TaskScene, segment: Segment) -> Leg | None:
    robot, start = scene.robot(segment.robot), scene.configuration(segment.robot)
    index = robot.columns(segment.joints)
    rows = np.tile(start, (len(segment.waypoints), 1))
    rows[:, index] = segment.waypoints
    if np.abs(rows[0] - start).max() > JOINED:
        return None
    group = "arm" if segment.joints == robot.planned_joints else "gripper"
    if group == "gripper":  # what is held does not move against what it stands on: segments do not say so
        held = scene.situation.carried(robot.name)
        under = scene.context.surroundings, scene.situation
        scene = scene.permitting((name, other) for name in held for other in supports(*under, name))
    way = tuple(map(configuration, rows))
    timed = None if segment.trajectory is None else TimedPath(segment.times, segment.trajectory)
    events = segment.attach, segment.detach
    made = Stretch(segment.robot, group, way, scene.permitted, segment.constraint, *events, timed=timed)  # type: ignore[arg-type]
    return Leg(segment, MotionPart(made, scene, segment.stage or ""))


def _after(scene: TaskScene, segment: Segment) -> TaskScene | None:
    """The scene after what a segment takes and lets go at its end; None if a pose that matters for it is not known."""
    for name in segment.detach:
        pose = _only_pose(scene, name)
        if pose is None or scene.holder(name) != segment.robot:
            return None
        scene = scene.placing(name, attachment("world", pose))
    for name, to in segment.attach:
        frame, pose = _only_frame(scene, to, segment.robot), _only_pose(scene, name)
        loose = name in scene.situation.objects and scene.situation.root(name) == name
        if frame is None or pose is None or not loose or scene.holder(name) is not None:
            return None
        scene = scene.placing(name, attachment(to, inverse(frame) @ pose))
    return scene


def _only_frame(scene: TaskScene, to: str, robot: str) -> Array | None:
    """The pose (4, 4) of a link of the robot, or of an object; None if there are several, or it is anything else."""
    holder, dot, link = to.partition(".")
    if dot:
        return _links(scene, robot)[link] if holder == robot else None
    return _only_pose(scene, to) if to in scene.situation.objects else None


def _only_pose(scene: TaskScene, name: str) -> Array | None:
    """The pose (4, 4) of an object; None if it may have several."""
    poses = scene.context.surroundings.poses(scene.situation, name)
    return poses[0] if len(poses) == 1 else None


def _links(scene: TaskScene, robot: str) -> Mapping[str, Array]:
    (q,) = scene.situation.robots[robot]
    return scene.context.surroundings.links(robot, q)
