"""The timeline of a node: windows of time in which the same segments run; segments of several robots may overlap.

In a window all moving robots share one path over all of their joints. Its way points are at the times of all way
points of these robots.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.sweep import Path

TIME_TOLERANCE = 1e-9  # [s] times nearer than this count as equal


@dataclass(frozen=True)
class Window:
    """A window of time, with the indices of the segments that run in it, start at its start, or end at its end."""

    start: float
    end: float
    running: tuple[int, ...]
    starting: tuple[int, ...]
    ending: tuple[int, ...]


def windows(segments: Sequence[Segment]) -> Iterator[Window]:
    """The windows of a motion in the order of time, without pauses; the times of every segment must increase."""
    times = sorted({time for segment in segments for time in (segment.times[0], segment.times[-1])})
    cuts = [t for k, t in enumerate(times) if k == 0 or t - times[k - 1] > TIME_TOLERANCE]
    for start, end in zip(cuts, cuts[1:], strict=False):
        running = [
            i
            for i, s in enumerate(segments)
            if s.times[0] <= start + TIME_TOLERANCE and s.times[-1] >= end - TIME_TOLERANCE
        ]
        if running:
            starting = tuple(i for i in running if abs(segments[i].times[0] - start) <= TIME_TOLERANCE)
            ending = tuple(i for i in running if abs(segments[i].times[-1] - end) <= TIME_TOLERANCE)
            yield Window(start, end, tuple(running), starting, ending)


def one_by_one(segments: Sequence[Segment]) -> list[Segment]:
    """The segments; one that begins before the robot's preceding segment has ended is delayed until that end."""
    ended: dict[str, float] = {}
    result: dict[int, Segment] = {}
    for i in sorted(range(len(segments)), key=lambda i: segments[i].times[0]):
        segment = segments[i]
        late = ended.get(segment.robot, 0.0) - segment.times[0]
        if late > TIME_TOLERANCE:
            segment = replace(segment, times=tuple(time + late for time in segment.times))
        ended[segment.robot] = segment.times[-1]
        result[i] = segment
    return [result[i] for i in range(len(segments))]


def columns(segment: Segment, arm: Arm) -> list[int]:
    """The columns of a segment's joints in a configuration of its robot."""
    return [arm.robot.joint_names.index(joint) for joint in segment.joints]


def at_time(segment: Segment, arm: Arm, q: Array, time: float) -> Array:
    """The robot's configuration at a time; before and after the segment, its first and last way point are used."""
    result: Array = q.copy()
    waypoints = np.asarray(segment.waypoints)
    for k, column in enumerate(columns(segment, arm)):
        result[column] = np.interp(time, segment.times, waypoints[:, k])
    return result


def whole_path(segment: Segment, arm: Arm, q: Array) -> Path:
    """The path of a segment; the joints that it does not move have their values in `q`."""
    configurations = np.tile(q, (len(segment.waypoints), 1))
    configurations[:, columns(segment, arm)] = segment.waypoints
    return Path(arm, configurations, segment.times)


def window_path(
    window: Window, segments: Sequence[Segment], arms: Mapping[str, Arm], q: Mapping[str, Array]
) -> Path:
    """The path of all robots that move in a window."""
    running = [segments[i] for i in window.running]
    if len(running) == 1 and window.starting and window.ending:
        return whole_path(running[0], arms[running[0].robot], q[running[0].robot])
    inner = {
        t for s in running for t in s.times if window.start + TIME_TOLERANCE < t < window.end - TIME_TOLERANCE
    }
    times = [window.start, *sorted(inner), window.end]
    rows = [np.concatenate([at_time(s, arms[s.robot], q[s.robot], time) for s in running]) for time in times]
    return Path([arms[s.robot] for s in running], np.array(rows), times)
