"""Divides the motion of a node into stretches, during each of which the same bodies move and are attached.

Segments of one robot follow one another; segments of different robots may overlap in time, and a new stretch
starts whenever a segment begins or ends. A segment alone has its own way points. Several at once have common times: of
all way points, of the ends of all polynomials, and at most 20 ms apart if any of them has polynomials; their places
then are the way points of one path of all their joints. How far trajectories are from the lines between way points is
stated for each joint.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.motion import Polynomials, Trajectory, joined_deviations, passing_times, path_deviations
from kabo.plan import Segment
from kabo.scene import KinematicTree, Robot

TIME_TOLERANCE = 1e-9  # [s] times nearer than this count as equal
STILL = 1e-9  # [rad or m]: a joint that stands is not off its place by rounding


@dataclass(frozen=True, eq=False)
class MotionStretch:
    """One stretch: indices of the segments active in it and of those ending with it, way points, and times."""

    segments: tuple[int, ...]
    ending: tuple[int, ...]
    waypoints: dict[str, Array]  # robot -> (W, n), the same W for all
    times: Array  # (W,) [s] since the beginning of the node's motion
    deviations: dict[str, Array]  # robot -> (W - 1, n), how far each joint may be from each piece [rad or m]
    in_time: bool = False  # whether places are those at the times; else times are when way points are passed

    @property
    def together(self) -> Array:
        """The deviations (W - 1, n) of all robots, side by side as their way points."""
        return np.hstack(list(self.deviations.values()))


def stretches(
    motion: Sequence[Segment], robots: dict[str, Robot], start: dict[str, Array]
) -> Iterator[MotionStretch]:
    """The stretches of a motion in order of time.

    `start` maps each robot to its configuration (n,) before the motion; it is updated while the stretches are
    generated.
    """
    if not _overlapping(motion):
        for i, segment in enumerate(motion):
            yield _alone(i, segment, robots[segment.robot], start)
        return
    events = sorted({time for segment in motion for time in (segment.times[0], segment.times[-1])})
    for begin, end in zip(events, events[1:], strict=False):
        under_way = tuple(i for i, s in enumerate(motion) if s.times[0] <= begin and end <= s.times[-1])
        if not under_way:
            continue
        if len(under_way) == 1 and (motion[under_way[0]].times[0], motion[under_way[0]].times[-1]) == (begin, end):
            yield _alone(under_way[0], motion[under_way[0]], robots[motion[under_way[0]].robot], start)
            continue
        times = _common_times([motion[i] for i in under_way], begin, end)
        waypoints, deviations = at_once([motion[i] for i in under_way], times, robots, start)
        for name, rows in waypoints.items():
            start[name] = rows[-1]
        ending = tuple(i for i in under_way if motion[i].times[-1] == end)
        yield MotionStretch(under_way, ending, waypoints, times, deviations, in_time=True)


def at_once(
    under_way: Sequence[Segment], times: Array, robots: Mapping[str, Robot], start: Mapping[str, Array]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The way points (W, n) and deviations (W - 1, n) of each robot that moves, at common times."""
    rows = [np.array([at_time(segment, t) for t in times]) for segment in under_way]
    off: list[Array | None] = [None] * len(rows)
    if any(segment.trajectory is not None for segment in under_way):
        together = joined_deviations([_polynomials(each) for each in under_way], np.hstack(rows), times)
        off = list(np.split(together, np.cumsum([own.shape[1] for own in rows])[:-1], axis=1))
    waypoints, deviations = {}, {}
    for segment, own, away in zip(under_way, rows, off, strict=True):
        robot = robots[segment.robot]
        waypoints[robot.name] = _whole(segment, robot, start[robot.name], own)
        deviations[robot.name] = _spread(segment, robot, own, away)
    return waypoints, deviations


def _polynomials(segment: Segment) -> Polynomials:
    """What a segment's joints follow; at constant velocities between way points without a trajectory."""
    own = segment.trajectory or Trajectory.linear(segment.joints, segment.waypoints, segment.times)
    return Polynomials(np.array(own.times), own.padded)


def _alone(number: int, segment: Segment, robot: Robot, start: dict[str, Array]) -> MotionStretch:
    """The stretch of a segment beside which nothing else moves."""
    points, times, own = np.array(segment.waypoints), np.array(segment.times), segment.trajectory
    whole = _whole(segment, robot, start[segment.robot], points)
    start[segment.robot] = whole[-1]
    off = None if own is None else path_deviations(np.array(own.times), own.padded, points, times)
    spread = _spread(segment, robot, points, off)
    return MotionStretch((number,), (number,), {segment.robot: whole}, times, {segment.robot: spread})


def _spread(segment: Segment, robot: Robot, rows: Array, off: Array | None) -> Array:
    """The deviations (W - 1, n) of all joints of the robot; zeros where there is no trajectory, and of those that stand."""
    found = np.zeros((len(rows) - 1, len(robot.joint_names)))
    if off is not None:
        stands = (np.ptp(rows, axis=0) == 0.0) & (off <= STILL)
        found[:, robot.columns(segment.joints)] = np.where(stands, 0.0, off)
    return found


def _common_times(under_way: Sequence[Segment], begin: float, end: float) -> Array:
    """The times (W,) of the way points of several segments at once."""
    ends = {time for segment in under_way for time in segment.times}
    trajectories = [segment.trajectory for segment in under_way if segment.trajectory is not None]
    ends |= {time for own in trajectories for time in own.times}
    inner = sorted(time for time in ends if begin + TIME_TOLERANCE < time < end - TIME_TOLERANCE)
    times = [begin, *inner, end]
    return passing_times(times) if trajectories else np.array(times)


def at_time(segment: Segment, time: float) -> Array:
    """The values of a segment's joints at a time [s]: on its trajectory, or linear between its way points."""
    if segment.trajectory is not None:
        return segment.trajectory.at(time)
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
    whole[:, robot.columns(segment.joints)] = rows
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
