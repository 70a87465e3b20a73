"""The timeline of a node: windows of time in which the same segments run; segments of several robots may overlap.

In a window all moving robots share one path over all of their joints. Its way points are at the times of all way
points of these robots; with trajectories also where polynomials end, and in steps between. Between two of them the
joined trajectory is compared with its projection onto the straight piece between both, as that of one robot is.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.sweep import Path
from kabo.verify.motion.trajectories.curves import Curve
from kabo.verify.motion.trajectories.deviations import ROUNDING, from_joined, from_rest_of_piece
from kabo.verify.motion.trajectories.judge import Followed

TIME_TOLERANCE = 1e-9  # [s] times nearer than this count as equal
TIME_STEP = 0.02  # [s] at most between way points of robots that move at the same time,
MAX_STEPS = 100  # but no more of them in one polynomial: slow motions have the same shape as fast ones
FINE_DEVIATION = 1e-5  # [rad or m] of joints from pieces where bodies nearly touch, about
MAX_FINE_PARTS = 20  # of a step, for this


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
    positions of all at common times, and the deviations from the pieces between these. With `fine` there are so many
    times that deviations are hardly above `FINE_DEVIATION`, and a segment alone that deviates more has such a path, too.
    """
    alone = len(window.running) == 1 and window.starting and window.ending
    only = window.running[0]
    if alone and not (fine and float(how[only].deviations.max(initial=0.0)) > FINE_DEVIATION):
        segment = segments[only]
        return whole_path(segment, arms[segment.robot], q[segment.robot], how[only])
    running = [segments[i] for i in window.running]
    times = _common_times(window, segments, how)
    given = any(how[i].given for i in window.running)
    curves = [how[i].curve for i in window.running] if given else []
    times = _finer(times, curves) if fine else times
    rows, own, first = [], [], 0
    for i in window.running:
        segment, still = segments[i], q[segments[i].robot]
        joints = columns(segment, arms[segment.robot])
        row = np.tile(still, (len(times), 1))
        row[:, joints] = how[i].curve.at(times) if how[i].given else _linear(segment, times)
        rows.append(row)
        own.append(tuple(first + joint for joint in joints))
        first += len(still)
    whole, together = np.hstack(rows), [arms[segment.robot] for segment in running]
    joined = tuple(zip(own, curves, strict=True)) if given else ()
    return _joined_path(together, whole, times, joined)


def _linear(segment: Segment, times: Array) -> Array:
    points = np.asarray(segment.waypoints)
    return np.column_stack([np.interp(times, segment.times, values) for values in points.T])


Curves = Sequence[tuple[tuple[int, ...], Curve]]  # of several robots: the columns that each is about


def _joined_path(arms: Sequence[Arm], rows: Array, times: Array, curves: Curves) -> Path:
    """The path of several robots whose joints are one chain, through rows (m, n) where all are at `times` (m,)."""
    off, alone = np.zeros((2, len(times) - 1, rows.shape[1]))
    if curves:
        off[:, [column for own, _ in curves for column in own]] = from_joined([c for _, c in curves], times)
    for own, curve in curves:
        alone[:, list(own)] = from_joined([curve], times)
    still = np.ptp(rows, axis=0) == 0.0
    off, alone = (np.where(still & (each <= ROUNDING), 0.0, each) for each in (off, alone))
    return Path(arms, rows, times, off, tuple(curves), alone=alone, in_time=True)


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
    parts = np.clip(np.ceil(np.diff(times) / TIME_STEP - 1e-9), 1, MAX_STEPS).astype(int)
    cut = [np.arange(n) / n * (b - a) + a for a, b, n in zip(times, times[1:], parts, strict=False)]
    return np.concatenate([*cut, [window.end]])


def _finer(times: Array, curves: Sequence[Curve]) -> Array:
    """Times (m,) with more between them where joined trajectories leave their pieces by more than `FINE_DEVIATION`."""
    if not curves:
        return times
    off = from_joined(curves, times).max(axis=1)
    # What a piece is left by falls with the square of the share of a part.
    counts = np.clip(np.ceil(np.sqrt(off / FINE_DEVIATION)), 1, MAX_FINE_PARTS).astype(int)
    cut = [a + np.arange(n) / n * (b - a) for a, b, n in zip(times, times[1:], counts, strict=False)]
    return np.concatenate([*cut, times[-1:]])


def rest_of(path: Path, time: float) -> Path:
    """What is left of a path after a time [s] at which the robots move along it."""
    later = path.times > time
    piece, now = int(later.argmax()) - 1, np.array([time])
    row = np.array([np.interp(time, path.times, column) for column in path.configurations.T])
    times = np.array([time, *path.times[later]])
    if path.in_time:
        for own, curve in path.curves:
            row[list(own)] = curve.at(now)[0]
        rows = np.concatenate([row[None], path.configurations[later]])
        return _joined_path(tuple(path.arms.values()), rows, times, path.curves)
    deviations, goal = path.deviations[piece:].copy(), path.configurations[piece + 1]
    if path.curves:
        ((own, curve),) = path.curves
        start, way = path.configurations[piece, list(own)], (goal - path.configurations[piece])[list(own)]
        square = float(way @ way)
        share = float((curve.at(now)[0] - start) @ way) / square if square > 0.0 else 0.0
        row[list(own)] = start + min(1.0, max(0.0, share)) * way
        ends = np.array([row, goal])[:, list(own)]
        deviations[0, list(own)] = from_rest_of_piece(curve, ends, times[:2])
    rows = np.concatenate([row[None], path.configurations[later]])
    return Path(tuple(path.arms.values()), rows, times, deviations)
