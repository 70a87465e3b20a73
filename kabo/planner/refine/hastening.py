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
from kabo.tasks.robots.motion.smoothing import AT_GOALS, Smoothed, deviation_of, smoothed, smoothed_within
from kabo.tasks.robots.motion.timing import passing, timed_group
from kabo.tasks.robots.scenes import configuration
from kabo.tasks.robots.timed_paths import TimedPath

TRIES, MAX_VAIN = 400, 100  # changes of each motion, and those in a row that may be none for the better
LEAST_GAIN_S = 1e-3  # seconds that a change must save
LEFT_OUT = 0.15  # share of the changes that put no way point in place of others
ALONG = 0.15  # share of the changes that put one on the line of the stroke that follows, or came before
MOVED = 0.25  # share of the changes that move a way point by a random step alone: with less and less width they converge
WHOLE = 0.3  # share of the changes that replace all inner way points
INWARD, OUTWARD = (
    0.4,
    1.0,
)  # shares of its distance by which a way point moves to the middle of its neighbours, or away
FARTHEST = 0.5  # of a way's length: where a way point on the line of a stroke is, at most
WIDEST, NARROWEST = 0.5, 0.02  # how far a way point moves at random, of the distance of its neighbours
WIDER, NARROWER = 1.5, 0.95  # after a change that was taken, and after any other


@dataclass(frozen=True)
class _Draws:
    """The random numbers of a change, uniform in [0, 1)."""

    way: float
    first: float
    last: float
    whole: float
    kind: float
    share: float
    side: float
    noise: Array  # (n,), for each joint

    @classmethod
    def all(cls, key: Key, count: int, joints: int) -> "list[_Draws]":
        """Those of the first changes."""
        rows = uniforms(key, 0, count, 7 + joints)
        return [cls(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7:]) for r in rows]


@dataclass(frozen=True)
class _Hastened:
    """Parts of a motion, and the motion along them."""

    parts: tuple[MotionPart, ...]
    motion: Smoothed

    @property
    def seconds(self) -> float:
        return self.motion.parts[-1].times[-1]


def faster(
    context: ProcedureContext, situation: Situation, motion: Sequence[Segment], freedoms: Freedoms
) -> tuple[Segment, ...]:
    """The segments of a node's motion with trajectories, free ways made faster; all else as `timed` makes it."""

    def times_of(group: Sequence[MotionPart]) -> tuple[TimedPath, ...]:
        ways = [number for number, part in enumerate(group) if _is_free(part, freedoms)]
        if not ways:
            return timed_group(group)
        ends = *map(float, group[0].stretch.start), *map(float, group[-1].stretch.end)
        key = stream_key(context.seed, "hastened", group[0].stretch.robot, *ends)
        return hastened(group, ways, key).parts

    return timed(context, situation, motion, times_of=times_of)


def _is_free(part: MotionPart, freedoms: Freedoms) -> bool:
    each = part.stretch
    return freedoms.of(part.stage).kind == "way" and each.constraint is None and passing(part)


def hastened(
    parts: Sequence[MotionPart],
    ways: Sequence[int],
    key: Key,
    *,
    tries: int = TRIES,
    vain: int = MAX_VAIN,
) -> Smoothed:
    """The motion from rest to rest along all parts with other ways, proven, and no slower than with the given ones.

    Args:
        parts: stretches of an arm, each beginning where the one before ends.
        ways: the numbers of the parts whose paths may be replaced.
        key: of the random numbers; change i depends on (key, i) and what was taken before it only.
        tries: the number of changes.
        vain: the number of changes in a row that may be none for the better.
    """
    search = _Search(parts)
    best = _Hastened(tuple(parts), smoothed(parts, search.limits, search.deviation, search.held, AT_GOALS))
    width, since = WIDEST, 0
    for draws in _Draws.all(key, tries, len(parts[0].joints)):
        made = search.faster(best, ways[int(draws.way * len(ways))], draws, width)
        width = max(NARROWER * width, NARROWEST) if made is None else min(WIDER * width, WIDEST)
        best, since = (best, since + 1) if made is None else (made, 0)
        if since == vain:
            break
    return best.motion


class _Search:
    """What does not change from one change of a motion to the next."""

    def __init__(self, parts: Sequence[MotionPart]) -> None:
        first = parts[0]
        robot = first.scene.robot(first.stretch.robot)
        self.limits, self.held = motion_limits(robot, first.joints), first.held
        self.lower, self.upper = (bound[first.columns] for bound in (robot.tree.lower, robot.tree.upper))
        self.deviation, self.columns = deviation_of(parts), first.columns

    def faster(self, best: _Hastened, number: int, draws: _Draws, width: float) -> _Hastened | None:
        """The motion with a change of one of its ways; None if it is not proven, or not faster."""
        part = best.parts[number]
        corners = part.stretch.path[:, self.columns]
        changed = self._changed(best, number, corners[thinned(corners, 0.0)], draws, width)
        if changed is None:
            return None
        rows = np.tile(part.stretch.path[0], (len(changed), 1))
        rows[:, self.columns] = changed
        way = (part.stretch.start, *map(configuration, rows[1:-1]), part.stretch.end)
        if not all(part.proven(*map(np.array, piece)) for piece in zip(way, way[1:], strict=False)):
            return None
        parts = list(best.parts)
        parts[number] = replace(part, stretch=replace(part.stretch, waypoints=way))
        try:
            made = smoothed_within(
                parts, self.limits, self.deviation, self.held, AT_GOALS, best.seconds - LEAST_GAIN_S
            )
        except ValueError:  # what is held would slip there, even at rest
            return None
        return None if made is None else _Hastened(tuple(parts), made)

    def _changed(self, best: _Hastened, number: int, corners: Array, draws: _Draws, width: float) -> Array | None:
        """Corners (k, n) of a way, some of them replaced by one or none; None if nothing changes."""
        if draws.whole < WHOLE:
            first, last = 1, len(corners) - 1
        else:  # the corners from `first` to before `last`
            first = 1 + int(draws.first * (len(corners) - 1))
            last = first + int(draws.last**2 * (len(corners) - first))
        if draws.kind < LEFT_OUT:
            return None if first == last else np.concatenate([corners[:first], corners[last:]])
        if draws.kind < LEFT_OUT + ALONG:
            ahead = draws.side < 0.5
            point = self._on_stroke(best, number, draws.share * FARTHEST * _length(corners), ahead=ahead)
            if point is None:
                return None
            kept = (corners[:first], point, corners[-1:]) if ahead else (corners[:1], point, corners[last:])
            return np.concatenate(kept)
        if draws.kind > 1.0 - MOVED and len(corners) > 2:
            return self._moved(corners, 1 + int(draws.first * (len(corners) - 2)), draws, width)
        a, b = corners[first - 1], corners[last]
        middle = 0.5 * (a + b)
        base = corners[first:last].mean(axis=0) if last > first else middle
        away = (draws.share * (INWARD + OUTWARD) - INWARD) * (base - middle)
        noise = (2.0 * draws.noise - 1.0) * width * float(np.linalg.norm(b - a)) / np.sqrt(len(a))
        point = np.clip(base + away + noise, self.lower, self.upper)[None]
        return np.concatenate([corners[:first], point, corners[last:]])

    def _moved(self, corners: Array, at: int, draws: _Draws, width: float) -> Array:
        """Corners (k, n) of a way with one of them moved at random, by up to `width` of the distance of its neighbours."""
        apart = float(np.linalg.norm(corners[at + 1] - corners[at - 1]))
        step = (2.0 * draws.noise - 1.0) * width * apart / np.sqrt(corners.shape[1])
        found = np.array(corners)
        found[at] = np.clip(corners[at] + step, self.lower, self.upper)
        return found

    def _on_stroke(self, best: _Hastened, number: int, distance: float, *, ahead: bool) -> Array | None:
        """The point (1, n) at a distance from the end of a way, on the line of the part that follows; or from its start."""
        other = number + 1 if ahead else number - 1
        if not 0 <= other < len(best.parts):
            return None
        path = best.parts[other].stretch.path[:, self.columns]
        end, inner = (path[0], path[1]) if ahead else (path[-1], path[-2])
        point = end + distance * (end - inner) / np.linalg.norm(end - inner)
        return np.asarray(np.clip(point, self.lower, self.upper))[None]


def _length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
