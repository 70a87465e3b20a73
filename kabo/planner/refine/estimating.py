"""How long motion will last once it is refined, without making it so: the order of alternatives needs no more.

Between two rests a joint moves at least by the sum of its steps, no faster than its own limits; what the joints do
together lasts as long as the slowest of them takes. That is short of the truth where a way winds among obstacles. The
motion along the way as it was found, with corners rounded by little, is beyond it, as free ways will be made straighter.
What is expected lies between both, nearer to the latter.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.motion import MotionLimits, thinned, timed_path
from kabo.motion.s_curves import TICK, stopping_ticks
from kabo.plan import Segment
from kabo.scene import Robot, motion_limits

ROUNDED = 0.03  # rad, L2: how far the motion along a way as it was found passes by its way points
WINDING = 0.75  # share of the time that windings cost which refinement leaves
MOVING = 1e-6  # rad or m: less is no motion


def estimated_seconds(robots: Mapping[str, Robot], motion: Sequence[Segment]) -> float:
    """The duration [s] that a node's motion is expected to have when it is refined; no bound, neither above nor below.

    Segments that have trajectories keep their times.
    """
    if motion and all(segment.trajectory is not None for segment in motion):
        return max(segment.times[-1] for segment in motion)
    total = 0.0
    for group in _between_rests(motion):
        first = group[0]
        if first.trajectory is not None:
            total += first.times[-1] - first.times[0]
        else:
            path = np.vstack([np.array(segment.waypoints) for segment in group])
            total += _seconds(path, motion_limits(robots[first.robot], first.joints))
    return total


def _between_rests(motion: Sequence[Segment]) -> list[list[Segment]]:
    """The segments, in groups between which a motion stops."""
    groups: list[list[Segment]] = []
    for segment in motion:
        last = groups[-1][-1] if groups else None
        if last is None or _stops(last, segment):
            groups.append([segment])
        else:
            groups[-1].append(segment)
    return groups


def _stops(last: Segment, segment: Segment) -> bool:
    timed = last.trajectory is not None or segment.trajectory is not None
    others = last.robot != segment.robot or last.joints != segment.joints
    return timed or others or bool(last.attach or last.detach)


def _seconds(path: Array, limits: MotionLimits) -> float:
    """The time [s] that a motion from rest to rest along way points (m, n) is expected to need once it is refined."""
    path = path[thinned(path, MOVING)]
    moved = np.abs(np.diff(path, axis=0)).sum(axis=0)
    if moved.max(initial=0.0) <= MOVING:
        return 0.0
    least = stopping_ticks(np.stack([np.zeros(len(moved)), moved]), limits) * TICK
    found = timed_path(path, limits, deviation=ROUNDED, shares=[1.0] * len(path)).duration
    return least + WINDING * (found - least)
