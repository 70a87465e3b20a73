"""The clock of a motion: it runs at a rate of one, is slowed down and sped up again, and comes to a stop.

A rate goes from one value to another by the quintic law with two vanishing derivatives at both ends [K 6.1.3]. A stop may
be asked for while the rate is being changed: then the rate is the product of both laws.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from kabo.arrays import Array

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)  # exact for the product of two laws, of degree 10


@dataclass(frozen=True)
class Change:
    """After `delay` seconds the rate goes from `first` to `last`, within `lasts` seconds; by default it is a stop.

    Several changes at once are arrays (n, 1), of which `seconds` are (n, k).
    """

    delay: Any
    lasts: Any
    first: float = 1.0
    last: float = 0.0

    @property
    def ends(self) -> float:
        """When it is done, after it was asked for [s]."""
        return float(self.delay + self.lasts)

    def rate(self, seconds: Array) -> tuple[Array, Array, Array]:
        """The rate of the clock `seconds` (k,) after it was asked for, its first and its second derivative."""
        u, step = np.clip((seconds - self.delay) / self.lasts, 0.0, 1.0), self.last - self.first
        value = self.first + step * u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
        first = step * 30.0 * u * u * (1.0 - u) ** 2 / self.lasts
        second = step * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / self.lasts**2
        return value, first, second

    def passed(self, seconds: Array) -> Array:
        """How far the clock has come by then (k,) [s], the rate being `last` afterwards."""
        u = np.clip((seconds - self.delay) / self.lasts, 0.0, 1.0)
        changed = self.lasts * u**4 * (2.5 - 3.0 * u + u * u)
        after = np.maximum(seconds - self.delay - self.lasts, 0.0)
        passed: Array = self.first * seconds + (self.last - self.first) * (changed + after)
        return passed


@dataclass(frozen=True)
class StopWhileChanging:
    """A stop that is asked for while the rate is being changed: the product of both rates.

    `change` counts from when the stop was asked for, so that its delay is negative if it has begun.
    """

    change: Change
    stop: Change

    @property
    def ends(self) -> float:
        """When the clock stands, after the stop was asked for [s]."""
        return self.stop.ends

    def rate(self, seconds: Array) -> tuple[Array, Array, Array]:
        """The rate of the clock by then (k,), its first and its second derivative."""
        f, df, ddf = self.change.rate(seconds)
        g, dg, ddg = self.stop.rate(seconds)
        return f * g, df * g + f * dg, ddf * g + 2.0 * df * dg + f * ddg

    def passed(self, seconds: Array) -> Array:
        """How far the clock has come by then (k,) [s]: integrated between the ends of both laws, exactly."""
        both = (self.change, self.stop)
        borders = np.broadcast_arrays(*(each.delay for each in both), *(each.delay + each.lasts for each in both))
        ends = np.sort(np.stack([np.zeros_like(borders[0], np.float64), *borders]), axis=0)
        total: Array = np.zeros(np.broadcast_shapes(np.shape(seconds), ends[0].shape))
        for low, high in zip(ends, [*ends[1:], np.inf], strict=True):
            begin, end = np.minimum(seconds, np.maximum(low, 0.0)), np.minimum(seconds, np.maximum(high, 0.0))
            for node, weight in zip(NODES, WEIGHTS, strict=True):
                inside = begin + 0.5 * (1.0 + node) * (end - begin)
                total = total + 0.5 * weight * (end - begin) * self.rate(inside)[0]
        return total


Law = Change | StopWhileChanging
