"""How long motion will last once it is refined, without making it so: the order of alternatives needs no more.

Between two rests a joint moves at least by the sum of its steps, no faster than its own limits; what the joints do
together lasts as long as the slowest of them takes. Free ways will be made straighter, so their detours count in part.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.motion import MotionLimits
from kabo.motion.s_curves import TICK, stopping_ticks
from kabo.plan import Segment
from kabo.scene import Robot, motion_limits

DETOUR = 0.75  # share of what a joint moves beyond the distance between a segment's ends that refinement leaves


def estimated_seconds(robots: Mapping[str, Robot], motion: Sequence[Segment]) -> float:
    """The duration [s] that a node's motion is expected to have when it is refined; no bound, neither above nor below.

    Segments that have trajectories keep their times.
    """
    if motion and all(segment.trajectory is not None for segment in motion):
        return max(segment.times[-1] for segment in motion)
    total, moved, last = 0.0, None, None
    for segment in motion:
        goes_on = last is not None and last.joints == segment.joints and last.robot == segment.robot
        if not goes_on or segment.trajectory is not None:
            total, moved = total + _seconds(robots, last, moved), None
        if segment.trajectory is not None:
            total, last = total + segment.times[-1] - segment.times[0], None
            continue
        moved = _moved(segment) if moved is None else moved + _moved(segment)
        last = segment
        if segment.attach or segment.detach:
            total, moved, last = total + _seconds(robots, last, moved), None, None
    return total + _seconds(robots, last, moved)


def _moved(segment: Segment) -> Array:
    """How far each joint (n,) moves along a segment [rad or m]."""
    path = np.array(segment.waypoints)
    net, whole = np.abs(path[-1] - path[0]), np.abs(np.diff(path, axis=0)).sum(axis=0)
    return np.asarray(net + DETOUR * (whole - net))


def _seconds(robots: Mapping[str, Robot], segment: Segment | None, moved: Array | None) -> float:
    """The least time [s] from rest to rest in which each joint of a segment moves its distance."""
    if segment is None or moved is None or not moved.any():
        return 0.0
    limits: MotionLimits = motion_limits(robots[segment.robot], segment.joints)
    return stopping_ticks(np.stack([np.zeros(len(moved)), moved]), limits) * TICK
