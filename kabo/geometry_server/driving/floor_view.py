"""Collision checks of a robot that drives: a base that reaches out of its floor counts as one more pair that collides."""

from dataclasses import dataclass, replace

import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.geometry import CollisionChecker, Counters, KernelChecks
from kabo.scene import BASE_VALUES, Drive


@dataclass(frozen=True)
class FloorView:
    """The checks of a view, and of the footprint on its floor; `number` is the index of the pair of base and floor.

    One-sided as all checks are: what is free is proven inside, and what is inside by epsilon / 20 is free.
    """

    view: CollisionChecker
    drive: Drive
    number: int
    epsilon: float

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are free at configuration q (n,) and the base is on its floor, else the index of a pair."""
        found = self.view.configuration_hit(q)
        if found >= 0:
            return found
        out = self.drive.outside(np.asarray(q, np.float64)[None, :BASE_VALUES])[0]
        return self.number if out > 0.0 else found

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n)."""
        found = self.view.configurations_hit(configurations)
        if not len(found):
            return found
        out = self.drive.outside(np.asarray(configurations, np.float64)[:, :BASE_VALUES]) > 0.0
        return np.where((found < 0) & out, self.number, found)

    def segment_hit(self, start: Array, end: Array, deviation: Array | None = None) -> int:
        """-1 if the straight segment is proven free and the base proven to stay on its floor, else the index of a pair.

        `deviation` (n,): how far each value may be from the segment [rad or m]; None for zeros.
        """
        ends = np.asarray(start, np.float64)[:BASE_VALUES], np.asarray(end, np.float64)[:BASE_VALUES]
        stray = 0.0 if deviation is None else self._stray(deviation)
        if self.drive.outside_along(*ends, self.epsilon) + stray > 0.0:
            return self.number
        return self.view.segment_hit(start, end, deviation)

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n)."""
        return np.array([self.segment_hit(*row) for row in zip(starts, ends, deviations, strict=True)], np.int64)

    def segments_free_early(self, starts: Array, ends: Array, deviations: Array) -> Booleans:
        """Which rows (N,) are proven free without dividing any part, with the base on its floor."""
        free = np.asarray(self.view.segments_free_early(starts, ends, deviations))
        for i in np.flatnonzero(free).tolist():
            bases = starts[i, :BASE_VALUES], ends[i, :BASE_VALUES]
            free[i] = self.drive.outside_along(*bases, self.epsilon) + self._stray(deviations[i]) <= 0.0
        return free

    def _stray(self, deviation: Array) -> float:
        """How far a corner of the footprint can be from where it is, if values are off by at most `deviation` [m]."""
        return float(np.hypot(deviation[0], deviation[1]) + self.drive.radius * deviation[2])

    @property
    def kernel_checks(self) -> KernelChecks | None:
        """What other kernels need; what they find free remains to be compared with the floor."""
        checks = self.view.kernel_checks
        if checks is None or not checks.hit_counts:
            return None
        return replace(
            checks, free_counts=False, configurations_hit=self._outside, segment_hit=self._outside_along
        )

    def _outside(self, configurations: Array) -> Integers:
        out = self.drive.outside(np.asarray(configurations, np.float64)[:, :BASE_VALUES]) > 0.0
        return np.where(out, self.number, -1)

    def _outside_along(self, start: Array, end: Array) -> int:
        ends = start[:BASE_VALUES], end[:BASE_VALUES]
        return self.number if self.drive.outside_along(*ends, self.epsilon) > 0.0 else -1

    @property
    def counters(self) -> Counters:
        """The numbers of checks that were made so far, without those of the floor."""
        return self.view.counters
