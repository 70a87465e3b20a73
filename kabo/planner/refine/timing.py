"""Gives the motion of a plan its times: as fast as limits allow, at rest where it has to stop.

What a task has timed itself (waiting, several robots at once, limits of its own) keeps its times.
"""

from collections.abc import Sequence

from kabo.geometry_server import ProcedureContext, Situation
from kabo.plan import Segment
from kabo.scene import Scene
from kabo.tasks.robots.motion.timing import rested, standing
from kabo.tasks.robots.timed_paths import TimedPath


def timed(context: ProcedureContext, situation: Situation, motion: Sequence[Segment]) -> tuple[Segment, ...]:
    """The segments of a node's motion with trajectories, one after the other.

    Args:
        context: the context of the geometry server.
        situation: the situation in which the motion begins.
        motion: the segments of a node; those that have trajectories keep them, begin and all if all have.
    """
    if all(segment.trajectory is not None for segment in motion):
        return tuple(motion)
    made: list[Segment] = []
    for segment in motion:
        own = _own(segment, context.scene).beginning(made[-1].times[-1] if made else 0.0)
        made.append(own.of(segment))
    return tuple(made)


def duration(motion: Sequence[Segment]) -> float:
    """The duration of a motion [s]."""
    return max((segment.times[-1] for segment in motion), default=0.0)


def _own(segment: Segment, scene: Scene) -> TimedPath:
    if segment.trajectory is not None:
        return TimedPath(segment.times, segment.trajectory)
    if len(set(segment.waypoints)) == 1:
        return standing(segment.joints, segment.waypoints[0], 0.0)
    return rested(scene.robots[segment.robot], segment.joints, segment.waypoints)
