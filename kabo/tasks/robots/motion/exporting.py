"""Converts a solution into parts of a plan: segments of motion with trajectories, and the components that it changes."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from kabo.geometry_server import Situation
from kabo.plan import Segment
from kabo.scene import Component, Scene
from kabo.tasks.core import Solution
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.timing import timed_segments
from kabo.tasks.robots.scenes import Stretch, TaskScene
from kabo.tasks.robots.timed_paths import TimedPath


def parts(solution: Solution) -> Iterator[MotionPart]:
    """The stretches of a solution in order of time, each with the scene in which it begins."""
    for leaf in solution.leaves:
        for each in leaf.motion or ():
            state = leaf.start or leaf.end
            assert state is not None
            yield MotionPart(each, state.scene, each.stage or leaf.stage.path)


def stretches(solution: Solution) -> Iterator[tuple[str, Stretch]]:
    """Every stretch of a solution in order of time, with the path of the stage that made it."""
    for part in parts(solution):
        yield part.stage, part.stretch


def segments(solution: Solution, scene: Scene, procedure: str) -> tuple[Segment, ...]:
    """The segments of a solution with their trajectories; attaching and releasing take effect at the end of a segment."""
    return tuple(segment for _, segment in timeline(solution, scene, procedure))


def timeline(solution: Solution, scene: Scene, procedure: str = "") -> list[tuple[Stretch, Segment]]:
    """Every stretch that takes time, with its segment.

    Instantaneous changes are added to a neighbouring segment.
    """
    found = _paths(solution, scene, procedure)
    made = timed_segments(found)
    return [(part.stretch, segment) for (part, _), segment in zip(found, made, strict=True)]


def found_motion(solution: Solution, scene: Scene, procedure: str) -> tuple[Segment, ...]:
    """The segments of a solution, of which those that a plan's situation is enough to time have no trajectory yet.

    What is planned is mostly discarded, so these times are computed for the motion of the finished plan alone. Where
    bodies were added to the scene or are attached to each other, or several robots move, the plan does not tell enough:
    there all are timed.
    """
    found = _paths(solution, scene, procedure)
    robots = {part.stretch.robot for part, _ in found}
    if len(robots) > 1 or any(part.scene.extras or part.scene.situation.nested for part, _ in found):
        return tuple(timed_segments(found))
    made: list[Segment] = []
    for part, segment in found:
        begin = made[-1].times[-1] if made else 0.0
        each = part.stretch
        if each.timed is not None or each.seconds or each.exact:
            (own,) = timed_segments([(part, segment)])
            assert own.trajectory is not None
            made.append(TimedPath(own.times, own.trajectory).beginning(begin).of(own))
        else:
            made.append(replace(segment, times=tuple(begin + t for t in segment.times)))
    return tuple(made)


def _paths(solution: Solution, scene: Scene, procedure: str = "") -> list[tuple[MotionPart, Segment]]:
    """Every stretch that takes time, with its segment, whose times only count the way points."""
    made: list[tuple[MotionPart, Segment]] = []
    for part in parts(solution):
        each = part.stretch
        if len(each.waypoints) == 1 and not each.seconds and each.since is None and _joined(made, each, scene):
            continue
        if len(part.rows) > 1 or each.attach or each.detach or each.seconds:
            made.append((part, _segment(part, procedure)))
    return made


def _joined(made: list[tuple[MotionPart, Segment]], each: Stretch, scene: Scene) -> bool:
    """Whether a change without duration was added to the last segment, which must be of the same robot's gripper."""
    gripper = scene.robots[each.robot].gripper_joints
    if not made or made[-1][1].robot != each.robot or (gripper and made[-1][1].joints != gripper):
        return False
    part, segment = made[-1]
    if segment.attach and each.detach:
        return False
    events: dict[str, Any] = {
        "attach": (*segment.attach, *each.attach),
        "detach": (*segment.detach, *each.detach),
    }
    made[-1] = replace(part, stretch=replace(part.stretch, **events)), replace(segment, **events)
    return True


def _segment(part: MotionPart, procedure: str) -> Segment:
    each, rows = part.stretch, part.rows if len(part.rows) > 1 else part.rows * 2
    pairs = tuple(sorted((min(pair), max(pair)) for pair in each.permitted))
    return Segment(
        each.robot,
        part.joints,
        rows,
        tuple(float(k) for k in range(len(rows))),
        procedure,
        part.stage,
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
