"""Slows down the clock of a motion where robots would be farther off their path than is proven to be free.

Robots that are all as late are on their path (kabo.execution.off_path). What is left is that motors are weak, and that
one robot is later than another: both are taken to be proportional to speed, so that at half the rate of the clock a robot
is off by half as much. By how much is found while robots move; what they are off at rest, no clock changes. The rate is
such that what is foreseen within the next second is a share of the proven clearance.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil, log
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.link_origins import LinkOrigins
from kabo.execution.margins import Margins
from kabo.execution.motions import Motion
from kabo.execution.off_path import OffPath
from kabo.execution.protocols import RobotState
from kabo.scene import Robot

SHARE = 0.3  # of the proven clearance, that may be foreseen of origins of links: corners move faster
NOTICED = 0.15  # share of the proven clearance, below which nothing is asked about the reason
LEAST, STEP = 0.02, 0.9  # rates: the slowest, and the ratio of one to the one before
SLOWER, FASTER = 0.91, 1.2  # ratio to the rate now, beyond which the rate is changed
FORESEEN = 1.0  # [s] on the clock of the motion
CELL = 0.02  # [s]
RECENT = 0.06  # [s] within which a robot was as fast as it is off now
MOVES = 0.05  # [m/s] below which a robot is not found to stray
FORGOTTEN = 1.0  # [s], time constant


class Pace(NamedTuple):
    """A rate of the clock, and the reason in a sentence."""

    rate: float
    reason: str


@dataclass
class Pacer:
    """Says at which rate the clock of a motion runs, in one run with all its plans."""

    robots: Mapping[str, Robot]
    rate: float = 1.0  # that was asked for last
    strays: dict[str, float] = field(
        default_factory=dict
    )  # how far robots are off their paths, by their speed [s]

    def begin(
        self, motion: Motion, belief: Belief, margins: Margins, standing: Mapping[str, float]
    ) -> Pace | None:
        """The rate with which a motion begins, if it is another one than that of the motion before.

        Args:
            motion: it. belief: where all is before it. margins: of the plan.
            standing: how far robots are off now, at rest [m].
        """
        self.motion, self.planned, self.margins = motion, dict(belief.state.robots), margins
        self.standing = standing
        self._fast: dict[str, tuple[Array, Array]] | None = None
        self._before: RobotState | None = None
        return self.wanted(motion.begin)

    def learn(self, state: RobotState, path: OffPath) -> None:
        """Takes into account how far robots are off while they move."""
        before, self._before = self._before, state
        if before is None or state.time <= before.time:
            return
        seconds = state.time - before.time
        rate = (state.motion_time - before.motion_time) / seconds
        for name, own in path.robots.items():
            if own.off < NOTICED * own.permitted and name not in self.strays:
                continue
            moved = self._speeds[name][0][self._cell(path.time - RECENT) : self._cell(state.motion_time) + 1]
            speed, known = float(moved.max(initial=0.0)) * rate, self.strays.get(name, 0.0)
            found = max(0.0, own.off - self.standing.get(name, 0.0)) / max(speed, MOVES)
            if known > found:
                found = known + (found - known) * min(1.0, seconds / FORGOTTEN)
            elif speed < MOVES:  # it may be off for other reasons
                continue
            self.strays[name] = found

    def wanted(self, time: float) -> Pace | None:
        """The rate from a time of the motion on, if it is worth a change."""
        least, reason = 1.0, "robots are near enough to their paths at full speed"
        for name, stray in self.strays.items():
            if stray > 0.0:
                rate, text = self._rate_of(name, stray, time)
                least, reason = (rate, text) if rate < least else (least, reason)
        rate = 1.0 if least >= 1.0 else max(LEAST, STEP ** ceil(log(max(least, LEAST)) / log(STEP)))
        if SLOWER * self.rate < rate < FASTER * self.rate and not rate == 1.0 > self.rate:
            return None
        return Pace(round(rate, 3), reason)

    def _rate_of(self, name: str, stray: float, time: float) -> tuple[float, str]:
        speeds, permitted = self._speeds[name]
        ahead = slice(self._cell(time), self._cell(time + FORESEEN) + 1)
        off, room = stray * speeds[ahead], SHARE * permitted[ahead] - self.standing.get(name, 0.0)
        if not (off > room).any():
            return 1.0, ""
        rates = np.divide(np.maximum(room, 0.0), off, out=np.full(len(off), np.inf), where=off > 0.0)
        worst = int(np.argmin(rates))
        whole, proven = 1000.0 * (off[worst] + self.standing.get(name, 0.0)), 1000.0 * permitted[ahead][worst]
        text = f"{name} does not keep up: at full speed it would be {whole:.1f} mm off its path"
        return float(rates[worst]), f"{text}, and {proven:.1f} mm are proven to be free"

    def _cell(self, time: float) -> int:
        return max(0, int((time - self.motion.begin) / CELL))

    @property
    def _speeds(self) -> Mapping[str, tuple[Array, Array]]:
        """By robot, for each cell of the motion's clock: its speed [m/s], and what is proven [m]."""
        if self._fast is None:
            self._fast = {name: self._along(name) for name in self.robots}
        return self._fast

    def _along(self, name: str) -> tuple[Array, Array]:
        motion, robot = self.motion, self.robots[name]
        count = max(1, int(np.ceil((motion.end - motion.begin) / CELL)))
        times = np.asarray(motion.begin + CELL * np.arange(count + 1), np.float64)
        rows, permitted = motion.rows(robot, self.planned[name], times), np.full(count, np.inf)
        for each in motion.stretches:
            if each.robot == name:
                inside = (times[1:] >= each.begin) & (times[:-1] <= each.end)
                permitted[inside] = np.minimum(permitted[inside], self.margins.of_segment(each.node, each.segment))
        rows[:, robot.planned :] = rows[0, robot.planned :]  # hands are not judged
        steps = np.diff(LinkOrigins.of(robot).at(rows), axis=0)
        return np.linalg.norm(steps, axis=2).max(axis=1, initial=0.0) / CELL, permitted
