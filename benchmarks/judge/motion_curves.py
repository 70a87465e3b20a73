"""Segments of a plan as polynomials in time, evaluated by numpy alone; and how far they are from their paths."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from motion_scene import Array

DEGREE = 5
POWERS = np.arange(DEGREE + 1)


@dataclass
class Curve:
    """Segment `number` of a node: piece k is a polynomial in the time since `times[k]`."""

    number: int
    robot: str
    joints: list[str]
    waypoints: Array  # (m, n): the path
    times: Array  # (k + 1,)
    coefficients: Array  # (k, n, 6)
    deviation: float
    said: dict[str, Any]
    polynomial: bool

    @property
    def ends(self) -> tuple[float, float]:
        """When it begins and ends, in the time of its node [s]."""
        return float(self.times[0]), float(self.times[-1])

    def at(self, times: Array, order: int = 0, *, left: bool = False) -> Array:
        """The values (T, n), or their derivatives; at a border those of the later piece, or of the earlier one."""
        side = "left" if left else "right"
        k = np.clip(np.searchsorted(self.times, times, side=side) - 1, 0, len(self.coefficients) - 1)
        c = self.coefficients[k]
        for _ in range(order):
            c = c[..., 1:] * POWERS[1 : c.shape[-1]]
        local = np.asarray(times) - self.times[k]
        return np.einsum("tnp,tp->tn", c, local[:, None] ** np.arange(c.shape[-1]))

    def greatest(self, order: int) -> Array:
        """The greatest absolute value (n,) of a derivative over all time, at roots of the next one: no samples."""
        found = np.zeros(len(self.joints))
        for piece, length in zip(self.coefficients, np.diff(self.times), strict=True):
            for j, row in enumerate(piece):
                derivative = np.polynomial.Polynomial(np.trim_zeros(row, "b") if row.any() else [0.0]).deriv(order)
                roots = derivative.deriv().roots() if derivative.degree() > 1 else np.zeros(0)
                if derivative.degree() == 1:
                    roots = np.zeros(0)
                inner = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real < length)]
                at = np.concatenate([[0.0, length], inner])
                found[j] = max(found[j], float(np.abs(derivative(at)).max()))
        return found


def curve(number: int, segment: dict[str, Any]) -> Curve:
    """A segment of a plan file; straight and proportional to time where it has no trajectory."""
    path, stated = np.array(segment["waypoints"], float), segment.get("trajectory")
    if stated is None:
        times = np.array(segment["times"], float)
        coefficients = np.zeros((len(path) - 1, path.shape[1], DEGREE + 1))
        coefficients[..., 0] = path[:-1]
        coefficients[..., 1] = np.diff(path, axis=0) / np.diff(times)[:, None]
        deviation = 0.0
    else:
        times, deviation = np.array(stated["times"], float), float(stated.get("deviation", 0.0))
        coefficients = np.zeros((len(stated["coefficients"]), path.shape[1], DEGREE + 1))
        for k, piece in enumerate(stated["coefficients"]):
            for j, row in enumerate(piece):
                coefficients[k, j, : len(row)] = row
    return Curve(
        number,
        segment["robot"],
        list(segment["joints"]),
        path,
        times,
        coefficients,
        deviation,
        segment,
        stated is not None,
    )


def distances(points: Array, path: Array) -> Array:
    """How far points (T, n) are from a path (m, n): the greatest difference of a joint, at the best point of it.

    First by the nearest point of each piece in the Euclidean sense, which is never too small a distance; then the
    greatest difference, which is convex along a piece, is made least by a ternary search on the best pieces.
    """
    if len(path) == 1:
        return np.abs(points - path[0]).max(axis=1)
    start, step = path[:-1], np.diff(path, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-300)
    found = np.full(len(points), np.inf)
    for begin in range(0, len(points), 512):
        rest = points[begin : begin + 512, None] - start
        share = np.clip((rest * step).sum(axis=2) / square, 0.0, 1.0)
        by_piece = np.abs(rest - share[..., None] * step).max(axis=2)
        near = np.argsort(by_piece, axis=1)[:, :3]
        rows = np.arange(len(rest))[:, None]
        found[begin : begin + 512] = _least(rest[rows, near], step[near]).min(axis=1)
    return found


def _least(rest: Array, step: Array) -> Array:
    low, high = np.zeros(rest.shape[:-1]), np.ones(rest.shape[:-1])
    for _ in range(60):
        first, second = low + (high - low) / 3, high - (high - low) / 3
        better = np.abs(rest - first[..., None] * step).max(-1) <= np.abs(rest - second[..., None] * step).max(-1)
        low, high = np.where(better, low, first), np.where(better, second, high)
    ends = [
        np.abs(rest - share[..., None] * step).max(-1)
        for share in (low, high, np.zeros_like(low), np.ones_like(low))
    ]
    return np.min(ends, axis=0)
