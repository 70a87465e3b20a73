"""Gives the motion of a plan its times: as fast as limits allow, at rest where it has to stop.

What a task has timed itself (waiting, several robots at once, limits of its own) keeps its times.
"""

from collections.abc import Sequence

from kabo.geometry_server import ProcedureContext, Situation
from kabo.motion import timed_path
from kabo.plan import Segment
from kabo.planner.refine.legs import legs_of
from kabo.scene import motion_limits
from kabo.tasks.robots.motion.held_bodies import held_by
from kabo.tasks.robots.motion.timing import TimesOf, timed_group, timed_segments
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.timed_paths import TimedPath, cut


def timed(
    context: ProcedureContext,
    situation: Situation,
    motion: Sequence[Segment],
    times_of: TimesOf = timed_group,
) -> tuple[Segment, ...]:
    """The segments of a node's motion with trajectories, one after the other.

    Args:
        context: the context of the geometry server.
        situation: the situation in which the motion begins.
        motion: the segments of a node; those that have trajectories keep them.
        times_of: gives parts without a rest between them their trajectories, which may be along other paths.
    """
    if all(segment.trajectory is not None for segment in motion):
        return tuple(motion)
    legs = legs_of(context, situation, motion)
    if legs is None:
        return tuple(_rested(motion, TaskScene.of(context, situation)))
    return tuple(timed_segments([(leg.part, leg.segment) for leg in legs], times_of))


def duration(motion: Sequence[Segment]) -> float:
    """The duration of a motion [s]."""
    return max((segment.times[-1] for segment in motion), default=0.0)


def _rested(motion: Sequence[Segment], scene: TaskScene) -> list[Segment]:
    """The segments with a rest at every way point, which needs no proof."""
    made: list[Segment] = []
    for segment in motion:
        robot = scene.context.scene.robots[segment.robot]
        if segment.trajectory is not None:
            own = TimedPath(segment.times, segment.trajectory)
        else:
            arm = segment.joints == robot.planned_joints
            held = held_by(scene, robot.name) if arm else None
            limits = motion_limits(robot, segment.joints)
            (own,) = cut(timed_path(segment.waypoints, limits, held=held), segment.joints, ())
        made.append(own.beginning(made[-1].times[-1] if made else 0.0).of(segment))
    return made
