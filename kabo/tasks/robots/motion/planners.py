"""The planners of ways between two configurations of an arm: sampled, straight in the joints, straight for the tool."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import LINE_DEVIATION, LINE_TILT, Refusal, candidate, tool_frame
from kabo.kinematics import project
from kabo.scene import Robot
from kabo.scene.transforms import transform
from kabo.tasks.robots.meanings import RRT_CONNECT, STRAIGHT, TOOL_LINE
from kabo.tasks.robots.motion.keeping import kept, not_kept
from kabo.tasks.robots.motion.paths import blocked, way
from kabo.tasks.robots.motion.targets import pose_rows
from kabo.tasks.robots.scenes import Stretch, TaskScene, stretch

TIMED_OUT = "timed_out"  # the reason of attempts that were cut off
MAX_STEP = 0.3  # rad or m: joints between two way points of a line of the tool
MAX_HALVINGS = 8  # of a piece of such a line
LOOKS = np.linspace(0.0, 1.0, 10)[1:-1]  # shares of a piece at which the tool's distance from its line is measured


def planned_way(
    scene: TaskScene,
    robot: str,
    goal: Array,
    what: str,
    keep: Any = None,
    planners: str | Sequence[str] = RRT_CONNECT,
    timeout: float | None = None,
) -> Stretch | Refusal:
    """The motion of a robot's arm to `goal` (n,) by the first of the planners that finds one, or the last refusal.

    Args:
        scene: the scene in which the motion begins.
        robot: the robot.
        goal: its configuration at the end.
        what: what the motion is for; it keys the random stream.
        keep: the motion constraint that holds all along.
        planners: names of `PLANNERS`, in the order in which they are asked.
        timeout: the time after which each planner is cut off [s]; None: only samples are limited.
    """
    asked = (planners,) if isinstance(planners, str) else tuple(planners)
    found: Stretch | Refusal = Refusal("no_path", "no planner was asked")
    for name in asked:
        with limited(scene, timeout) as late:
            found = _WAYS[name](scene, robot, goal, what, keep)
        if late():
            found = Refusal(TIMED_OUT, f"{name} was cut off after {timeout:g} s", reads=frozenset({robot}))
        if isinstance(found, Stretch):
            break
    return found


class AttemptOver(Exception):
    """An attempt has had its time."""


@contextmanager
def limited(scene: TaskScene, seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Limits the searches within it to some time [s], None: not; gives a function that tells whether it was cut off."""
    surroundings = scene.context.surroundings
    cut: list[bool] = []
    before = surroundings.look
    if seconds is None:
        yield lambda: False
        return
    deadline = perf_counter() + seconds

    def look() -> None:
        before()
        if perf_counter() >= deadline:
            raise AttemptOver

    surroundings.look = look
    try:
        yield lambda: bool(cut)
    except AttemptOver:
        cut.append(True)
    finally:
        surroundings.look = before


def _sampled(scene: TaskScene, robot: str, goal: Array, what: str, keep: Any) -> Stretch | Refusal:
    return way(scene, robot, goal, what, keep)


def _straight(scene: TaskScene, robot: str, goal: Array, what: str, keep: Any) -> Stretch | Refusal:
    return _proven(scene, robot, [scene.configuration(robot), goal], keep)


def _along_line(scene: TaskScene, robot: str, goal: Array, what: str, keep: Any) -> Stretch | Refusal:
    path = tool_line(scene.robot(robot), scene.configuration(robot), goal)
    if path is None:
        return Refusal("constraint", "the tool cannot go there straight", reads=frozenset({robot}))
    return _proven(scene, robot, path, keep)


_WAYS: dict[str, Callable[[TaskScene, str, Array, str, Any], Stretch | Refusal]] = {
    RRT_CONNECT: _sampled,
    STRAIGHT: _straight,
    TOOL_LINE: _along_line,
}


def _proven(scene: TaskScene, robot: str, path: list[Array], keep: Any) -> Stretch | Refusal:
    """The path as a stretch, if it is proven free and to keep the constraint."""
    constraint = kept(scene, robot, keep)
    if isinstance(constraint, Refusal):
        return constraint
    refused = None if constraint is None else not_kept(constraint, path)
    refused = refused or blocked(scene, robot, path)
    if refused is not None:
        return refused
    return stretch(scene, robot, "arm", path, None if constraint is None else constraint.name)


def tool_line(robot: Robot, start: Array, goal: Array) -> list[Array] | None:
    """Way points from `start` to `goal` (n,), on which the tool moves straight and turns evenly; None if there are none.

    At way points the tool is on the line; between them it is measured, at eight points of each piece, to leave it by
    `LINE_DEVIATION` and `LINE_TILT` at most.
    """
    more = _Line(robot, start, goal).pieces(0.0, 1.0, start, goal, MAX_HALVINGS)
    return None if more is None else [start, *more]


class _Line:
    """The poses of a tool on its way from one configuration to another."""

    def __init__(self, robot: Robot, start: Array, goal: Array) -> None:
        self.robot, self.start, self.goal, self.frame = robot, start, goal, tool_frame(robot)
        self.first, self.last = self.pose(start), self.pose(goal)
        self.axis, self.angle = _axis_angle(self.last[:3, :3] @ self.first[:3, :3].T)

    def pose(self, q: Array) -> Array:
        return candidate(self.robot, q).pose(self.frame)

    def at(self, share: float) -> Array:
        """The pose (4, 4) of the tool at a share of the line."""
        wanted = np.eye(4)
        wanted[:3, 3] = (1.0 - share) * self.first[:3, 3] + share * self.last[:3, 3]
        wanted[:3, :3] = _rotation(self.axis, share * self.angle) @ self.first[:3, :3]
        return wanted

    def configuration(self, share: float) -> Array | None:
        """The configuration with the tool there that is near the straight line of the joints."""
        seed, tree = (1.0 - share) * self.start + share * self.goal, self.robot.tree
        rows = pose_rows(self.frame, self.at(share))
        found, succeeded = project(tree, rows, seed, tree.lower, tree.upper, self.robot.arm)
        return np.asarray(np.round(found[0], 9) + 0.0) if succeeded[0] else None

    def pieces(self, here: float, there: float, q: Array, p: Array, halvings: int) -> list[Array] | None:
        """The way points after `q` up to `p`, which are at two shares of the line."""
        if float(np.abs(p - q).max()) <= MAX_STEP and self.follows(here, there, q, p):
            return [p]
        middle = 0.5 * (here + there)
        between = self.configuration(middle) if halvings else None
        if between is None:
            return None
        first = self.pieces(here, middle, q, between, halvings - 1)
        second = None if first is None else self.pieces(middle, there, between, p, halvings - 1)
        return None if first is None or second is None else [*first, *second]

    def follows(self, here: float, there: float, q: Array, p: Array) -> bool:
        """Whether the tool stays near its line on the straight piece of the joints from `q` to `p`."""
        for share in LOOKS:
            found, wanted = self.pose(q + share * (p - q)), self.at(here + share * (there - here))
            along = self.last[:3, 3] - self.first[:3, 3]
            off = found[:3, 3] - wanted[:3, 3]
            length = float(along @ along)
            off = off - along * (off @ along / length) if length > 0.0 else off
            turned = _axis_angle(found[:3, :3] @ wanted[:3, :3].T)[1]
            if float(np.linalg.norm(off)) > LINE_DEVIATION or turned > LINE_TILT:
                return False
        return True


def _axis_angle(rotation: Array) -> tuple[Array, float]:
    """The axis (3,) and the angle [rad] from 0 to pi of a rotation (3, 3)."""
    skew = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = 0.5 * float(np.linalg.norm(skew)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = float(np.arctan2(sine, cosine))
    if sine > 1e-9:
        return skew / (2.0 * sine), angle
    if cosine > 0.0:
        return np.array([0.0, 0.0, 1.0]), 0.0
    columns = rotation + np.eye(3)  # half a turn: every column is along the axis
    axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
    return axis / np.linalg.norm(axis), angle


def _rotation(axis: Array, angle: float) -> Array:
    x, y, z = np.sin(angle / 2) * axis
    return np.asarray(transform((0.0, 0.0, 0.0), (x, y, z, float(np.cos(angle / 2))))[:3, :3])
