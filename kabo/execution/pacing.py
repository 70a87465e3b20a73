"""Slows down the clock of a motion where robots would be farther off their path than is proven to be free.

A robot that follows late by L seconds is off by L v where its links move at v: at half the rate of the clock by half as
much. L is stated by its maker, or found from how far it is off now; what it is off at rest, no clock changes. Where nothing
else moves a late robot is on its path all the same: there only what it strays from the path counts, as weak motors let it,
which is taken to be proportional to speed, too. The rate is such that what is foreseen within the next second is a share of
the proven clearance.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil, log
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Booleans
from kabo.execution.belief import Belief
from kabo.execution.link_origins import LinkOrigins
from kabo.execution.margins import Margins
from kabo.execution.motions import Motion
from kabo.execution.protocols import RobotState
from kabo.scene import Robot

SHARE = 0.3  # of the proven clearance, that may be foreseen of origins of links: corners move faster
NOTICED = 0.15  # share of the proven clearance, below which nothing is asked about the reason
LEAST, STEP = 0.02, 0.9  # rates: the slowest, and the ratio of one to the one before
SLOWER, FASTER = 0.91, 1.2  # ratio to the rate now, beyond which the rate is changed
FORESEEN = 1.0  # [s] on the clock of the motion
CELL = 0.02  # [s]
RECENT = 0.06  # [s] within which a robot that is late was as fast as it is off now
MOVES = 0.05  # [m/s] below which nothing is said about how late a robot is
FORGOTTEN = 1.0  # [s], time constant


class Pace(NamedTuple):
    """A rate of the clock, and the reason in a sentence."""

    rate: float
    reason: str


class Off(NamedTuple):
    """How far a robot is off its path, and how far it may be [m]; how late it is there, on the motion's clock [s]."""

    off: float
    permitted: float
    late: float = 0.0
    alone: bool = False  # whether nothing else moves


@dataclass
class Pacer:
    """Says at which rate the clock of a motion runs, in one run with all its plans.

    Args:
        robots: of the scene.
        delay: how late robots follow, as their maker says [s].
    """

    robots: Mapping[str, Robot]
    delay: float = 0.0
    rate: float = 1.0  # that was asked for last
    late: dict[str, float] = field(default_factory=dict)  # how late robots are found to follow [s]
    stray: dict[str, float] = field(default_factory=dict)  # how far they are off their path, by their speed [s]

    def begin(
        self, motion: Motion, belief: Belief, margins: Margins, standing: Mapping[str, float]
    ) -> Pace | None:
        """The rate with which a motion begins, if it is another one than that of the motion before.

        Args:
            motion: it. belief: where all is before it. margins: of the plan.
            standing: how far robots are off now, at rest [m].
        """
        self.motion, self.planned, self.margins = motion, belief.state.robots, margins
        self.standing = standing
        self._fast: dict[str, tuple[Array, Array, Booleans]] | None = None
        self._before: RobotState | None = None
        return self.wanted(motion.begin)

    def learn(self, state: RobotState, off: Mapping[str, Off]) -> None:
        """Takes into account how far robots are off while they move."""
        before, self._before = self._before, state
        if before is None or state.time <= before.time:
            return
        seconds = state.time - before.time
        rate = (state.motion_time - before.motion_time) / seconds
        for name, own in off.items():
            known = self.stray if own.alone else self.late
            if own.late > 0.0 and rate > 0.0:
                self.late[name] = max(own.late / rate, self.late.get(name, 0.0))
            if own.off < NOTICED * own.permitted and name not in known:
                continue
            moved = self._speeds[name][0][
                self._cell(state.motion_time - RECENT) : self._cell(state.motion_time) + 1
            ]
            speed = float(moved.max(initial=0.0)) * rate
            if speed < MOVES:
                continue
            found = max(0.0, own.off - self.standing.get(name, 0.0)) / speed
            if (before_it := known.get(name, 0.0)) > found:
                found = before_it + (found - before_it) * min(1.0, seconds / FORGOTTEN)
            known[name] = found

    def wanted(self, time: float) -> Pace | None:
        """The rate from a time of the motion on, if it is worth a change."""
        least, reason = 1.0, "robots are near enough to their paths at full speed"
        for name in self.robots:
            late, stray = max(self.delay, self.late.get(name, 0.0)), self.stray.get(name, 0.0)
            if late > 0.0 or stray > 0.0:
                rate, text = self._rate_of(name, late, stray, time)
                least, reason = (rate, text) if rate < least else (least, reason)
        rate = 1.0 if least >= 1.0 else max(LEAST, STEP ** ceil(log(max(least, LEAST)) / log(STEP)))
        if SLOWER * self.rate < rate < FASTER * self.rate and not rate == 1.0 > self.rate:
            return None
        return Pace(round(rate, 3), reason)

    def _rate_of(self, name: str, late: float, stray: float, time: float) -> tuple[float, str]:
        speeds, permitted, others = self._speeds[name]
        ahead = slice(self._cell(time), self._cell(time + FORESEEN) + 1)
        lags = np.where(others[ahead], late, stray)
        off, room = lags * speeds[ahead], SHARE * permitted[ahead] - self.standing.get(name, 0.0)
        if not (off > room).any():
            return 1.0, ""
        rates = np.divide(np.maximum(room, 0.0), off, out=np.full(len(off), np.inf), where=off > 0.0)
        worst = int(np.argmin(rates))
        whole, proven = 1000.0 * (off[worst] + self.standing.get(name, 0.0)), 1000.0 * permitted[ahead][worst]
        text = f"{name} follows {1000 * lags[worst]:.0f} ms late: at full speed it would be {whole:.1f} mm off its path"
        return float(rates[worst]), f"{text}, and {proven:.1f} mm are proven to be free"

    def _cell(self, time: float) -> int:
        return max(0, int((time - self.motion.begin) / CELL))

    @property
    def _speeds(self) -> Mapping[str, tuple[Array, Array, Booleans]]:
        """By robot, for each cell of the motion's clock: its speed [m/s], what is proven [m], whether others move, too."""
        if self._fast is None:
            self._fast = {name: self._along(name) for name in self.robots}
        return self._fast

    def _along(self, name: str) -> tuple[Array, Array, Booleans]:
        motion, robot = self.motion, self.robots[name]
        count = max(1, int(np.ceil((motion.end - motion.begin) / CELL)))
        times = np.asarray(motion.begin + CELL * np.arange(count + 1), np.float64)
        rows, permitted = motion.rows(robot, self.planned[name], times), np.full(count, np.inf)
        others = np.zeros(count, bool)
        for each in motion.stretches:
            inside = (times[1:] >= each.begin) & (times[:-1] <= each.end)
            if each.robot == name:
                permitted[inside] = np.minimum(permitted[inside], self.margins.of_segment(each.node, each.segment))
            others |= inside & (each.robot != name)
        rows[:, robot.planned :] = rows[0, robot.planned :]  # hands are not judged
        steps = np.diff(LinkOrigins.of(robot).at(rows), axis=0)
        return np.linalg.norm(steps, axis=2).max(axis=1, initial=0.0) / CELL, permitted, others
