"""Pour: a held object is tilted over a container, held there, and tilted back [T 3.9.2]."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Frame, Refusal, candidate
from kabo.kinematics import FrameFeature, keeps, project, rows_of, stacked
from kabo.scene import Robot
from kabo.tasks.core import PARENT, Propagator, Property, Result
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, ROBOT, RobotStage
from kabo.tasks.robots.motion.configurations import rounded
from kabo.tasks.robots.motion.directions import frame_of
from kabo.tasks.robots.motion.pour_path import PourPath
from kabo.tasks.robots.motion.targets import feature_pose, pose_rows
from kabo.tasks.robots.scenes import Stretch, TaskScene, stretch
from kabo.tasks.robots.stages.symmetries import turned

UP = np.array([0.0, 0.0, 1.0])

PATH_STEP = 0.02  # m along the path between poses; a radian counts as 0.15 m
MIN_STEP_SHARE = 1.0 / 16  # share of a step: if shorter ones are needed, joints would have to move too fast
MAX_JOINT_STEP = 0.35  # rad between way points, for each joint
MAX_RIM_OFFSET = 0.02  # m: sideways distance of the lid from the middle of the rim
MAX_DEVIATION, MAX_ROTATION = 2e-3, 0.02  # m, rad: proven deviation from the straight pieces between poses


class Pour(RobotStage, Propagator):
    """Tilts the held object until its lid is at the rim of a container, waits, and returns the same way.

    The lid moves as `PourPath` says, in the vertical plane of `towards`. Between the poses of the path the motion is proven
    to stay in that plane, to tilt no farther than `tilt`, and to be free. It ends where it began.
    """

    MOVES = ("robot",)
    READS = ("object", "container")
    FROM_START = True
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "lid": Property(str, "lid", "feature of the object where it pours, directed out of it", meanings.name),
        "container": Property(str, PARENT, "the body that is poured into", meanings.name),
        "rim": Property(str, "rim", "feature of the container in the middle of its rim", meanings.name),
        "towards": Property(
            (float, list, tuple),
            doc="the horizontal direction of tilting: angle from x about the vertical [rad] (0: along x), or [x, y, z]",
            wrong=meanings.turning,
        ),
        "offset": Property(
            (list, tuple),
            (0.0, 0.02),
            "where the lid pours: offsets along `towards` and upward from the rim's middle [m]; 0: at it",
            lambda value: meanings.numbers(value, 2),
        ),
        "tilt": Property(
            float, 1.9, "the angle of tilting while it pours [rad]", meanings.at_least(0.0, above=True)
        ),
        "overshoot": Property(
            float,
            0.0,
            "the constant c of the path: a larger one moves farther sideways first; 0: no farther than needed",
            meanings.finite,
        ),
        "pause": Property(float, 1.0, "how long it pours [s]; 0: it returns at once", meanings.at_least(0.0)),
    }

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene, unchanged: the motion ends where it began."""
        name = properties["robot"]
        if scene.holder(properties["object"]) != name:
            text = f"{name} does not hold {properties['object']}"
            return [Refusal("constraint", text, reads=frozenset({properties["object"]}), proof=True)]
        tilting = _tilting(scene, properties)
        if isinstance(tilting, Refusal):
            return [tilting]
        way = tilting.followed(scene.configuration(name))
        if isinstance(way, Refusal):
            return [way]
        hit = scene.workspace(name).path_hit(way)
        if hit is not None:
            return [Refusal.collision(hit)]
        there = replace(stretch(scene, name, "arm", way), exact=True)
        pause = float(properties["pause"])
        still = (replace(there, waypoints=(there.end,), seconds=pause),) if pause > 0.0 else ()
        motion: tuple[Stretch, ...] = (there, *still, there.reversed())
        return [Result(scene, motion=motion)]

    backward = forward


@dataclass(frozen=True)
class _Tilting:
    """The path of one lid: a frame in the robot's tree with z pointing out of the lid, and poses of that frame."""

    robot: Robot
    lid: Frame
    start: Array  # (4, 4) of the lid in the world
    towards: Array  # (3,) unit, horizontal
    path: PourPath

    @cached_property
    def across(self) -> Array:
        """The unit vector (3,) about which the lid is tilted."""
        return np.cross(UP, self.towards)

    def pose(self, at: Array) -> Array:
        """The pose (4, 4) of the lid at the path's pose (x, y, theta)."""
        x, y, theta = (float(v) for v in at)
        result: Array = self.start.copy()
        result[:3, 3] += (x - self.path.start[0]) * self.towards + (y - self.path.start[1]) * UP
        result[:3, :3] = (
            turned((0.0, 0.0, 0.0), self.across, theta - self.path.start[2])[:3, :3] @ self.start[:3, :3]
        )
        return result

    def followed(self, q: Array) -> list[Array] | Refusal:
        """Way points from q along the path; each straight joint segment between them is proven to stay close to it."""
        poses, way, number = self.path.by_length(PATH_STEP), [q], 0
        near = self.pose(poses[0])[:3, 3]  # where the lid is at the last way point
        while number < len(poses) - 1:
            share, step = 0.0, 1.0
            while share < 1.0:
                until = min(1.0, share + step)
                a, b = (poses[number] + (poses[number + 1] - poses[number]) * k for k in (share, until))
                there = self.pose(b)
                goal = self._near(way[-1], there)
                if goal is not None and self._kept(way[-1], goal, (near, there[:3, 3]), (a[2], b[2])):
                    way.append(goal)
                    share, near = until, there[:3, 3]
                    continue
                step /= 2
                if step < MIN_STEP_SHARE:
                    return self._lost(goal, number / (len(poses) - 1))
            number += 1
        return way

    def _near(self, q: Array, pose: Array) -> Array | None:
        """A configuration near q with the lid at a pose, within the joint limits."""
        tree = self.robot.tree
        active = self.robot.arm
        found, succeeded = project(
            tree, pose_rows(self.lid, pose), q, tree.lower, tree.upper, active, hold_limits=True
        )
        return rounded(found[0]) if succeeded[0] else None

    def _kept(self, q: Array, goal: Array, lid: tuple[Array, Array], tilts: tuple[float, float]) -> bool:
        """Whether the straight joint segment is proven to stay close to the straight line between two poses of the lid."""
        if np.abs(goal - q).max() > MAX_JOINT_STEP:
            return False
        own, unit = self.lid.joint_T_frame, self.lid.joint_T_frame[:3, 2]
        origin = _vector(own[:3, 3])
        point, line = (
            FrameFeature(self.lid.joint, "point", origin),
            FrameFeature(self.lid.joint, "line", origin, _vector(unit)),
        )
        low, high = lid
        along = high - low if np.linalg.norm(high - low) > 1e-6 else self.towards
        along = along / np.linalg.norm(along)
        rows = stacked(
            [
                rows_of("coincident", point, FrameFeature(0, "line", _vector(low), _vector(along))),
                rows_of("perpendicular", line, FrameFeature(0, "line", _vector(low), _vector(self.across))),
                rows_of("angle", line, FrameFeature(0, "line", _vector(low), _vector(UP)), *_tilts(*tilts)),
            ]
        )
        tolerance = [MAX_DEVIATION / np.sqrt(2.0)] * 2 + [MAX_ROTATION] * (len(rows) - 2)
        return keeps(self.robot.tree, rows, q, goal, tolerance)

    def _lost(self, goal: Array | None, share: float) -> Refusal:
        if goal is None:
            return Refusal("out_of_reach", f"the path can be followed for {100 * share:.0f} %")
        return Refusal("constraint", f"joints would have to turn too fast at {100 * share:.0f} % of the path")


def _tilting(scene: TaskScene, properties: Values) -> _Tilting | Refusal:
    robot, name, container = properties["robot"], properties["object"], properties["container"]
    towards = _horizontal(properties["towards"])
    held, lid = frame_of(scene, robot, name), _feature(scene, name, properties["lid"])
    frame = Frame(held.joint, held.joint_T_frame @ feature_pose(lid), {})
    rim = scene.pose(container) @ feature_pose(_feature(scene, container, properties["rim"]))
    pose = candidate(scene.robot(robot), scene.configuration(robot)).pose(frame)
    aside = float(np.cross(UP, towards) @ (rim[:3, 3] - pose[:3, 3]))
    if abs(aside) > MAX_RIM_OFFSET:
        return Refusal("constraint", f"the lid is {abs(aside):.3f} m beside {container}")
    out = pose[:3, 2]
    start = _in_plane(pose[:3, 3], towards, float(np.arctan2(out @ towards, out @ UP)))
    across, above = (float(v) for v in properties["offset"])
    pouring = _in_plane(rim[:3, 3] + across * towards + above * UP, towards, float(properties["tilt"]))
    return _Tilting(scene.robot(robot), frame, pose, towards, PourPath(start, pouring, properties["overshoot"]))


def _horizontal(given: Any) -> Array:
    """A horizontal unit vector (3,), given as an angle from x about the vertical or as a vector."""
    if isinstance(given, (int, float)):
        return np.array([np.cos(given), np.sin(given), 0.0])
    vector = np.asarray(given, float) * (1.0, 1.0, 0.0)
    if float(np.linalg.norm(vector)) == 0.0:
        raise ValueError("`towards` is a horizontal direction")
    return np.asarray(vector / np.linalg.norm(vector))


def _feature(scene: TaskScene, name: str, feature: str) -> Any:
    features = scene.context.scene.bodies[name].features
    if feature not in features:
        raise ValueError(f"{name} has no feature {feature!r}; it has {', '.join(features) or 'none'}")
    return features[feature]


def _in_plane(point: Array, towards: Array, theta: float) -> tuple[float, float, float]:
    return float(point @ towards), float(point @ UP), theta


def _tilts(first: float, second: float) -> tuple[float, float]:
    """The least and the greatest angle from upright while tilting from one angle to the other."""
    low, high = sorted((abs(first), abs(second)))
    return (0.0 if first * second < 0.0 else low), high


def _vector(given: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in given)
    return x, y, z
