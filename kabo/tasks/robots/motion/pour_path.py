"""The path of a lid that pours, in the plane across the axis about which it tilts [T 3.9.2].

    x = x_s + (t^0.2 + (1 - t) t c) (x_p - x_s),   y = y_s + t^2 (y_p - y_s),   theta = theta_s + t (theta_p - theta_s)

The lid first goes over the cup, then tilts, and comes down last, when it is tilted. At t = 0.01 already 40 % of the
way across is covered, so poses are taken at equal steps of length along the path, not of t.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array

LEVER = 0.15  # metres that a radian counts, about the way from the lid to the middle of a bottle
FINE = 4096  # pieces in which the length is summed up


@dataclass(frozen=True)
class PourPath:
    """From `start` to `pouring`, each (x, y, theta): to the side [m], up [m], tilted to the side [rad]."""

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
        """Poses (m, 3) from start to end, equally far apart along the path, by `step` [m] or less."""
        fine = self.at(np.linspace(0.0, 1.0, FINE + 1) ** 5)  # t^0.2 is smooth in the fifth root of t
        pieces = np.linalg.norm(np.diff(fine, axis=0) * (1.0, 1.0, LEVER), axis=1)
        length = np.concatenate([[0.0], np.cumsum(pieces)])
        count = max(1, int(np.ceil(length[-1] / step)))
        at = np.linspace(0.0, length[-1], count + 1)
        found = np.stack([np.interp(at, length, fine[:, k]) for k in range(3)], axis=1)
        found[0], found[-1] = self.start, self.pouring
        return found
