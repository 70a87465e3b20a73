"""Relative motions: the tool along a straight line or a twist, or joints by offsets [T 3.2]."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import (
    LINE_DEVIATION,
    LINE_TILT,
    Keep,
    Refusal,
    Situation,
    candidate,
    carried_frame,
    tool_frame,
)
from kabo.kinematics import project
from kabo.scene import Robot, Scene
from kabo.scene.transforms import transform
from kabo.tasks.core import PARENT, Propagator, Property, Result
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import KEEP, ROBOT, RobotStage, keep_faults
from kabo.tasks.robots.motion.configurations import NoConfigurationError, with_joints
from kabo.tasks.robots.motion.directions import direction_of
from kabo.tasks.robots.motion.keeping import kept, not_kept
from kabo.tasks.robots.motion.paths import blocked, length, straight
from kabo.tasks.robots.motion.targets import pose_rows
from kabo.tasks.robots.scenes import Stretch, TaskScene, stretch

Way = list[Array] | Refusal
RESOLUTION = 1e-3  # m, rad: steps of the length of a stroke of which only a part is proven
ROUNDING = 1e-9  # share of a step: differences of lengths below it are rounding
DECIMALS = 12  # of lengths: 36 steps of a millimetre are 36 mm
MAX_TURN_STEP = 0.1  # rad: a twist is approximated by arcs no longer than this

NO_OBJECT = Property(
    (str, type(None)),
    None,
    "the body whose features a direction may name as `this`; none: no body",
    meanings.name,
)


class MoveRelative(RobotStage, Propagator):
    """Moves the tool from where it is, as far as can be proven, between a least and a greatest distance.

    If the greatest distance cannot be proven, the longest one is taken that is the least plus a whole number of millimetres
    (for rotations: milliradians); so a larger greatest distance never gives a shorter stroke.

    `direction`: what a sampler wrote (`<INTERFACE:approach>`), {along or against: feature, distance}, {vector: [x, y, z],
    frame}, {twist: [vx, vy, vz, wx, wy, wz], frame} or {joints: {joint: offset}}; none: no motion. Backward, the motion
    ends where the robot is.
    """

    MOVES = ("robot",)
    FROM_START = True
    PROPERTIES = {
        "robot": ROBOT,
        "direction": Property(Any, PARENT, "the direction of the motion; none: no motion", meanings.direction),
        "object": NO_OBJECT,
        "min_distance": Property(
            (float, type(None)),
            None,
            "the least length [m]; none: that of the direction; 0: no motion will do",
            meanings.at_least(0.0),
        ),
        "max_distance": Property(
            (float, type(None)),
            None,
            "the greatest length [m]; none: that of the direction",
            meanings.at_least(0.0, above=True),
        ),
        "keep": KEEP,
    }

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene after the stroke, with its motion."""
        return [self._stroke(scene, properties, 1)]

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stroke, from which it leads to `scene`."""
        return [self._stroke(scene, properties, -1)]

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for crossed bounds, bounds of joints, no distance, or a constraint that applies to nothing held."""
        given, low, high = (self.known(key) for key in ("direction", "min_distance", "max_distance"))
        greatest = _longest(given) if high is None and not self.undecided("max_distance") else high
        if low is not None and greatest is not None and low > greatest:
            yield _crossed(low, greatest)
        if isinstance(given, Mapping):
            if "joints" in given and (low is not None or high is not None):
                yield "offsets of joints have no least or greatest distance"
            yield from _strange(scene.robots.get(self.known("robot")), given.get("joints", ()))
            bounded = high is not None or self.undecided("max_distance") or given.get("distance") is not None
            if ("along" in given or "against" in given) and not bounded:
                yield "the direction has no distance, and there is no greatest one"
        yield from keep_faults(self, start)

    def _stroke(self, scene: TaskScene, properties: Values, sense: int) -> Result | Refusal:
        name, here = properties["robot"], scene.configuration(properties["robot"])
        keep = kept(scene, name, properties["keep"])
        if isinstance(keep, Refusal):
            return keep
        attempt, low, high = _length_and_bounds(scene, properties, sense)
        if low > high:
            return Refusal("constraint", _crossed(low, high))

        def tried(distance: float) -> Way:
            found = attempt(distance)
            return found if keep is None or isinstance(found, Refusal) else not_kept(keep, found) or found

        found = [here] if attempt is _nowhere else farthest(tried, low, high)
        return found if isinstance(found, Refusal) else self._result(scene, name, found, keep, sense)

    @staticmethod
    def _result(scene: TaskScene, name: str, found: Sequence[Array], keep: Keep | None, sense: int) -> Result:
        if len(found) == 1:
            return Result(scene, motion=())
        moved = stretch(scene, name, "arm", found, None if keep is None else keep.name)
        motion: tuple[Stretch, ...] = (moved if sense > 0 else moved.reversed(),)
        return Result(scene.at(name, found[-1]), motion=motion, cost=length(motion))


def farthest(attempt: Callable[[float], Way], low: float, high: float) -> Way:
    """The longest motion that is proven, among the lengths `high`, `low`, and whole steps of `RESOLUTION` above `low`.

    Args:
        attempt: returns the motion of a length [m or rad], or its failure; if one is proven, shorter ones are too.
        low: the least length permitted; if nothing is proven, its failure is returned.
        high: the greatest length.
    """
    found = attempt(high)
    if not isinstance(found, Refusal) or low >= high:
        return found
    best = attempt(low)
    if isinstance(best, Refusal):
        return best
    proven, refused = 0, math.ceil((high - low) / RESOLUTION - ROUNDING)
    while refused - proven > 1:
        middle = (proven + refused) // 2
        found = attempt(round(low + middle * RESOLUTION, DECIMALS))
        if isinstance(found, Refusal):
            refused = middle
        else:
            best, proven = found, middle
    return best


def _crossed(low: float, high: float) -> str:
    return f"the least distance, {low:g} m, is above the greatest, {high:g} m"


def _longest(given: Any) -> float | None:
    """The greatest length that a direction of a file says by itself; None if it says none, or is about rotations."""
    if not isinstance(given, Mapping):
        return None
    if "vector" in given:
        return float(np.linalg.norm(np.asarray(given["vector"], float)))
    distance = given.get("distance")
    return distance[-1] if isinstance(distance, Sequence) else distance


def _strange(robot: Robot | None, joints: Iterable[str]) -> Iterator[str]:
    """Messages for joints that a robot does not have."""
    if robot is None:
        return
    for joint in joints:
        try:
            with_joints(robot, np.zeros(len(robot.joint_names)), {joint: 0.0})
        except NoConfigurationError as error:
            yield str(error)


def _nowhere(distance: float) -> Way:
    """No direction is given: the robot stays."""
    raise AssertionError("nobody asks for a way to nowhere")


def _length_and_bounds(
    scene: TaskScene, properties: Values, sense: int
) -> tuple[Callable[[float], Way], float, float]:
    """The motion of a given length, with its least and greatest length [m; rotations rad; of joint offsets 1 is all]."""
    given, name = properties["direction"], properties["robot"]
    bounds = properties["min_distance"], properties["max_distance"]
    if isinstance(given, Mapping) and "joints" in given:
        return (lambda _: _offset(scene, name, given["joints"], sense)), 1.0, 1.0
    if isinstance(given, Mapping) and "twist" in given:
        return _twisted(scene, name, given, bounds, sense)
    at, exactly = candidate(scene.robot(name), scene.configuration(name)), (LINE_DEVIATION, LINE_TILT)
    if isinstance(given, Mapping) and "vector" in given:
        turn = scene.frame(str(given.get("frame", "world")))[:3, :3]
        vector = turn @ np.asarray(given["vector"], float)
        norm = float(np.linalg.norm(vector))
        unit, low, high = vector / norm, *_bounded(norm, bounds)
    else:
        direction = direction_of(given, properties["object"])
        if direction is None:
            return _nowhere, 0.0, 0.0
        direction = direction.bounded(*bounds)
        unit, low, high = direction.vector(scene, name, at), direction.stroke.minimum, direction.stroke.maximum
        if direction.part is not None and scene.holder(direction.part) == name:
            exactly = _exactly(scene, name, direction.part, direction.tolerance or 0.0)
    return (lambda distance: straight(scene, name, sense * distance * unit, exactly)), low, high


def _bounded(size: float, bounds: tuple[Any, Any]) -> tuple[float, float]:
    """The least and the greatest length as given; without bounds both are `size`."""
    high = size if bounds[1] is None else float(bounds[1])
    return high if bounds[0] is None else float(bounds[0]), high


def _exactly(scene: TaskScene, robot: str, part: str, tolerance: float) -> tuple[float, float]:
    """How far the tool may leave its line [m] and turn [rad] so that all points of a held part stay within `tolerance`."""
    held = carried_frame(scene.robot(robot), scene.context.scene.bodies[part], scene.situation.held(part))
    points = scene.context.scene.bodies[part].mesh.box_corners @ held.joint_T_frame[:3, :3].T
    away = points + held.joint_T_frame[:3, 3] - tool_frame(scene.robot(robot)).joint_T_frame[:3, 3]
    return 0.4 * tolerance, 0.4 * tolerance / max(float(np.linalg.norm(away, axis=1).max()), 1e-3)


def _offset(scene: TaskScene, name: str, offsets: Mapping[str, float], sense: int) -> list[Array] | Refusal:
    """The straight joint segment by offsets of some joints."""
    robot, q = scene.robot(name), scene.configuration(name)
    values = {joint: q[robot.joint_names.index(joint)] + sense * float(v) for joint, v in offsets.items()}
    goal = with_joints(robot, q, values)
    beyond = np.nonzero((goal < robot.tree.lower - 1e-9) | (goal > robot.tree.upper + 1e-9))[0]
    if len(beyond):
        i = int(beyond[0])
        low, high = robot.tree.lower[i], robot.tree.upper[i]
        text = f"{robot.joint_names[i]} would be at {goal[i]:.4g}, outside its limits of {low:.4g} to {high:.4g}"
        return Refusal("constraint", text)
    return blocked(scene, name, [q, goal]) or [q, goal]


def _twisted(
    scene: TaskScene, name: str, given: Mapping[str, Any], bounds: tuple[Any, Any], sense: int
) -> tuple[Callable[[float], Way], float, float]:
    """Motions along a twist of the tool about its centre: translation [m] with rotation [rad], in small steps."""
    turn = scene.frame(str(given.get("frame", "world")))[:3, :3]
    twist = np.asarray(given["twist"], float) * sense
    size = float(np.linalg.norm(twist[:3])) or float(np.linalg.norm(twist[3:]))

    def way(distance: float) -> Way:
        share = distance / size
        return _screw(scene, name, turn @ twist[:3] * share, turn @ twist[3:] * share)

    return way, *_bounded(size, bounds)


def _screw(scene: TaskScene, name: str, shift: Array, turn: Array) -> list[Array] | Refusal:
    robot, q = scene.robot(name), scene.configuration(name)
    frame, steps = (
        tool_frame(robot),
        max(2, int(np.ceil(max(np.linalg.norm(turn), np.linalg.norm(shift)) / (MAX_TURN_STEP / 4)))),
    )
    start = candidate(robot, q).pose(frame)
    active, way = robot.arm, [q]
    for k in range(1, steps + 1):
        goal = start.copy()
        goal[:3, 3] += shift * k / steps
        goal[:3, :3] = _rotation(turn * k / steps) @ start[:3, :3]
        found, succeeded = project(
            robot.tree, pose_rows(frame, goal), way[-1], robot.tree.lower, robot.tree.upper, active
        )
        if not succeeded[0] or np.abs(found[0] - way[-1]).max() > 4 * MAX_TURN_STEP:
            return Refusal("constraint", "the tool cannot follow the twist")
        way.append(np.round(found[0], 9) + 0.0)
    return blocked(scene, name, way) or way


def _rotation(vector: Array) -> Array:
    """The rotation (3, 3) about a vector by its length [rad]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.sin(angle / 2) * vector / angle
    return np.asarray(transform((0.0, 0.0, 0.0), (x, y, z, float(np.cos(angle / 2))))[:3, :3])
