"""Paths with rounded corners: straight pieces joined by parabolas that leave the corners by a bounded distance.

Such a path can be followed without stopping [Kunz, Stilman 2012]. Way points that lie on a line within a small
tolerance are dropped first: blends between near way points would be short, and short blends are slow.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
NOTHING = 1e-9  # rad: shorter pieces are none


@dataclass(frozen=True)
class Blended:
    """A path by length: `corners` (m, n), and how far before and after each the path leaves the straight pieces.

    `trims` (m,) are 0 at both ends and where the path stops at the corner.
    """

    corners: Floats
    trims: Floats

    @cached_property
    def _pieces(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Where pieces begin (k + 1,), and q0, q', q'' (k, n) there; straight ones and blends take turns."""
        units, lengths = self.directions
        begins, q0, q1, q2 = [0.0], [], [], []
        for i, (unit, length) in enumerate(zip(units, lengths, strict=True)):
            straight = length - self.trims[i] - self.trims[i + 1]
            q0.append(self.corners[i] + self.trims[i] * unit)
            q1.append(unit)
            q2.append(np.zeros_like(unit))
            begins.append(begins[-1] + straight)
            if self.trims[i + 1] > 0.0:
                q0.append(self.corners[i + 1] - self.trims[i + 1] * unit)
                q1.append(unit)
                q2.append((units[i + 1] - unit) / (2.0 * self.trims[i + 1]))
                begins.append(begins[-1] + 2.0 * self.trims[i + 1])
        return np.array(begins), np.array(q0), np.array(q1), np.array(q2)

    @cached_property
    def directions(self) -> tuple[Floats, Floats]:
        """Unit vectors (m - 1, n) along the straight pieces between corners, and their lengths (m - 1,)."""
        ways = np.diff(self.corners, axis=0)
        lengths = np.linalg.norm(ways, axis=1)
        return ways / lengths[:, None], lengths

    @property
    def length(self) -> float:
        """The length of the parameter; a blend counts as its two trims."""
        return float(self._pieces[0][-1])

    @property
    def borders(self) -> Floats:
        """Where straight pieces and blends begin and end."""
        return self._pieces[0]

    def corner(self, number: int) -> float:
        """The place on the path that is nearest to a corner: the middle of its blend."""
        _, lengths = self.directions
        return float(lengths[:number].sum())

    def at(self, places: ArrayLike, order: int = 0) -> Floats:
        """The path (…, n) at places along it, or its first or second derivative."""
        begins, q0, q1, q2 = self._pieces
        s = np.asarray(places, np.float64)
        k = np.clip(np.searchsorted(begins, s, side="right") - 1, 0, len(q0) - 1)
        ds = (s - begins[k])[..., None]
        if order == 0:
            return np.asarray(q0[k] + ds * q1[k] + 0.5 * ds**2 * q2[k])
        return np.asarray(q1[k] + ds * q2[k] if order == 1 else q2[k])


def blended(corners: ArrayLike, deviation: float, shares: Sequence[float] | None = None) -> Blended:
    """The path along corners (m, n) that leaves each inner one by no more than `deviation` [rad, L2].

    Args:
        corners: at least two, neighbours apart.
        deviation: how far the path may pass by a corner.
        shares: (m,) of the deviation for each corner; 0: the path goes through it, and stops there.
    """
    points = np.array(corners, np.float64)
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    if len(points) < 2 or lengths.min() <= NOTHING:
        raise ValueError("a path needs two corners, and neighbours that differ")
    units = ways / lengths[:, None]
    bend = np.linalg.norm(np.diff(units, axis=0), axis=1)  # a parabola passes by its corner at trim * bend / 4
    wanted = deviation * np.asarray([1.0] * len(points) if shares is None else shares, np.float64)[1:-1]
    room = 0.5 * np.minimum(lengths[:-1], lengths[1:])
    trims = np.minimum(room, 4.0 * wanted / np.maximum(bend, NOTHING)) * (wanted > 0.0)
    return Blended(points, np.concatenate([[0.0], trims, [0.0]]))


def thinned(waypoints: ArrayLike, tolerance: float) -> list[int]:
    """The numbers of the way points (m, n) that are needed: the path along them is `tolerance` [L2] from each other.

    [Douglas, Peucker 1973]; the first and the last are kept.
    """
    path = np.array(waypoints, np.float64)
    kept, waiting = {0, len(path) - 1}, [(0, len(path) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        away = _distances(path[first + 1 : last], path[first], path[last])
        worst = int(np.argmax(away))
        if away[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            waiting += [(first, middle), (middle, last)]
    return sorted(kept)


def _distances(points: Floats, start: Floats, end: Floats) -> Floats:
    """The distances (k,) of points (k, n) from a straight piece."""
    way = end - start
    square = float(way @ way)
    shares = np.zeros(len(points)) if square == 0.0 else np.clip((points - start) @ way / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - shares[:, None] * way, axis=1))
