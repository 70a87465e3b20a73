"""Collision-free paths: between two configurations, or along a straight line of the tool."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import LINE_DEVIATION, LINE_TILT, Refusal, line, tool_frame, way_to
from kabo.tasks.robots.motion.keeping import kept
from kabo.tasks.robots.motion.questions import MotionQuestion, PathSearch, along
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration, stretch


def way(scene: TaskScene, robot: str, goal: Array, what: str, keep: Any = None) -> Stretch | Refusal:
    """A motion of a robot's arm from its present configuration to `goal` (n,), or the refusal if none is found.

    The random stream is keyed by both configurations and by `what` the path is for, so the same call has the same answer.
    """
    start, workspace = scene.configuration(robot), scene.workspace(robot)
    key: tuple[str | int | float, ...] = (scene.context.seed, "way", robot, what)
    key += (*map(float, start), *map(float, goal))
    constraint = kept(scene, robot, keep)
    if isinstance(constraint, Refusal):
        return constraint
    found = way_to(workspace, start, goal, key, scene.context.path_samples, constraint)
    if isinstance(found, Refusal):
        search = PathSearch(key, scene.context.path_samples, keep)
        asked = MotionQuestion(scene, robot, (configuration(start), configuration(goal)), search)
        return replace(found, question=asked)
    return stretch(scene, robot, "arm", found, None if constraint is None else constraint.name)


def straight(
    scene: TaskScene, robot: str, shift: Array, exactly: tuple[float, float] = (LINE_DEVIATION, LINE_TILT)
) -> list[Array] | Refusal:
    """The path that moves a robot's tool straight from its present pose by a `shift` (3,) [m], or a refusal.

    `exactly`: the greatest distance of the tool from the line [m], and its greatest rotation [rad].
    """
    moved, start = scene.robot(robot), scene.configuration(robot)
    # Branches of a plan ask for the same lines among other things.
    found = scene.context.surroundings.remembered(
        ("line", robot, start.tobytes(), shift.tobytes(), exactly),
        lambda: line(moved, start, tool_frame(moved), shift, *exactly) or (),
    )
    if not found:
        return Refusal("constraint", "off the straight line")
    return blocked(scene, robot, found) or list(found)


def blocked(scene: TaskScene, robot: str, path: Sequence[Array]) -> Refusal | None:
    """The refusal that names the pair of things blocking a robot's path; None if the path is proven free."""
    hit = scene.workspace(robot).path_hit(path)
    return None if hit is None else Refusal.collision(hit, question=along(scene, robot, *path))


def grip(scene: TaskScene, robot: str, goal: Array) -> Stretch | Refusal:
    """The motion of a robot's gripper to its values in `goal` (n,), or the refusal with the colliding pair."""
    start, workspace = scene.configuration(robot), scene.workspace(robot)
    index = workspace.segment_hit(start, goal)
    if index >= 0:
        asked = along(scene, robot, start, goal)
        return Refusal.collision(workspace.pairs[index], question=asked)
    return stretch(scene, robot, "gripper", [start, goal])


def length(stretches: tuple[Stretch, ...] | None) -> float:
    """The length of a motion [rad or m, L1 over the joints]."""
    return float(sum(np.abs(np.diff(each.path, axis=0)).sum() for each in stretches or ()))
