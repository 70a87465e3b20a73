"""Limits of a motion: how fast each joint may move, speed up, and change its acceleration."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array

NAMES = ("velocity", "acceleration", "jerk")


@dataclass(frozen=True)
class MotionLimits:
    """Limits of absolute values, arrays (n,) for n joints, as [rad/s, rad/s², rad/s³] or [m/s, m/s², m/s³]."""

    velocity: Array
    acceleration: Array
    jerk: Array

    @classmethod
    def of(cls, velocity: ArrayLike, acceleration: ArrayLike, jerk: ArrayLike) -> "MotionLimits":
        """The limits as arrays of numbers.

        Raises:
            ValueError: shapes differ, or a limit is negative or not a number.
        """
        rows = [np.array(one, np.float64) for one in (velocity, acceleration, jerk)]
        for name, row in zip(NAMES, rows, strict=True):
            if row.shape != rows[0].shape or row.ndim != 1:
                raise ValueError(
                    f"limits of {name} need the shape of the velocities, {rows[0].shape}: {row.shape}"
                )
            if not np.all(row >= 0.0):
                raise ValueError(f"limits of {name} must not be negative: {row}")
        return cls(*rows)

    @property
    def rows(self) -> tuple[Array, Array, Array]:
        """The limits of the derivatives of order 1, 2 and 3."""
        return self.velocity, self.acceleration, self.jerk

    def __add__(self, other: "MotionLimits") -> "MotionLimits":
        """The limits of these joints followed by those of others."""
        return MotionLimits(*(np.concatenate(pair) for pair in zip(self.rows, other.rows, strict=True)))

    def chosen(self, joints: ArrayLike) -> "MotionLimits":
        """The limits of some joints, by their indices or by a mask."""
        which = np.asarray(joints)
        return MotionLimits(*(row[which] for row in self.rows))

    def scaled(self, share: float) -> "MotionLimits":
        """The limits under which every motion takes 1 / `share` of its time."""
        return MotionLimits(self.velocity * share, self.acceleration * share**2, self.jerk * share**3)


@dataclass(frozen=True)
class Held:
    """What a robot holds: its acceleration minus gravity must not exceed a bound, or it slips.

    Attributes:
        places: from configurations (k, n), the positions (k, 3) of its origin in the world [m].
        acceleration: the greatest norm of its acceleration minus gravity [m/s²]: friction · force / mass.
        gravity: in the world [m/s²].
        others: what the robot holds besides, with bounds that are no lower.
    """

    places: Callable[[Array], Array]
    acceleration: float
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    others: "tuple[Held, ...]" = ()

    @property
    def spare(self) -> float:
        """What the bound leaves beside gravity [m/s²]: a body can be moved if it is positive."""
        return self.acceleration - float(np.linalg.norm(self.gravity))
