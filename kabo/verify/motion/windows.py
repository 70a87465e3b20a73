"""The timeline of a node: windows of time in which the same segments run; segments of several robots may overlap.

In a window all moving robots share one path over all of their joints. Its way points are at the times of all way
points of these robots; with trajectories also where polynomials end, and every `TIME_STEP`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.sweep import Path
from kabo.verify.motion.trajectories.deviations import ROUNDING, from_chords, from_rest_of_piece
from kabo.verify.motion.trajectories.judge import Followed

TIME_TOLERANCE = 1e-9  # [s] times nearer than this count as equal
TIME_STEP = 0.02  # [s] at most between way points of robots that move at the same time
FINE_DEVIATION, MAX_FINE_PARTS = (
    1e-5,
    20,
)  # [rad or m] of joints from chords where bodies nearly touch; parts of a step


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
            segment = _delayed(segment, late)
        ended[segment.robot] = segment.times[-1]
        result[i] = segment
    return [result[i] for i in range(len(segments))]


def _delayed(segment: Segment, late: float) -> Segment:
    own = segment.trajectory
    if own is not None:
        own = replace(own, times=tuple(time + late for time in own.times))
    return replace(segment, times=tuple(time + late for time in segment.times), trajectory=own)


def columns(segment: Segment, arm: Arm) -> list[int]:
    """The columns of a segment's joints in a configuration of its robot."""
    return [arm.robot.joint_names.index(joint) for joint in segment.joints]


def whole_path(segment: Segment, arm: Arm, q: Array, how: Followed) -> Path:
    """The path of a segment; the joints that it does not move have their values in `q`."""
    own = columns(segment, arm)
    configurations = np.tile(q, (len(segment.waypoints), 1))
    configurations[:, own] = segment.waypoints
    deviations = np.zeros((len(configurations) - 1, len(q)))
    deviations[:, own] = how.deviations
    return Path(arm, configurations, segment.times, deviations, ((tuple(own), how.curve),) if how.given else ())


def window_path(
    window: Window,
    segments: Sequence[Segment],
    arms: Mapping[str, Arm],
    q: Mapping[str, Array],
    how: Sequence[Followed],
    *,
    fine: bool = False,
) -> Path:
    """The path of all robots that move in a window.

    Where a segment runs that neither begins nor ends with the window, or several run at once, the path has the
    positions of all at common times, and the deviations from the chords between these. With `fine` there are so many
    times that deviations are hardly above `FINE_DEVIATION`, and a segment alone that deviates more has such a path, too.
    """
    alone = len(window.running) == 1 and window.starting and window.ending
    only = window.running[0]
    if alone and not (fine and float(how[only].deviations.max(initial=0.0)) > FINE_DEVIATION):
        segment = segments[only]
        return whole_path(segment, arms[segment.robot], q[segment.robot], how[only])
    running = [segments[i] for i in window.running]
    times = _common_times(window, segments, how)
    times = _finer(times, [how[i] for i in window.running if how[i].given]) if fine else times
    rows, deviations, curves, first = [], [], [], 0
    for i in window.running:
        segment, still = segments[i], q[segments[i].robot]
        own = columns(segment, arms[segment.robot])
        row, off = np.tile(still, (len(times), 1)), np.zeros((len(times) - 1, len(still)))
        if how[i].given:
            row[:, own] = how[i].curve.at(times)
            off[:, own] = from_chords(how[i].curve, times)
            curves.append((tuple(first + column for column in own), how[i].curve))
        else:
            points = np.asarray(segment.waypoints)
            row[:, own] = np.column_stack([np.interp(times, segment.times, values) for values in points.T])
        rows.append(row)
        deviations.append(np.where((np.ptp(row, axis=0) == 0.0) & (off <= ROUNDING), 0.0, off))
        first += len(still)
    together = [arms[segment.robot] for segment in running]
    return Path(together, np.hstack(rows), times, np.hstack(deviations), curves, in_time=True)


def fine_path(
    i: int,
    segments: Sequence[Segment],
    arms: Mapping[str, Arm],
    q: Mapping[str, Array],
    how: Sequence[Followed],
) -> Path:
    """The path of segment i alone, with deviations hardly above `FINE_DEVIATION`."""
    times = segments[i].times
    return window_path(Window(times[0], times[-1], (i,), (i,), (i,)), segments, arms, q, how, fine=True)


def _common_times(window: Window, segments: Sequence[Segment], how: Sequence[Followed]) -> Array:
    """The times of a window's path: of all way points, of the ends of all polynomials, and not too far apart."""
    ends = {t for i in window.running for t in segments[i].times}
    ends |= {float(t) for i in window.running if how[i].given for t in how[i].curve.times}
    inner = {t for t in ends if window.start + TIME_TOLERANCE < t < window.end - TIME_TOLERANCE}
    times = [window.start, *sorted(inner), window.end]
    if not any(how[i].given for i in window.running):
        return np.array(times)
    parts = [max(1, int(np.ceil((b - a) / TIME_STEP - 1e-9))) for a, b in zip(times, times[1:], strict=False)]
    cut = [np.arange(n) / n * (b - a) + a for a, b, n in zip(times, times[1:], parts, strict=False)]
    return np.concatenate([*cut, [window.end]])


def _finer(times: Array, how: Sequence[Followed]) -> Array:
    """Times (m,) with more between them where trajectories leave their chords by more than `FINE_DEVIATION`."""
    if not how:
        return times
    off = np.max([from_chords(each.curve, times).max(axis=1) for each in how], axis=0)
    # A chord of a part is left by the square of its share.
    counts = np.clip(np.ceil(np.sqrt(off / FINE_DEVIATION)), 1, MAX_FINE_PARTS).astype(int)
    cut = [a + np.arange(n) / n * (b - a) for a, b, n in zip(times, times[1:], counts, strict=False)]
    return np.concatenate([*cut, times[-1:]])


def rest_of(path: Path, time: float) -> Path:
    """What is left of a path after a time [s] at which the robots move along it."""
    later = path.times > time
    piece = int(later.argmax()) - 1
    row = np.array([np.interp(time, path.times, column) for column in path.configurations.T])
    deviations = path.deviations[piece:].copy()
    times = np.array([time, *path.times[later]])
    goal = path.configurations[piece + 1]
    now, rest = np.array([time]), times[:2]
    if path.in_time:
        for own, curve in path.curves:
            row[list(own)] = curve.at(now)[0]
            deviations[0, list(own)] = from_chords(curve, rest)[0]
    elif path.curves:
        ((own, curve),) = path.curves
        start, way = path.configurations[piece, list(own)], (goal - path.configurations[piece])[list(own)]
        square = float(way @ way)
        share = float((curve.at(now)[0] - start) @ way) / square if square > 0.0 else 0.0
        row[list(own)] = start + min(1.0, max(0.0, share)) * way
        ends = np.array([row, goal])[:, list(own)]
        deviations[0, list(own)] = from_rest_of_piece(curve, ends, rest)
    rows = np.concatenate([row[None], path.configurations[later]])
    return Path(tuple(path.arms.values()), rows, times, deviations)
