"""The path of a lid in pouring, in the plane perpendicular to the axis of tilting [T 3.9.2].

    x = x_s + (t^0.2 + (1 - t) t c) (x_p - x_s),   y = y_s + t^2 (y_p - y_s),   theta = theta_s + t (theta_p - theta_s)

The lid first moves over the cup, then tilts, and comes down last, when it is tilted. At t = 0.01 it has already covered
40 % of the way across; therefore poses are taken at equal steps of path length, not of t.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array

METRES_PER_RADIAN = 0.15  # weight of rotation, about the distance from the lid to the middle of a bottle
LENGTH_PIECES = 4096  # straight pieces over which the length is summed


@dataclass(frozen=True)
class PourPath:
    """The path from `start` to `pouring`, each (x, y, theta): sideways [m], upward [m], tilted sideways [rad]."""

    start: tuple[float, float, float]
    pouring: tuple[float, float, float]
    overshoot: float = 0.0  # the constant c

    def at(self, t: npt.ArrayLike) -> Array:
        """The poses (..., 3) at parameters t in [0, 1]."""
        share = np.asarray(t, float)
        across = share**0.2 + (1.0 - share) * share * self.overshoot
        start, way = np.array(self.start), np.array(self.pouring) - np.array(self.start)
        return np.asarray(start + way * np.stack([across, share**2, share], axis=-1))

    def by_length(self, step: float) -> Array:
        """Poses (m, 3) from start to end, at equal distances of `step` [m] or less along the path."""
        fine = self.at(np.linspace(0.0, 1.0, LENGTH_PIECES + 1) ** 5)  # t^0.2 is smooth in the fifth root of t
        pieces = np.linalg.norm(np.diff(fine, axis=0) * (1.0, 1.0, METRES_PER_RADIAN), axis=1)
        length = np.concatenate([[0.0], np.cumsum(pieces)])
        count = max(1, int(np.ceil(length[-1] / step)))
        at = np.linspace(0.0, length[-1], count + 1)
        found = np.stack([np.interp(at, length, fine[:, k]) for k in range(3)], axis=1)
        found[0], found[-1] = self.start, self.pouring
        return found
