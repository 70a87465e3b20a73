"""Retimes a plan's motion as fast as velocity and acceleration limits allow, at rest where it has to stop.

With toppra (the extra `timing`), consecutive motion phases are executed without a stop and corners are rounded, as
the stage `Reparameterise` does. Without toppra, or if a rounded motion cannot be proven collision-free, the robot
stops at every way point.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kabo.geometry_server import ProcedureContext, Situation
from kabo.motion import from_rest_to_rest
from kabo.plan import Segment
from kabo.planner.refine.legs import Leg, legs_of
from kabo.scene import Robot
from kabo.tasks.robots.motion.smoothing import MotionPart, TimingLimits, smoothed

RAMP = 0.25  # seconds from rest to the velocity limit, where the scene sets no acceleration
DEVIATION = 0.05  # rad, L2: how far a rounded corner passes by its way point
MOVING = 1e-6  # rad: less is no motion


def limits_of(robot: Robot) -> TimingLimits:
    """The velocity and acceleration limits of a robot's planned joints.

    Velocities come from the URDF, accelerations from the scene; a joint without one reaches full velocity in
    `RAMP` seconds.
    """
    velocity = np.asarray(robot.tree.velocity[: robot.planned], float)
    pairs = zip(robot.planned_joints, velocity / RAMP, strict=True)
    return TimingLimits(
        velocity, np.array([float(robot.acceleration.get(joint, value)) for joint, value in pairs])
    )


def timed(
    context: ProcedureContext, situation: Situation, motion: Sequence[Segment], *, round_corners: bool
) -> list[Segment]:
    """The segments of a motion with new times and more way points; parts that cannot be retimed keep their times.

    Args:
        context: the context of the geometry server.
        situation: the situation in which the motion begins.
        motion: the segments of one robot.
        round_corners: whether to round corners with toppra.

    Raises:
        ImportError: `round_corners` is set and toppra is not installed.
    """
    legs = legs_of(context, situation, motion)
    if legs is None:
        return list(motion)
    made: list[Segment] = []
    for group in _groups(legs):
        for segment in _timed(group, round_corners):
            made.append(_shifted(segment, made[-1].times[-1] if made else 0.0))
    return made


def duration(motion: Sequence[Segment]) -> float:
    """The duration of a motion [s]."""
    return max((segment.times[-1] for segment in motion), default=0.0)


def _groups(legs: Sequence[Leg]) -> list[list[Leg]]:
    """The legs, grouped by which may be passed without a stop."""
    groups: list[list[Leg]] = []
    for leg in legs:
        if groups and _arm_only(groups[-1][-1]) and _arm_only(leg):
            groups[-1].append(leg)
        else:
            groups.append([leg])
    return groups


def _arm_only(leg: Leg) -> bool:
    moved = float(np.abs(np.diff(leg.path, axis=0)).sum()) > MOVING
    return leg.arm and moved and not (leg.segment.attach or leg.segment.detach)


def _timed(group: Sequence[Leg], round_corners: bool) -> list[Segment]:
    """The segments of a group, each with times of its own."""
    if not _arm_only(group[0]):
        return [leg.segment for leg in group]
    robot = group[0].part.scene.robot(group[0].segment.robot)
    rested = _rested(group, robot)
    rounded = _rounded(group, robot) if round_corners else None
    return rested if rounded is None or _seconds(rounded) >= _seconds(rested) else rounded


def _seconds(motion: Sequence[Segment]) -> float:
    return sum(segment.times[-1] - segment.times[0] for segment in motion)


def _rounded(group: Sequence[Leg], robot: Robot) -> list[Segment] | None:
    """The segments passed without a stop at rounded corners; None if that is not proven or cannot be timed."""
    parts = [MotionPart(leg.part.stretch, leg.part.scene, str(k)) for k, leg in enumerate(group)]
    try:
        made = smoothed(parts, DEVIATION, limits_of(robot))
    except ValueError:
        return None
    if made is None or [s.stage for s in made.stretches] != [part.stage for part in parts]:
        return None
    found: list[Segment] = []
    for leg, stretch in zip(group, made.stretches, strict=True):
        way = tuple(tuple(q[: robot.planned]) for q in stretch.waypoints)
        found.append(replace(leg.segment, waypoints=way, times=stretch.times))
    return found


def _rested(group: Sequence[Leg], robot: Robot) -> list[Segment]:
    """The segments with a rest at every way point."""
    found, limits = list[Segment](), limits_of(robot)
    for leg in group:
        rows, times = from_rest_to_rest(leg.segment.waypoints, limits.velocity, limits.acceleration)
        way = tuple(tuple(round(float(v), 9) + 0.0 for v in q) for q in rows)
        found.append(replace(leg.segment, waypoints=way, times=tuple(map(float, times))))
    return found


def _shifted(segment: Segment, begin: float) -> Segment:
    by = begin - segment.times[0]
    return replace(segment, times=tuple(round(t + by, 6) for t in segment.times))
