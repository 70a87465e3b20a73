"""Makes the motion between two rests faster: way points of its free ways are moved, left out or added.

Shortcuts lead closely past obstacles, where no wide round is proven, and joints slow down at narrow ones; a path that is a
little longer is often faster. So the duration of the whole motion decides, strokes before and after a way included. Every
change is a counted sample; one that is faster is taken if all of its motion is proven.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import ProcedureContext, Situation
from kabo.motion import thinned
from kabo.plan import Segment
from kabo.planner.refine.freedom import Freedoms
from kabo.planner.refine.timing import timed
from kabo.scene import motion_limits
from kabo.streams import Key, stream_key, uniforms
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.smoothing import DEVIATION, Smoothed, deviation_of, smoothed, smoothed_within
from kabo.tasks.robots.motion.timing import passing, timed_group
from kabo.tasks.robots.scenes import configuration
from kabo.tasks.robots.timed_paths import TimedPath

TRIES, MAX_VAIN = 100, 30  # changes of each motion, and those in a row that may be none for the better
LEAST_GAIN_S = 1e-3  # seconds that a change must save
WHOLE = 0.3  # share of the changes that replace all inner way points
DRAWS = 6  # random numbers of a change, besides one for each joint
LEFT_OUT = 0.15  # share of the changes that put no way point in place of others
ALONG = 0.15  # share of the changes that put one on the line of the stroke that follows, or came before
INWARD, OUTWARD = (
    0.4,
    1.0,
)  # how far a way point moves from or to the middle of its neighbours, of its distance from it
FARTHEST = 0.5  # of a way's length: where a way point on the line of a stroke is, at most
WIDEST, NARROWEST = 0.5, 0.02  # how far a way point moves at random, of the distance of its neighbours
WIDER, NARROWER = 1.5, 0.9  # after a change that was taken, and after any other


@dataclass(frozen=True)
class _Hastened:
    parts: tuple[MotionPart, ...]
    motion: Smoothed

    @property
    def seconds(self) -> float:
        return self.motion.parts[-1].times[-1]


def faster(
    context: ProcedureContext, situation: Situation, motion: Sequence[Segment], freedoms: Freedoms
) -> tuple[Segment, ...]:
    """The segments of a node's motion with trajectories, free ways made faster; all else as `timed` makes it."""

    def times_of(group: Sequence[MotionPart], deviation: float) -> tuple[TimedPath, ...]:
        ways = [number for number, part in enumerate(group) if _is_free(part, freedoms)]
        if not ways:
            return timed_group(group, deviation)
        ends = *map(float, group[0].stretch.start), *map(float, group[-1].stretch.end)
        key = stream_key(context.seed, "hastened", group[0].stretch.robot, *ends)
        return hastened(group, ways, key, deviation=deviation).parts

    return timed(context, situation, motion, times_of=times_of)


def _is_free(part: MotionPart, freedoms: Freedoms) -> bool:
    each = part.stretch
    return freedoms.of(part.stage).kind == "way" and each.constraint is None and passing(part)


def hastened(
    parts: Sequence[MotionPart],
    ways: Sequence[int],
    key: Key,
    *,
    deviation: float = DEVIATION,
    tries: int = TRIES,
    vain: int = MAX_VAIN,
) -> Smoothed:
    """The motion from rest to rest along all parts with other ways, proven, and no slower than with the given ones.

    Args:
        parts: stretches of an arm, each beginning where the one before ends.
        ways: the numbers of the parts whose paths may be replaced.
        key: of the random numbers; change i depends on (key, i) and what was taken before it only.
        deviation: how far the motion may pass by way points [rad, L2].
        tries: the number of changes.
        vain: the number of changes in a row that may be none for the better.
    """
    search = _Search(parts[0], deviation)
    best = _Hastened(tuple(parts), smoothed(parts, search.limits, search.deviation, search.held))
    width, since = WIDEST, 0
    draws = uniforms(key, 0, tries, DRAWS + len(parts[0].joints))
    for row in draws:
        made = search.faster(best, ways[int(row[0] * len(ways))], row[1:], width)
        width = max(NARROWER * width, NARROWEST) if made is None else min(WIDER * width, WIDEST)
        best, since = (best, since + 1) if made is None else (made, 0)
        if since == vain:
            break
    return best.motion


class _Search:
    """What does not change from one change of a motion to the next."""

    def __init__(self, first: MotionPart, deviation: float) -> None:
        robot = first.scene.robot(first.stretch.robot)
        self.limits, self.held = motion_limits(robot, first.joints), first.held
        self.lower, self.upper = (bound[first.columns] for bound in (robot.tree.lower, robot.tree.upper))
        self.deviation, self.columns = deviation_of(first, deviation), first.columns

    def faster(self, best: _Hastened, number: int, draws: Array, width: float) -> _Hastened | None:
        """The motion with a change of one of its ways, drawn by `draws`; None if it is not proven, or not faster."""
        part = best.parts[number]
        path = part.stretch.path[:, self.columns]
        kept = thinned(path, 0.0)
        changed = self._changed(best, number, path[kept], draws, width)
        if changed is None:
            return None
        rows = np.tile(part.stretch.path[0], (len(changed), 1))
        rows[:, self.columns] = changed
        rows = np.array([configuration(q) for q in rows])
        rows[[0, -1]] = part.stretch.path[[0, -1]]
        if not all(part.proven(a, b) for a, b in zip(rows, rows[1:], strict=False)):
            return None
        own = replace(part, stretch=replace(part.stretch, waypoints=tuple(map(configuration, rows))))
        parts = (*best.parts[:number], own, *best.parts[number + 1 :])
        made = smoothed_within(parts, self.limits, self.deviation, self.held, best.seconds - LEAST_GAIN_S)
        return None if made is None else _Hastened(parts, made)

    def _changed(self, best: _Hastened, number: int, corners: Array, draws: Array, width: float) -> Array | None:
        """Corners (k, n) of a way, some of them replaced by one or none; None if nothing changes."""
        first = 1 + int(draws[0] * (len(corners) - 1))
        last = first + int(draws[1] ** 2 * (len(corners) - first))  # the corners from `first` to before `last`
        if draws[4] > 1.0 - WHOLE:
            first, last = 1, len(corners) - 1
        a, b = corners[first - 1], corners[last]
        kind, share = draws[2], draws[3]
        if kind < LEFT_OUT:
            return None if first == last else np.concatenate([corners[:first], corners[last:]])
        if kind < LEFT_OUT + ALONG:
            ahead = bool(draws[4] < 0.5)
            point = self._on_stroke(best, number, share * FARTHEST * _length(corners), ahead)
            if point is None:
                return None
            inner = corners[:first] if ahead else corners[last:]
            return np.concatenate([inner, [point], corners[-1:]] if ahead else [corners[:1], [point], inner])
        middle = 0.5 * (a + b)
        base = corners[first:last].mean(axis=0) if last > first else middle
        away = (share * (INWARD + OUTWARD) - INWARD) * (base - middle)
        noise = (2.0 * draws[5:] - 1.0) * width * float(np.linalg.norm(b - a)) / np.sqrt(len(a))
        point = np.clip(base + away + noise, self.lower, self.upper)
        return np.concatenate([corners[:first], [point], corners[last:]])

    def _on_stroke(self, best: _Hastened, number: int, distance: float, ahead: bool) -> Array | None:
        """The point (n,) at a distance from the end of a way, on the line of the part that follows; or from its start."""
        other = number + 1 if ahead else number - 1
        if not 0 <= other < len(best.parts):
            return None
        path = best.parts[other].stretch.path[:, self.columns]
        end, inner = (path[0], path[1]) if ahead else (path[-1], path[-2])
        point = end + distance * (end - inner) / np.linalg.norm(end - inner)
        return np.clip(point, self.lower, self.upper)


def _length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
