"""Targets of inverse kinematics: streams of configurations that satisfy constraints.

A target is what a sampler writes as the interface property `target`. Its random stream is keyed by what is sampled, not
by where the robot is, so the same candidates come in the same order from any start.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from typing import Protocol

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import (
    BATCH_SAMPLES,
    WORLD,
    Candidate,
    Destination,
    Frame,
    GraspStream,
    Measure,
    Pair,
    PlacementStream,
    SceneSurroundings,
    Stream,
    beyond_reach,
    excess,
    grasps_there,
    least_distance,
    lies_inside,
    millimetres,
    outside,
    reach_measures,
    standing_of,
    tips_over,
    too_wide,
    tool_frame,
)
from kabo.kinematics import FrameFeature, OutOfReach, rows_of, stacked
from kabo.kinematics.constraints import normals
from kabo.scene import Configuration, Region, Robot
from kabo.scene.transforms import inverse
from kabo.streams import stream_key
from kabo.tasks.robots.motion.directions import frame_of
from kabo.tasks.robots.scenes import TaskScene

FIRST_BATCHES = (16, 48, 192)  # samples in the first batches for one pose; often a few suffice


class Target(Protocol):
    """A goal for inverse kinematics, such as all grasps of a family, or one pose."""

    @property
    def robot(self) -> str:
        """The robot that is to reach the target."""
        ...

    def batches(self) -> Iterator[list[Candidate]]:
        """The configurations that reach the target, in batches; there may be infinitely many."""
        ...

    def blocked(self, scene: TaskScene) -> Pair | None:
        """A pair of things that collides whenever the hand is at the target, whatever the arm does.

        The result is None if none is known.
        """
        ...

    def refused(self, scene: TaskScene, at: Candidate) -> str | Measure | None:
        """The reason why a configuration that satisfies the constraints is still unacceptable, or its number.

        The result is None if it is acceptable.
        """
        ...


@dataclass(frozen=True)
class GraspTarget:
    """All grasps, by one grasp family, of an object that no robot holds."""

    robot: str
    stream: GraspStream
    object: str

    def out_of_reach(self, scene: TaskScene) -> tuple[Measure, ...]:
        """What keeps the robot from every grasp: a joint's limit, and where its base would do; nothing if it has one."""
        return reach_measures(scene.context.surroundings, self.stream.stream, self.object)

    def is_hopeless(self, scene: TaskScene) -> bool:
        """Whether more samples would not help, since every limit is missed by far."""
        return beyond_reach(scene.context.surroundings, self.stream.stream, self.object)

    def too_wide(self, scene: TaskScene) -> Measure | None:
        """The width of the object beyond the gripper's opening as it is now; None if it may fit between the fingers."""
        robot, family = scene.robot(self.robot), self.stream.family
        hand = tuple(float(value) for value in scene.configuration(self.robot)[robot.planned :])
        body = scene.context.scene.bodies[self.object]
        key = "too wide", self.robot, body.name, family.name, hand
        known: tuple[Measure | None] = scene.context.surroundings.lasting(
            key, lambda: (too_wide(robot, body, family, hand),)
        )
        return known[0]

    def batches(self) -> Iterator[list[Candidate]]:
        """The configurations that reach the target, in batches; those near the home configuration come first."""
        return iter(self.stream)

    def blocked(self, scene: TaskScene) -> Pair | None:
        """None: no blocking pair can be found before sampling, because a family permits many poses."""
        return None

    def refused(self, scene: TaskScene, at: Candidate) -> str | None:
        """None: every configuration that satisfies the constraints is acceptable."""
        return None


@dataclass(frozen=True)
class PlacementTarget:
    """All placements of a held object by one family, on a support or in a region."""

    robot: str
    object: str
    stream: PlacementStream
    region: str | None
    support: str | None = None

    def out_of_reach(self, scene: TaskScene) -> tuple[Measure, ...]:
        """What keeps the robot from every grasp of the object at the nearest place; nothing if it has one there.

        It does not depend on how the object is held: a robot may be able to grasp it otherwise.
        """
        context, robot = scene.context, scene.robot(self.robot)
        region = None if self.region is None else context.scene.regions[self.region]
        place = Destination(self.support, region)
        pose = (
            b"" if self.support is None else context.surroundings.poses(scene.situation, self.support)[0].tobytes()
        )

        def streams() -> tuple[Stream, ...]:
            return tuple(grasps_there(context, robot, context.scene.bodies[self.object], place, scene.situation))

        key = "grasps there", self.robot, self.object, self.region, self.support, pose
        made: tuple[Stream, ...] = context.surroundings.remembered(key, streams)
        what = f"{self.object} {f'on {self.support}' if self.region is None else f'in {self.region}'}"
        found = [reach_measures(context.surroundings, stream, what) for stream in made]
        return min(found, key=len, default=())

    def is_hopeless(self, scene: TaskScene) -> bool:
        """Whether more samples would not help as the object is held, since every limit is missed by far."""
        return beyond_reach(scene.context.surroundings, self.stream.stream, f"{self.object} as it is held")

    def batches(self) -> Iterator[list[Candidate]]:
        """The configurations that reach the target, in batches; placements far from the robot come first."""
        return iter(self.stream)

    def blocked(self, scene: TaskScene) -> Pair | None:
        """None: no blocking pair can be found before sampling, because a family permits many poses."""
        return None

    def refused(self, scene: TaskScene, at: Candidate) -> Measure | str | None:
        """How far the object reaches out of the region at the configuration, or would tip over; None if it does neither."""
        pose, surroundings = at.pose(self.stream.this), scene.context.surroundings
        region = None if self.region is None else scene.context.scene.regions[self.region]
        if region is not None and not lies_inside(surroundings, self.object, pose, region):
            return self._outside(surroundings, pose, region)
        tips = tips_over(surroundings, scene.situation, self.object, pose, self.support)
        if tips is None:
            return None
        where = f"{millimetres(tips.metres)} beside where {' and '.join(tips.carriers)} would carry it"
        return f"{self.object} would not stand: the middle of its mass is {where}"

    def _outside(self, surroundings: SceneSurroundings, pose: Array, region: Region) -> Measure:
        out = max(0.0, outside(surroundings, self.object, pose, region))
        said = f"{self.object} reaches {excess(out)} out of {self.region}"
        return Measure(f"inside({self.object}, {self.region})", said, 0.0, out)


@dataclass(frozen=True)
class PoseTarget:
    """One pose in the world for a frame of the robot: of its tool, a link, or what it holds.

    `near` is the present configuration; solutions close to it come first.
    """

    robot: str
    frame: Frame
    world_T_frame: Array
    stream: Stream
    near: Configuration

    def batches(self) -> Iterator[list[Candidate]]:
        """The solution closest to the present configuration, then sampled ones, within each batch the closest first.

        If there is a closed form, one batch has all solutions. There is none if links and strokes are too short.
        """
        if self._missing() > 0.0:
            return
        every = self.stream.at_pose(self.frame, self.world_T_frame)
        if every is not None:
            yield [] if isinstance(every, OutOfReach) else self._nearest_first(every)
            return
        first = 0
        yield self.stream.near(np.array(self.near))
        for count in chain(FIRST_BATCHES, repeat(BATCH_SAMPLES)):
            yield self._nearest_first(self.stream.samples(first, count))
            first += count

    def unreached(self) -> OutOfReach | None:
        """The proof, by the lengths of links and strokes or by closed-form inverse kinematics, that it is out of reach.

        The result is None if there is no such proof.
        """
        if self._missing() > 0.0:
            return OutOfReach(missing=self._missing())
        every = self.stream.at_pose(self.frame, self.world_T_frame)
        return every if isinstance(every, OutOfReach) else None

    def _missing(self) -> float:
        """A lower bound [m] of how far the pose lies beyond the robot's reach; 0 or less proves nothing."""
        own, there = (
            FrameFeature(joint, "point", tuple(pose[:3, 3].tolist()))
            for joint, pose in ((self.frame.joint, self.frame.joint_T_frame), (WORLD.joint, self.world_T_frame))
        )
        return least_distance(self.stream.robot, own, there)

    def _nearest_first(self, found: list[Candidate]) -> list[Candidate]:
        n, near = self.stream.robot.planned, np.array(self.near)
        return sorted(found, key=lambda c: (round(float(np.abs(c.q[:n] - near[:n]).sum()), 6), *c.q))

    def blocked(self, scene: TaskScene) -> Pair | None:
        """The pair of the hand (or what it holds) and another thing that collides at the pose, whatever the arm does."""
        return tool_hit(scene, self.robot, self.frame, self.world_T_frame)

    def refused(self, scene: TaskScene, at: Candidate) -> str | None:
        """None: every configuration that satisfies the constraints is acceptable."""
        return None


def pose_target(scene: TaskScene, robot: str, frame: Frame, world_T_frame: Array) -> PoseTarget:
    """The target that puts a frame of the robot's tree at a pose (4, 4) in the world."""
    chosen = scene.robot(robot)
    numbers = [
        float(v) for v in (*np.round(world_T_frame[:3], 9).ravel(), *np.round(frame.joint_T_frame[:3], 9).ravel())
    ]
    key = stream_key(scene.context.seed, "pose", robot, frame.joint, *numbers)
    q = scene.situation.configuration(robot)
    standing = standing_of(scene.context.surroundings, chosen)
    stream = Stream(chosen, pose_rows(frame, world_T_frame), key, tuple(q[chosen.planned :]), standing)
    return PoseTarget(robot, frame, world_T_frame, stream, q)


def pose_rows(frame: Frame, world_T_frame: Array) -> Array:
    """Constraint rows that hold where a frame of the tree has a pose (4, 4) in the world."""

    def feature(joint: int, pose: Array, kind: str, axis: int = 2) -> FrameFeature:
        x, y, z = (float(v) for v in pose[:3, 3])
        if kind == "point":
            return FrameFeature(joint, "point", (x, y, z))
        unit = pose[:3, axis] / np.linalg.norm(pose[:3, axis])
        return FrameFeature(joint, "line", (x, y, z), (float(unit[0]), float(unit[1]), float(unit[2])))

    own, goal = frame.joint_T_frame, world_T_frame
    parts = [rows_of("coincident", feature(frame.joint, own, "point"), feature(WORLD.joint, goal, "point"))]
    for axis in (2, 0):
        parts.append(
            rows_of("aligned", feature(frame.joint, own, "line", axis), feature(WORLD.joint, goal, "line", axis))
        )
    return stacked(parts)


def tool_hit(scene: TaskScene, robot: str, frame: Frame, world_T_frame: Array) -> Pair | None:
    """The first pair of the hand (or what it holds) and another thing that is not proven apart at the pose.

    Only things that are fixed to the frame's joint, or moved by gripper joints behind it, are examined.
    """
    workspace, chosen = scene.workspace(robot), scene.robot(robot)
    hand = behind(chosen, frame.joint)
    return workspace.hand_hit(
        world_T_frame @ inverse(frame.joint_T_frame), frame.joint, hand, scene.configuration(robot)
    )


def behind(robot: Robot, joint: int) -> Sequence[int]:
    """A joint, followed by all joints that it carries and that only the gripper moves."""
    tree, found = robot.tree, [joint]
    for j in range(joint + 1, len(tree.parent)):
        own = tree.ratio[j] == 0.0 or tree.source[j] >= robot.planned
        if own and int(tree.parent[j]) in found:
            found.append(j)
    return found


def frame_for(scene: TaskScene, robot: str, of: str | None) -> Frame:
    """The frame that `of` names: the tool (None), a held object, a link, or a feature of tool or held object.

    Raises:
        ValueError: the robot has no such frame.
    """
    chosen = scene.robot(robot)
    if of is None:
        return tool_frame(chosen)
    owner, dot, name = of.partition(".")
    if not dot and scene.holder(of) == robot:
        return frame_of(scene, robot, of)
    if dot and owner == robot and name in chosen.links:
        link = chosen.links[name]
        return Frame(link.joint, link.joint_T_link, {})
    if dot and (owner == "tool" or scene.holder(owner) == robot):
        frame = tool_frame(chosen) if owner == "tool" else frame_of(scene, robot, owner)
        if name in frame.features:
            return Frame(frame.joint, frame.joint_T_frame @ feature_pose(frame.features[name]), {})
    raise ValueError(f"{robot} has no frame {of!r}: name its tool's feature, a link, or what it holds")


def feature_pose(feature: object) -> Array:
    """The pose (4, 4) whose origin is the feature's point and whose z axis is the feature's direction."""
    pose = np.eye(4)
    pose[:3, 3] = feature.origin  # type: ignore[attr-defined]
    direction = feature.direction  # type: ignore[attr-defined]
    if direction is not None:
        x, y = normals(direction)
        pose[:3, :3] = np.stack([x, y, np.asarray(direction)], axis=1)
    return pose
