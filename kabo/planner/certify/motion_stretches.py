"""Divides the motion of a node into stretches, during each of which the same bodies move and are attached.

Segments of one robot follow one another; segments of different robots may overlap in time, and a new stretch
starts whenever a segment begins or ends. Between way points, configurations are interpolated linearly in time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.scene import KinematicTree, Robot


@dataclass(frozen=True, eq=False)
class MotionStretch:
    """One stretch: indices of the segments active in it and of those ending with it, way points, and times."""

    segments: tuple[int, ...]
    ending: tuple[int, ...]
    waypoints: dict[str, Array]  # robot -> (W, n), the same W for all
    times: Array  # (W,) [s] since the beginning of the node's motion


def stretches(
    motion: Sequence[Segment], robots: dict[str, Robot], start: dict[str, Array]
) -> Iterator[MotionStretch]:
    """The stretches of a motion in order of time.

    `start` maps each robot to its configuration (n,) before the motion; it is updated while the stretches are
    generated.
    """
    if not _overlapping(motion):
        for i, segment in enumerate(motion):
            own = _whole(segment, robots[segment.robot], start[segment.robot], np.array(segment.waypoints))
            start[segment.robot] = own[-1]
            yield MotionStretch((i,), (i,), {segment.robot: own}, np.array(segment.times))
        return
    events = sorted({time for segment in motion for time in (segment.times[0], segment.times[-1])})
    for begin, end in zip(events, events[1:], strict=False):
        under_way = tuple(i for i, s in enumerate(motion) if s.times[0] <= begin and end <= s.times[-1])
        if not under_way:
            continue
        inner = {t for i in under_way for t in motion[i].times if begin < t < end}
        times = [begin, *sorted(inner), end]
        waypoints = {}
        for i in under_way:
            segment = motion[i]
            rows = np.array([at_time(segment, t) for t in times])
            waypoints[segment.robot] = _whole(segment, robots[segment.robot], start[segment.robot], rows)
        for name, rows in waypoints.items():
            start[name] = rows[-1]
        ending = tuple(i for i in under_way if motion[i].times[-1] == end)
        yield MotionStretch(under_way, ending, waypoints, np.array(times))


def at_time(segment: Segment, time: float) -> Array:
    """The values of a segment's joints at a time [s]."""
    times = segment.times
    for k, moment in enumerate(times):
        if moment == time:
            return np.array(segment.waypoints[k])
    k = int(np.searchsorted(times, time)) - 1
    share = (time - times[k]) / (times[k + 1] - times[k])
    first, last = np.array(segment.waypoints[k]), np.array(segment.waypoints[k + 1])
    return np.asarray(first + share * (last - first))


def _overlapping(motion: Sequence[Segment]) -> bool:
    """Whether two segments run at the same time, or are not in the order of time."""
    return any(after.times[0] < before.times[-1] for before, after in zip(motion, motion[1:], strict=False))


def _whole(segment: Segment, robot: Robot, start: Array, rows: Array) -> Array:
    """Configurations (W, n) of all joints of the robot."""
    whole = np.tile(start, (len(rows), 1))
    whole[:, [robot.joint_names.index(joint) for joint in segment.joints]] = rows
    return whole


def joined(trees: Sequence[KinematicTree]) -> tuple[list[int], KinematicTree]:
    """The offset of each tree's joints in the combined tree, and the combined tree.

    A configuration of the combined tree is the concatenation of those of the trees.
    """
    if len(trees) == 1:
        return [0], trees[0]
    shifts, parents, sources = [], [np.zeros(1, np.int64)], [np.zeros(1, np.int64)]
    joints, values = 1, 0
    for tree in trees:
        shift = joints - 1
        shifts.append(shift)
        own = np.asarray(tree.parent[1:])
        parents.append(np.where(own > 0, own + shift, 0))
        sources.append(np.asarray(tree.source[1:]) + values)
        joints += len(own)
        values += tree.size
    first = trees[0]
    return shifts, KinematicTree(
        np.concatenate(parents),
        np.concatenate([first.kind[:1], *(tree.kind[1:] for tree in trees)]),
        np.concatenate(sources),
        np.concatenate([first.ratio[:1], *(tree.ratio[1:] for tree in trees)]),
        np.concatenate([first.shift[:1], *(tree.shift[1:] for tree in trees)]),
        np.concatenate([first.placement[:1], *(tree.placement[1:] for tree in trees)]),
        np.concatenate([tree.lower for tree in trees]),
        np.concatenate([tree.upper for tree in trees]),
        np.concatenate([tree.velocity for tree in trees]),
    )
