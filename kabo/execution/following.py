"""Setpoints of a motion at the rate of a controller, on a clock that can be slowed down, also to a planned stop.

The clock of the motion runs at a rate s, one by default: values are q(t), velocities q'(t) s, and so on by the chain rule.
So what is sent is always on the proven path; a stop changes s alone, and only as fast as all limits permit. At a constant
rate of one or less all limits are kept, also of what is held, since gravity alone keeps them.
"""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.compilation import settled
from kabo.execution.clock import Change, Law, StopWhileChanging
from kabo.execution.clock_limits import keeps_limits
from kabo.execution.kernels.setpoints import setpoint
from kabo.execution.loads import STEP, LoadOnPath
from kabo.execution.motions import Motion, Stretch
from kabo.motion import Held, MotionLimits
from kabo.scene import Scene, motion_limits

STOP_TIMES = tuple(0.02 * 1.25**k for k in range(24))  # [s], tried in turn: 20 ms to 3.4 s
STOP_DELAYS = (0.0, 0.02, 0.05, 0.1, 0.2, 0.4)  # [s] before slowing down begins
CHANGE_TIMES = tuple(
    0.05 * 1.5**k for k in range(8)
)  # [s], within which the rate goes to another one: 50 ms to 0.85 s
CHECKED_RATE = 1000.0  # [Hz], at which a stop is checked against the limits
TOLERANCE = 1e-9
HASTY = np.linspace(0.05, 0.95, 19)  # shares of a stop at which it is seen at once that it exceeds limits
SURELY = 1.05  # share of a limit above which it surely does: values are those of a grid of 1 ms
_SETPOINT = settled(setpoint)  # it is called for each robot at each setpoint


class Setpoint(NamedTuple):
    """What is sent to one robot: names of joints, values, velocities, accelerations (n,)."""

    robot: str
    joints: tuple[str, ...]
    positions: Array
    velocities: Array
    accelerations: Array


class Follower:
    """The clock of a motion, and what is sent at each of its times."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.motion: Motion | None = None
        self.time = 0.0  # of the motion's clock [s]
        self.loads: dict[str, list[Held]] = {}  # what hands of robots hold
        self._limits: dict[tuple[str, tuple[str, ...]], MotionLimits] = {}
        # The kernel is loaded now: that may take longer than a robot server may be silent.
        _SETPOINT(np.zeros((1, 6)), 0.0, 1.0, 0.0)
        self._rate = 1.0  # of the clock, when its law has ended
        self._law: Law | None = None
        self._since = self._asked_at = 0.0  # [s] since the law began, and on the clock of the motion when it did
        self.stopping = False  # whether a stop was asked for

    @property
    def moving(self) -> bool:
        """Whether something is still to be sent."""
        if self.motion is None or (self.stopping and self._law is None):
            return False
        return self.time < self.motion.end - TOLERANCE

    def follow(self, motion: Motion) -> None:
        """Begins a motion, at its beginning."""
        self.motion, self.time = motion, motion.begin
        self._spans = [(s.begin, s.end, (s.robot, s.trajectory.joints), s) for s in motion.stretches]
        if isinstance(self._law, Change) and not self.stopping:
            self._rate = self._law.last
        self._law, self.stopping = None, False

    def stop(self) -> None:
        """Slows down as fast as all limits permit; where they do not, the motion goes on to its end, which is a rest."""
        if not self.stopping and self.motion is not None and self.moving:
            self._law = self._fastest_stop(self.motion)
            self.stopping = True
            self._asked_at, self._since = self.time, 0.0

    def pace(self, rate: float) -> bool:
        """Goes to another rate of the clock, as soon as all limits permit; a motion that begins has it at once.

        Args:
            rate: above 0 and at most 1.

        Returns:
            Whether it does; not while the rate is being changed, or is by a stop, or where limits permit no change.
        """
        if not 0.0 < rate <= 1.0:
            raise ValueError(f"the rate of a clock is above 0 and at most 1, not {rate}")
        if self._law is not None or self.stopping:
            return False
        if self.motion is None or not self.moving or self.time == self.motion.begin:
            self._rate = rate
            return True
        change = self._soonest_change(self.motion, rate)
        if change is not None:
            self._law, self._asked_at, self._since = change, self.time, 0.0
        return change is not None

    def advance(self, seconds: float) -> Iterator[Setpoint]:
        """What is to be sent `seconds` later; at the end of the motion its end, at rest."""
        if self.motion is None:
            return
        before = self.time
        rate = change = 0.0
        if self._law is not None:
            rate, change = self._advance_by(self._law, self.motion, seconds)
        elif not self.stopping:
            self.time, rate = min(self.motion.end, self.time + self._rate * seconds), self._rate
        running = {
            key: stretch for begin, end, key, stretch in self._spans if begin <= self.time and end >= before
        }
        for stretch in running.values():
            yield _sent(stretch, min(self.time, stretch.end), rate, change)

    def _advance_by(self, law: Law, motion: Motion, seconds: float) -> tuple[float, float]:
        """Goes on by a law; the rate then, and its derivative."""
        self._since += seconds
        since = np.array([self._since])
        self.time = min(motion.end, self._asked_at + float(law.passed(since)[0]))
        rates = law.rate(since)
        if self._since >= law.ends:
            self._law = None
            self._rate = law.last if isinstance(law, Change) and not self.stopping else self._rate
        return float(rates[0][0]), float(rates[1][0])

    # ---------------------------------------------------------------------------------------------- laws of the clock
    def _soonest_change(self, motion: Motion, rate: float) -> Change | None:
        """The change to a rate that ends first of those within all limits and before the end of the motion."""
        left, loads = motion.end - self.time, self._loads_on_path(motion)
        tried = sorted((delay + lasts, delay, lasts) for delay in STOP_DELAYS for lasts in CHANGE_TIMES)
        for ends, delay, lasts in tried:
            change = Change(delay, lasts, self._rate, rate)
            if float(change.passed(np.array(ends))) >= left or not self._within_limits(motion, change, loads):
                continue
            met = (each for each in motion.stretches if each.end > self.time)
            if all(keeps_limits(each.trajectory, self._limits_of(each), change, self.time) for each in met):
                return change
        return None

    def _stop_law(self, delay: Any, lasts: Any) -> Law:
        """The law by which the clock stands after `delay` and `lasts` seconds, or several at once."""
        if isinstance(self._law, Change):
            begun = replace(self._law, delay=self._law.delay - self._since)
            return StopWhileChanging(begun, Change(delay, lasts))
        return Change(delay, lasts, self._rate)

    def _fastest_stop(self, motion: Motion) -> Law:
        """The stop that ends first of those within all limits; else none before the end of the motion."""
        left = motion.end - self.time
        slowest = min(self._rate, self._law.last) if isinstance(self._law, Change) else self._rate
        loads = self._loads_on_path(motion)
        tried = [
            (delay + lasts, delay, lasts)
            for delay in STOP_DELAYS
            for lasts in STOP_TIMES
            if slowest * (delay + 0.5 * lasts) < left
        ]
        for _, delay, lasts in sorted(self._not_hasty(motion, tried)):
            law = self._stop_law(delay, lasts)
            if self._within_limits(motion, law, loads):
                return law
        return self._stop_law(left / slowest + 1.0, 1.0)

    def _not_hasty(
        self, motion: Motion, tried: list[tuple[float, float, float]]
    ) -> list[tuple[float, float, float]]:
        """Those stops that do not exceed limits at a few of their times, seen for all at once: most do."""
        if not tried:
            return []
        delays, lasts = np.array([each[1:] for each in tried]).T[:, :, None]
        stops, seconds = self._stop_law(delays, lasts), delays + HASTY * lasts
        rate, first, second = stops.rate(seconds)
        times = self.time + stops.passed(seconds)
        fine = np.ones(len(tried), bool)
        for stretch in motion.stretches:
            inside = (times >= stretch.begin) & (times <= stretch.end)
            if not inside.any():
                continue
            limits, begin = self._limits_of(stretch), max(self.time, stretch.begin)
            grid = np.arange(begin, min(stretch.end, float(times.max())) + 1.0 / CHECKED_RATE, 1.0 / CHECKED_RATE)
            index = np.clip(np.rint((times - begin) * CHECKED_RATE), 0, len(grid) - 1).astype(int)
            q1, q2, q3 = (stretch.trajectory.at(grid, order)[index] for order in (1, 2, 3))
            s, ds, dds = rate[..., None], first[..., None], second[..., None]
            acceleration = np.abs(q2 * s * s + q1 * ds) > SURELY * limits.acceleration
            jerk = np.abs(q3 * s**3 + 3.0 * q2 * s * ds + q1 * dds) > SURELY * limits.jerk
            fine &= ~((acceleration | jerk).any(axis=-1) & inside).any(axis=1)
        return [each for each, keep in zip(tried, fine, strict=True) if keep]

    def _loads_on_path(self, motion: Motion) -> list[LoadOnPath]:
        """What moving arms hold, along the rest of the stretches that they are in."""
        found = []
        for stretch in motion.stretches:
            arm = self.scene.robots[stretch.robot].planned_joints
            begin = max(self.time, stretch.begin)
            if stretch.trajectory.joints != arm or stretch.end - begin < 3.0 * STEP:
                continue
            times = np.linspace(begin, stretch.end, round((stretch.end - begin) / STEP) + 1)
            for held in self.loads.get(stretch.robot, ()):
                found.append(LoadOnPath.along(held, times, stretch.trajectory.at(times)))
        return found

    def _within_limits(self, motion: Motion, law: Law, loads: list[LoadOnPath]) -> bool:
        """Whether joints and what is held keep their limits, seen each millisecond until the law has ended."""
        seconds = np.arange(0.0, law.ends + 1.0 / CHECKED_RATE, 1.0 / CHECKED_RATE)
        times = self.time + law.passed(seconds)
        rate, first, second = law.rate(seconds)
        for load in loads:
            inside = (times >= load.times[0]) & (times <= load.times[-1])
            if not load.held_under(times[inside], rate[inside], first[inside]):
                return False
        for stretch in motion.stretches:
            inside = (times >= stretch.begin) & (times <= stretch.end)
            if not inside.any():
                continue
            limits = self._limits_of(stretch)
            q1, q2, q3 = (stretch.trajectory.at(times[inside], order) for order in (1, 2, 3))
            s, ds, dds = rate[inside, None], first[inside, None], second[inside, None]
            acceleration = q2 * s * s + q1 * ds
            jerk = q3 * s**3 + 3.0 * q2 * s * ds + q1 * dds
            room = 1.0 + TOLERANCE
            if (np.abs(acceleration) > room * limits.acceleration).any() or (
                np.abs(jerk) > room * limits.jerk
            ).any():
                return False
        return True

    def _limits_of(self, stretch: Stretch) -> MotionLimits:
        key = stretch.robot, stretch.trajectory.joints
        if key not in self._limits:
            self._limits[key] = motion_limits(self.scene.robots[stretch.robot], stretch.trajectory.joints)
        return self._limits[key]


def _sent(stretch: Stretch, time: float, rate: float, change: float) -> Setpoint:
    trajectory = stretch.trajectory
    k = min(max(bisect_right(trajectory.times, time) - 1, 0), len(trajectory.coefficients) - 1)
    values = _SETPOINT(trajectory.padded[k], time - trajectory.times[k], rate, change)
    return Setpoint(stretch.robot, trajectory.joints, *values)
