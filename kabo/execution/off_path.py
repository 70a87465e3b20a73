"""How far robots are off the path that is proven: all of them are compared with one time of the motion.

Robots that follow late, all by as much, are on this path: together they are where the proof has looked. So they are
compared with where they should have been at the time, now or not long ago, with which they agree best. A hand acts when
robots are where they should be at that time; then no time before it counts any more: proofs are of other things from there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.execution.link_origins import LinkOrigins
from kabo.execution.margins import Margins
from kabo.execution.motions import SAME_TIME, Motion
from kabo.execution.protocols import RobotState
from kabo.scene import Scene

LATE_FROM = 0.1  # share of what is permitted, from which it is asked whether robots that are off are only late
PLACES, REFINED = 11, 4  # times that are looked at, and how often ever nearer


class Off(NamedTuple):
    """How far any origin of a robot's links is off its path, and how far it may be [m]; `planned`: its joints there."""

    off: float
    permitted: float
    planned: tuple[float, ...]


class OffPath(NamedTuple):
    """The time of the motion with which robots agree best [s], and how far each is off then."""

    time: float
    robots: Mapping[str, Off]


def off_path(
    scene: Scene,
    margins: Margins,
    motion: Motion,
    resting: Mapping[str, Sequence[float]],
    state: RobotState,
    since: float,
) -> OffPath:
    """How far robots are off the path of a motion.

    Args:
        scene: of the robots. margins: what the plan has proven. motion: that is followed.
        resting: the values of all joints of each robot before it.
        state: what is measured. since: the first time of the motion that counts [s].
    """
    now = state.motion_time
    since = min(since, now)
    proven: dict[str, list[tuple[float, float, float]]] = {name: [] for name in scene.robots}
    for each in motion.stretches:
        if each.begin <= now + SAME_TIME and each.end >= since - SAME_TIME:
            room = margins.of_segment(each.node, each.segment)
            proven[each.robot].append((each.begin - SAME_TIME, each.end + SAME_TIME, room))
    path = _Path(scene, motion, resting, state, proven)
    found = path.at(np.array([now]))
    if not found.is_near and since < now:
        high = now
        for _ in range(REFINED):
            # From late to early: of times that are as good the last one counts.
            seen = path.at(np.linspace(high, since, PLACES))
            k = int(np.argmin(seen.squares))
            high, since = seen.times[max(0, k - 1)], seen.times[min(k + 1, PLACES - 1)]
            found = seen.only(k) if seen.squares[k] < found.squares[0] else found
    robots = {
        name: Off(float(own.off[0]), float(own.room[0]), tuple(own.rows[0].tolist()))
        for name, own in found.robots.items()
    }
    return OffPath(float(found.times[0]), robots)


class _One(NamedTuple):
    """How far a robot is off, and may be (k,) [m], from where it should be (k, n)."""

    off: Array
    room: Array
    rows: Array


class _Compared(NamedTuple):
    """How far each robot is off at times (k,)."""

    times: Array
    robots: Mapping[str, _One]

    @property
    def squares(self) -> Array:
        """The sum of squares of how far robots are off (k,) [m²]."""
        return np.asarray(sum(own.off * own.off for own in self.robots.values()), np.float64)

    @property
    def is_near(self) -> bool:
        """Whether each robot is off by so little that nothing is asked."""
        return all(own.off[0] <= LATE_FROM * own.room[0] for own in self.robots.values())

    def only(self, k: int) -> "_Compared":
        robots = {name: _One(*(each[k : k + 1] for each in own)) for name, own in self.robots.items()}
        return _Compared(self.times[k : k + 1], robots)


@dataclass
class _Path:
    """The path of all robots; `proven`: begin, end and clearance of each robot's stretches within the times that count."""

    scene: Scene
    motion: Motion
    resting: Mapping[str, Sequence[float]]
    state: RobotState
    proven: Mapping[str, Sequence[tuple[float, float, float]]]

    def at(self, times: Array) -> _Compared:
        """How far robots are off where they should be at some times (k,)."""
        return _Compared(times, {name: self._one(name, times) for name in self.proven})

    def _one(self, name: str, times: Array) -> _One:
        robot, actual = self.scene.robots[name], self.state.positions[name]
        rows = self.motion.rows(robot, self.resting[name], times[::-1])
        off = LinkOrigins.of(robot).farthest(rows, actual)
        return _One(off[::-1], self._room(self.proven[name], times), rows[::-1])

    @staticmethod
    def _room(proven: Sequence[tuple[float, float, float]], times: Array) -> Array:
        """What is proven at times (k,); at rest between two stretches the least of both, without any it is infinite."""
        every = min((own for *_, own in proven), default=inf)
        at_each = (
            min((own for begin, end, own in proven if begin <= time <= end), default=inf)
            for time in times.tolist()
        )
        return np.array([every if least == inf else least for least in at_each])
