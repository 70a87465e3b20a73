"""The trajectory as data: polynomial pieces in time for each joint, beside the path that they follow."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array

MAX_DEGREE = 5  # of a piece: position, velocity and acceleration at both of its ends determine it

Coefficients = tuple[tuple[tuple[float, ...], ...], ...]


@dataclass(frozen=True)
class Trajectory:
    """The motion of some joints: piece k is a polynomial in the time since `times[k]`, for each joint.

    Attributes:
        joints: the names of the n joints, in the order of the way points.
        waypoints: the path that is followed, m configurations of n values, straight in joint space between them.
        times: the k + 1 ends of the k pieces [s], strictly increasing, counted as in the node's motion.
        coefficients: for each piece and each joint at most six numbers, in increasing powers of the time since the
            beginning of the piece [rad or m, and s].
        deviation: no joint is ever farther than this from the path [rad or m]; 0 if it is followed exactly.
    """

    joints: tuple[str, ...]
    waypoints: tuple[tuple[float, ...], ...]
    times: tuple[float, ...]
    coefficients: Coefficients
    deviation: float = 0.0

    @classmethod
    def linear(
        cls, joints: Sequence[str], waypoints: Sequence[Sequence[float]], times: Sequence[float]
    ) -> "Trajectory":
        """The motion at constant velocity between way points (m, n), which are reached at m `times` [s].

        Velocities jump at way points: it is what plans of the format `kabo-plan/1` say, and no controller follows it.
        """
        rows = tuple(tuple(map(float, row)) for row in waypoints)
        steps = list(zip(rows, rows[1:], times, times[1:], strict=False))
        pieces = tuple(
            tuple((a, (b - a) / (t1 - t0)) for a, b in zip(row, after, strict=True))
            for row, after, t0, t1 in steps
        )
        return cls(tuple(joints), rows, tuple(map(float, times)), pieces)

    @property
    def duration(self) -> float:
        """The time from the beginning to the end [s]."""
        return self.times[-1] - self.times[0]

    @cached_property
    def padded(self) -> Array:
        """The coefficients as an array (pieces, joints, 6), with zeros for powers that a piece does not have."""
        found = np.zeros((len(self.coefficients), len(self.joints), MAX_DEGREE + 1))
        for k, piece in enumerate(self.coefficients):
            for j, own in enumerate(piece):
                found[k, j, : len(own)] = own
        return found

    def at(self, times: ArrayLike, order: int = 0) -> Array:
        """The values (…, n) of the joints at `times` [s], or their derivatives of the given order.

        Before the beginning and after the end the motion stands still. At a border of pieces the later piece counts.
        """
        wanted = np.asarray(times, np.float64)
        clipped = np.clip(wanted, self.times[0], self.times[-1])
        knots = np.asarray(self.times)
        k = np.clip(np.searchsorted(knots, clipped, side="right") - 1, 0, len(self.coefficients) - 1)
        c = self.padded[k]
        for _ in range(order):
            c = c[..., 1:] * np.arange(1, c.shape[-1])
        local = (clipped - knots[k])[..., None]
        value = np.zeros(c.shape[:-1])
        for power in range(c.shape[-1] - 1, -1, -1):
            value = value * local + c[..., power]
        outside = (wanted < self.times[0]) | (wanted > self.times[-1])
        return np.where(outside[..., None] & (order > 0), 0.0, value)
