"""Poses rotated about an axis: grasps all around an object, placements that its symmetry permits [T 3.9].

The families of a scene describe grasps and placements by constraints, and sampling draws from them; these stages list
evenly spaced ones instead, so that a task may plan for each of them.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refusal, ScenePredicates, Situation
from kabo.kinematics import uniform
from kabo.scene import Body, Scene
from kabo.streams import stream_key
from kabo.tasks.core import Monitor, Property, Result
from kabo.tasks.core.model.results import Answer
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, ROBOT, RobotStage
from kabo.tasks.robots.motion.directions import frame_of
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.grasps import OF_GRASPS, family_faults, grasp_properties
from kabo.tasks.robots.stages.poses import local_pose, pose_of

AUTO = "auto"
ROUND_PLACEMENTS = 16  # placements of a round object, if no count is given


class GraspPoses(RobotStage, Monitor):
    """One grasp pose at an object where it stands, and the same turned about the object's axis `count` times.

    Writes `target` and `target_pose` for inverse kinematics, and the fingers and strokes of a grasp `family`. The
    gripper is as in the scene at the end of the monitored stage, which opens it.
    """

    READS = ("object",)
    WRITES = ("target", "target_pose", *OF_GRASPS)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "grasp": Property(
            dict,
            doc="{position, quaternion or rpy}: the pose of the tool in the object's frame; empty: the same frame",
        ),
        "of": Property(
            (str, type(None)),
            None,
            "what the pose is for: the tool's frame (none), or `tool.feature`",
            meanings.name,
        ),
        "about": Property(
            str, "axis", "the line feature of the object about which the pose is turned", meanings.name
        ),
        "count": Property(int, 1, "how many poses, evenly spaced", meanings.at_least(1)),
        "shuffled": Property(bool, True, "whether the poses come in random order"),
        "family": Property(
            (str, type(None)),
            None,
            "a grasp family whose fingers and strokes are written as well; none: no family",
            meanings.name,
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a grasp family or a rotation axis that the object lacks."""
        yield from family_faults(self, scene, "grasps")
        name, about = self.known("object"), self.known("about")
        lines = (
            [n for n, f in scene.bodies[name].features.items() if f.direction] if name in scene.bodies else [about]
        )
        if about not in lines:
            yield f"{name} has no line {about!r} to turn about; it has {', '.join(lines) or 'none'}"

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Iterator[Answer]:
        """One result for each grasp pose, with the unchanged scene."""
        robot, name = scene.robot(properties["robot"]), properties["object"]
        frame, body = frame_for(scene, robot.name, properties["of"]), scene.context.scene.bodies[name]
        axis, written = body.features.get(properties["about"]), {}
        if axis is None or axis.direction is None:
            raise ValueError(f"{name} has no axis {properties['about']!r}")
        if properties["family"] is not None:
            written = grasp_properties(robot, name, body.grasps[properties["family"]])
        there, grasp, count = scene.pose(name), local_pose(properties["grasp"]), properties["count"]
        order = _shuffled(count, scene.context.seed, robot.name, name) if properties["shuffled"] else range(count)
        for k in order:
            pose = there @ turned(axis.origin, axis.direction, 2 * np.pi * k / count) @ grasp
            target = pose_target(scene, robot.name, frame, pose)
            own = {"target": target, "target_pose": pose, **written}
            yield Result(scene, properties=own, comment=f"turned by {360 * k / count:g} deg")


class PlacePoses(RobotStage, Monitor):
    """A pose for a held object, and all poses that look the same because of the object's symmetry about its z axis.

    A box with a square base has 4 such poses, another box 2, a round object any number: `count` of them. Contact with
    `support` is permitted in the scenes that it writes, and the object's whole base must be proven to lie on it.
    """

    READS = ("object",)
    WRITES = ("target", "object_pose")
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "pose": Property(
            (dict, np.ndarray),
            doc="the pose of the object: {frame, position, quaternion or rpy}; empty: the world's origin",
        ),
        "support": Property(
            (str, type(None)), None, "the body that it stands on; none: it may touch nothing", meanings.name
        ),
        "symmetry": Property(
            (int, str),
            AUTO,
            "how many rotations leave it unchanged; `auto`: known from its shape",
            meanings.any_of(meanings.one_of(AUTO), meanings.at_least(1)),
        ),
        "count": Property(
            int, ROUND_PLACEMENTS, "how many poses of a round object are written", meanings.at_least(1)
        ),
    }

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Iterator[Answer]:
        """One result with the scene for each pose, the given pose first."""
        robot, name = properties["robot"], properties["object"]
        if scene.holder(name) != robot:
            yield Refusal("constraint", f"{robot} does not hold {name}", reads=frozenset({name}), proof=True)
            return
        if properties["support"] is not None:
            scene = scene.permitting([(name, properties["support"])])
        turns = properties["symmetry"]
        if turns == AUTO:
            turns = symmetry(scene.context.scene.bodies[name]) or properties["count"]
        frame, pose = frame_of(scene, robot, name), pose_of(scene, properties["pose"])
        for k in range(int(turns)):
            there = pose @ turned((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 2 * np.pi * k / turns)
            turn, support = f"turned by {360 * k / turns:g} deg", properties["support"]
            if support is not None and not stands_on(scene, support, name, there):
                yield Refusal("constraint", f"{name} {turn} is not proven to stand on {support} with all its base")
                continue
            own = {"target": pose_target(scene, robot, frame, there), "object_pose": there}
            yield Result(scene, properties=own, comment=turn)


def stands_on(scene: TaskScene, support: str, name: str, pose: Array) -> bool:
    """Whether an object at a pose (4, 4) is proven to stand on a support with its whole base."""
    return ScenePredicates(scene.context.surroundings, scene.situation.first).stands_on(support, name, pose)


def symmetry(body: Body) -> int | None:
    """The number of rotations about its z axis that leave a body unchanged; None if all do, 1 if none is known."""
    shape = body.shape
    if shape.kind in ("cylinder", "sphere", "capsule"):
        return None
    if shape.kind != "box" or shape.size is None:
        return 1
    return 4 if abs(shape.size[0] - shape.size[1]) < 1e-9 else 2


def turned(point: Any, axis: Any, angle: float) -> Array:
    """The transform (4, 4) that rotates about a line through a point by an angle [rad]."""
    x, y, z = unit = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result = np.eye(4)
    result[:3, :3] = np.cos(angle) * np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * np.outer(unit, unit)
    result[:3, 3] = np.asarray(point, float) - result[:3, :3] @ np.asarray(point, float)
    return result


def _shuffled(count: int, seed: int, robot: str, name: str) -> list[int]:
    key = stream_key(seed, "turns", robot, name)
    return sorted(range(count), key=lambda k: (uniform(key, k, 0), k))
