"""Collision-free paths between two configurations: the planner of `Connect` and `MoveTo`."""

from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refused, way_to
from kabo.tasks.core import Failure
from kabo.tasks.robots.motion.keeping import kept
from kabo.tasks.robots.motion.questions import MotionQuestion, PathSearch, along
from kabo.tasks.robots.motion.refusals import refusal
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration, stretch


def way(scene: TaskScene, robot: str, goal: Array, what: str, keep: Any = None) -> Stretch | Failure:
    """A motion of a robot's arm from its present configuration to `goal` (n,), or the failure to find one.

    The random stream is keyed by both configurations and by `what` the path is for, so the same call has the same answer.
    """
    start, workspace = scene.configuration(robot), scene.workspace(robot)
    key: tuple[str | int | float, ...] = (scene.context.seed, "way", robot, what)
    key += (*map(float, start), *map(float, goal))
    constraint = kept(scene, robot, keep)
    if isinstance(constraint, Failure):
        return constraint
    found = way_to(workspace, start, goal, key, scene.context.path_samples, constraint)
    if isinstance(found, Refused) and found.broken:
        return refusal("constraint", found.broken, reads=frozenset({robot}))
    if isinstance(found, Refused):
        search = PathSearch(key, scene.context.path_samples, keep)
        asked = MotionQuestion(scene, robot, (configuration(start), configuration(goal)), search)
        most = max((count for _, count in found.pairs), default=0)
        text = (
            f"{constraint.name} would not be kept on {found.unkept} pieces of ways"
            if constraint is not None and found.unkept > most
            else ""
        )
        return refusal("no_path", text, pairs=found.pairs, reads=frozenset({robot}), question=asked)
    return stretch(scene, robot, "arm", found, None if constraint is None else constraint.name)


def grip(scene: TaskScene, robot: str, goal: Array) -> Stretch | Failure:
    """The motion of a robot's gripper to its values in `goal` (n,), or the failure, with what is in the way."""
    start, workspace = scene.configuration(robot), scene.workspace(robot)
    index = workspace.segment_hit(start, goal)
    if index >= 0:
        asked = along(scene, robot, start, goal)
        return refusal("collision", hit=workspace.pairs[index], question=asked)
    return stretch(scene, robot, "gripper", [start, goal])


def length(stretches: tuple[Stretch, ...] | None) -> float:
    """The length of a motion [rad or m, L1 over the joints]."""
    return float(sum(np.abs(np.diff(each.path, axis=0)).sum() for each in stretches or ()))
