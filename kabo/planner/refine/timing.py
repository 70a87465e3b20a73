"""Gives the motion of a plan its times: as fast as limits allow, at rest where it has to stop.

What a task has timed itself (waiting, several robots at once, limits of its own) keeps its times.
"""

from collections.abc import Sequence

from kabo.geometry_server import ProcedureContext, Situation
from kabo.motion import timed_path
from kabo.plan import Segment
from kabo.planner.refine.legs import legs_of
from kabo.scene import Scene, motion_limits
from kabo.tasks.robots.motion.smoothing import DEVIATION
from kabo.tasks.robots.motion.timing import timed_segments
from kabo.tasks.robots.timed_paths import TimedPath, cut


def timed(
    context: ProcedureContext, situation: Situation, motion: Sequence[Segment], deviation: float = DEVIATION
) -> tuple[Segment, ...]:
    """The segments of a node's motion with trajectories, one after the other.

    Args:
        context: the context of the geometry server.
        situation: the situation in which the motion begins.
        motion: the segments of a node; those that have trajectories keep them.
        deviation: how far the motion may pass by way points [rad, L2]; 0: it stops at each.
    """
    if all(segment.trajectory is not None for segment in motion):
        return tuple(motion)
    legs = legs_of(context, situation, motion)
    if legs is None:
        return tuple(_rested(motion, context.scene))
    return tuple(timed_segments([(leg.part, leg.segment) for leg in legs], deviation))


def duration(motion: Sequence[Segment]) -> float:
    """The duration of a motion [s]."""
    return max((segment.times[-1] for segment in motion), default=0.0)


def _rested(motion: Sequence[Segment], scene: Scene) -> list[Segment]:
    """The segments with a rest at every way point, which needs no proof."""
    made: list[Segment] = []
    for segment in motion:
        if segment.trajectory is not None:
            own = TimedPath(segment.times, segment.trajectory)
        else:
            limits = motion_limits(scene.robots[segment.robot], segment.joints)
            (own,) = cut(timed_path(segment.waypoints, limits), segment.joints, ())
        made.append(own.beginning(made[-1].times[-1] if made else 0.0).of(segment))
    return made
