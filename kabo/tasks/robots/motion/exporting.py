"""Converts a solution into parts of a plan: timed segments of its stretches, and the components that it changes."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.geometry_server import Situation
from kabo.motion import retime
from kabo.plan import Segment
from kabo.scene import Component, Scene
from kabo.tasks.core import Solution
from kabo.tasks.robots.scenes import Stretch, TaskScene

VELOCITY_SHARE = 0.5  # share of the joints' velocity limits
TIME_DECIMALS = 6  # decimals of times [s]


def stretches(solution: Solution) -> Iterator[tuple[str, Stretch]]:
    """Every stretch of a solution in order of time, with the path of the stage that made it."""
    for leaf in solution.leaves:
        for each in leaf.motion or ():
            yield each.stage or leaf.stage.path, each


def segments(solution: Solution, scene: Scene, procedure: str) -> tuple[Segment, ...]:
    """The timed segments of a solution; attaching and releasing take effect at the end of a segment."""
    return tuple(segment for _, segment in timeline(solution, scene, procedure))


def timeline(solution: Solution, scene: Scene, procedure: str = "") -> list[tuple[Stretch, Segment]]:
    """Every stretch that takes time, with its timed segment.

    Instantaneous changes are added to a neighbouring segment.
    """
    made: list[tuple[Stretch, Segment]] = []
    ends: dict[str, float] = {}  # when each robot's last segment ends
    begin = 0.0
    for path, each in stretches(solution):
        begin = max(ends.values(), default=0.0) if each.since is None else begin + each.since
        if len(each.waypoints) == 1 and not each.seconds and each.since is None and _joined(made, each, scene):
            continue
        segment = _segment(path, each, scene, procedure, begin)
        if segment is not None:
            made.append((each, segment))
            ends[each.robot] = segment.times[-1]
    return made


def _joined(made: list[tuple[Stretch, Segment]], each: Stretch, scene: Scene) -> bool:
    """Whether a change without duration was added to the last segment, which must be of the same robot's gripper."""
    gripper = scene.robots[each.robot].gripper_joints
    if not made or made[-1][1].robot != each.robot or (gripper and made[-1][1].joints != gripper):
        return False
    stretch, segment = made[-1]
    if segment.attach and each.detach:
        return False
    events: dict[str, Any] = {
        "attach": (*segment.attach, *each.attach),
        "detach": (*segment.detach, *each.detach),
    }
    made[-1] = replace(stretch, **events), replace(segment, **events)
    return True


def _segment(path: str, each: Stretch, scene: Scene, procedure: str, after: float) -> Segment | None:
    robot = scene.robots[each.robot]
    gripper = each.group == "gripper" and bool(robot.gripper_joints)
    joints = robot.gripper_joints if gripper else robot.planned_joints
    first = robot.planned if gripper else 0
    way = [q[first : first + len(joints)] for q in each.waypoints]
    kept = [way[0], *(b for a, b in zip(way, way[1:], strict=False) if a != b)]
    if len(kept) == 1 and not (each.attach or each.detach or each.seconds):
        return None
    if len(kept) == 1:
        kept.append(kept[0])
    limits = robot.tree.velocity[first : first + len(joints)]
    timed = len(each.times) == len(kept)
    times = np.array(each.times) if timed else retime(np.array(kept), limits, factor=VELOCITY_SHARE)
    if each.seconds:
        times = times * (each.seconds / times[-1]) if times[-1] > 0.0 else times
    pairs = tuple(sorted((min(pair), max(pair)) for pair in each.permitted))
    return Segment(
        each.robot,
        joints,
        tuple(kept),
        tuple(round(after + float(t), TIME_DECIMALS) for t in times),
        procedure,
        path,
        each.attach,
        each.detach,
        pairs,
        each.constraint,
    )


def changed(solution: Solution) -> dict[str, Component]:
    """The components whose values a solution changes, with their new values."""
    assert solution.start is not None and solution.end is not None
    before: TaskScene = solution.start.scene
    after: TaskScene = solution.end.scene
    return changed_between(before.situation, after.situation)


def changed_between(before: Situation, after: Situation) -> dict[str, Component]:
    """The components whose values differ between two situations, with the values after; robots first."""
    robots = {name: v[0] for name, v in after.robots.items() if v != before.robots[name]}
    objects = {name: v[0] for name, v in after.objects.items() if v != before.objects[name]}
    return {**robots, **objects}
