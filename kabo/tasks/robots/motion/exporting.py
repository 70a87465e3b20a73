"""Converts a solution into parts of a plan: segments of motion with trajectories, and the components that it changes."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from kabo.geometry_server import Situation
from kabo.plan import Segment
from kabo.scene import Component, Robot, Scene
from kabo.tasks.core import Solution
from kabo.tasks.robots.motion.timing import rested, standing
from kabo.tasks.robots.scenes import Stretch, TaskScene
from kabo.tasks.robots.timed_paths import TimedPath


def stretches(solution: Solution) -> Iterator[tuple[str, Stretch]]:
    """Every stretch of a solution in order of time, with the path of the stage that made it."""
    for leaf in solution.leaves:
        for each in leaf.motion or ():
            yield each.stage or leaf.stage.path, each


def segments(solution: Solution, scene: Scene, procedure: str) -> tuple[Segment, ...]:
    """The segments of a solution with their trajectories; attaching and releasing take effect at the end of a segment."""
    return tuple(segment for _, segment in timeline(solution, scene, procedure))


def timeline(solution: Solution, scene: Scene, procedure: str = "") -> list[tuple[Stretch, Segment]]:
    """Every stretch that takes time, with its segment.

    Instantaneous changes are added to a neighbouring segment.
    """
    made: list[tuple[Stretch, Segment]] = []
    ends: dict[str, float] = {}  # when each robot's last segment ends
    begin = 0.0
    for each, segment in _paths(solution, scene, procedure):
        begin = max(ends.values(), default=0.0) if each.since is None else begin + each.since
        timed = _timed(each, segment, scene.robots[each.robot]).beginning(begin)
        made.append((each, timed.of(segment)))
        ends[each.robot] = timed.times[-1]
    return made


def found_motion(solution: Solution, scene: Scene, procedure: str) -> tuple[Segment, ...]:
    """The segments of a solution, of which those that a plan's situation is enough to time have no trajectory yet.

    What is planned is mostly discarded, so these times are computed for the motion of the finished plan alone. Where
    bodies were added to the scene, or several robots move, the plan does not tell enough: there all are timed.
    """
    if _needs_more_than_situations(solution):
        return segments(solution, scene, procedure)
    made: list[Segment] = []
    for each, segment in _paths(solution, scene, procedure):
        begin = made[-1].times[-1] if made else 0.0
        if each.timed is not None or each.seconds or each.exact:
            made.append(_timed(each, segment, scene.robots[each.robot]).beginning(begin).of(segment))
        else:
            made.append(replace(segment, times=tuple(begin + t for t in segment.times)))
    return tuple(made)


def _needs_more_than_situations(solution: Solution) -> bool:
    states = [state for leaf in solution.leaves for state in (leaf.start, leaf.end) if state is not None]
    robots = {each.robot for _, each in stretches(solution)}
    return len(robots) > 1 or any(state.scene.extras for state in states)


def _paths(solution: Solution, scene: Scene, procedure: str = "") -> list[tuple[Stretch, Segment]]:
    """Every stretch that takes time, with its segment, whose times only count the way points."""
    made: list[tuple[Stretch, Segment]] = []
    for path, each in stretches(solution):
        if len(each.waypoints) == 1 and not each.seconds and each.since is None and _joined(made, each, scene):
            continue
        segment = _segment(path, each, scene.robots[each.robot], procedure)
        if segment is not None:
            made.append((each, segment))
    return made


def _timed(each: Stretch, segment: Segment, robot: Robot) -> TimedPath:
    if each.timed is not None:
        return each.timed
    if each.seconds or len(set(segment.waypoints)) == 1:
        return standing(segment.joints, segment.waypoints[0], each.seconds)
    return rested(robot, segment.joints, segment.waypoints)


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


def _segment(path: str, each: Stretch, robot: Robot, procedure: str) -> Segment | None:
    gripper = each.group == "gripper" and bool(robot.gripper_joints)
    joints = robot.gripper_joints if gripper else robot.planned_joints
    first = robot.planned if gripper else 0
    way = [q[first : first + len(joints)] for q in each.waypoints]
    kept = [way[0], *(b for a, b in zip(way, way[1:], strict=False) if a != b)]
    if len(kept) == 1 and not (each.attach or each.detach or each.seconds):
        return None
    if len(kept) == 1:
        kept.append(kept[0])
    pairs = tuple(sorted((min(pair), max(pair)) for pair in each.permitted))
    return Segment(
        each.robot,
        joints,
        tuple(kept),
        tuple(float(k) for k in range(len(kept))),
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
