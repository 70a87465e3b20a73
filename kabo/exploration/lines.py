"""Straight reference lines fitted to contact points, and where to try next along them [T 4.3]."""

from dataclasses import dataclass
from functools import cached_property
from numbers import Integral

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.exploration.errors import ExplorationError
from kabo.exploration.limits import LARGEST_NUMBER
from kabo.exploration.values import A_NUMBER, A_SEED, finite, is_seed, shown
from kabo.streams import stream_key, uniforms

HYPOTHESES = 400  # lines through two random points; enough to draw two inliers if one point in five is an inlier
ROUNDS = 10  # of least squares over the inliers; they settle after two or three
PRIMES = (2, 3, 5, 7, 11, 13)


@dataclass(frozen=True)
class Line:
    """A line segment through points, with the frame that motion along it refers to [T e1, e2].

    Attributes:
        origin: (3,) the end on the right (−y) and below, as a robot sees it that looks along x with z up [m].
        direction: (3,) the unit vector from there to the other end.
        length: the distance of the outermost inliers along the line [m].
        inliers: (n,) which of the points the line was fitted to.
    """

    origin: Array
    direction: Array
    length: float
    inliers: npt.NDArray[np.bool_]

    @cached_property
    def frame(self) -> Array:
        """The pose (4, 4) at the origin: x along the line, z as far upward as that permits, y across it."""
        steep = np.hypot(self.direction[0], self.direction[1]) < 1e-6  # noqa: PLR2004 - nothing of z is left across it
        up = np.array([1.0, 0.0, 0.0] if steep else [0.0, 0.0, 1.0])
        across = np.cross(up, self.direction)
        across /= np.linalg.norm(across)
        pose = np.eye(4)
        pose[:3, 0], pose[:3, 1], pose[:3, 2] = self.direction, across, np.cross(self.direction, across)
        pose[:3, 3] = self.origin
        return pose

    def at(self, share: float) -> Array:
        """The point (3,) at a share of the length from the origin."""
        found: Array = self.origin + share * self.length * self.direction
        return found

    def distance(self, points: npt.ArrayLike) -> Array:
        """The distances of points (n, 3) from the line, which counts as infinite here, as (n,) [m]."""
        return _distances(np.asarray(points, float), self.origin, self.direction)


def fit_line(points: npt.ArrayLike, tolerance: float = 0.01, seed: int = 0) -> Line:
    """The line with the most points within the tolerance, by least squares over these points [T 4.3, RANSAC].

    Args:
        points: (n, 3), two at least [m].
        tolerance: the greatest distance of an inlier [m].
        seed: of the random pairs of points.

    Raises:
        ExplorationError: there are fewer than two different points, or numbers are not finite.
    """
    try:
        known = np.asarray(points, float)
    except (TypeError, ValueError, OverflowError):
        raise ExplorationError(f"a line is fitted to points (n, 3), this is {shown(points)}") from None
    if known.ndim != 2 or known.shape[1:] != (3,) or len(known) < 2:  # noqa: PLR2004
        raise ExplorationError(
            f"a line is fitted to two points or more, as an array (n, 3), this is {known.shape}"
        )
    if not (np.abs(known) <= LARGEST_NUMBER).all():
        raise ExplorationError(f"each coordinate of a line's points must be {A_NUMBER}")
    if not (finite(tolerance) or 0.0) > 0:
        raise ExplorationError(f"the tolerance of a line must be a positive number, this is {shown(tolerance)}")
    if not is_seed(seed):
        raise ExplorationError(f"the seed of a line must be {A_SEED}, this is {shown(seed)}")
    inliers = _best_inliers(known, tolerance, seed)
    if not inliers.any():
        raise ExplorationError("all points of the line are the same")
    for _ in range(ROUNDS):
        centre, direction = _least_squares(known[inliers])
        found = _distances(known, centre, direction) <= tolerance
        if np.array_equal(found, inliers) or np.count_nonzero(found) < 2:  # noqa: PLR2004
            break
        inliers = found
    centre, direction = _least_squares(known[inliers])
    direction = _leftward(direction)
    along = (known[inliers] - centre) @ direction
    return Line(centre + along.min() * direction, direction, float(np.ptp(along)), inliers)


def halton(index: int, dimensions: int = 1) -> Array:
    """Point `index` (0, 1 …) of Halton's sequence in the unit cube, as (dimensions,): evenly spread from the first on.

    Raises:
        ExplorationError: the index is negative, or there are more than six dimensions.
    """
    if not _is_whole(index, 0) or not _is_whole(dimensions, 1) or dimensions > len(PRIMES):
        raise ExplorationError(f"Halton's sequence has an index from 0 on and 1 to {len(PRIMES)} dimensions")
    return np.array([_radical_inverse(int(index) + 1, base) for base in PRIMES[:dimensions]])


def _is_whole(number: object, least: int) -> bool:
    return isinstance(number, Integral) and not isinstance(number, bool) and int(number) >= least


def _best_inliers(points: Array, tolerance: float, seed: int) -> npt.NDArray[np.bool_]:
    """The inliers (n,) of the best of many lines through two points: most inliers, then least sum of squares.

    There are two inliers at least, or none if all points are the same.
    """
    n = len(points)
    farthest = int(np.argmax(np.linalg.norm(points - points[0], axis=1)))  # the random pairs may all be duplicates
    pairs = (
        np.array([(i, j) for i in range(n) for j in range(i)])
        if n * (n - 1) // 2 <= HYPOTHESES
        else _pairs(n, seed)
    )
    best, found = (-1, 0.0), np.zeros(n, bool)
    for i, j in [(farthest, 0), *pairs]:
        apart = points[i] - points[j]
        length = float(np.linalg.norm(apart))
        if length == 0.0:
            continue
        distances = _distances(points, points[j], apart / length)
        near = distances <= tolerance
        near[[i, j]] = True  # but for rounding
        score = (int(near.sum()), -float((distances[near] ** 2).sum()))
        if score > best:
            best, found = score, near
    return found


def _pairs(n: int, seed: int) -> npt.NDArray[np.int64]:
    drawn = uniforms(stream_key(seed, "line", n), 0, HYPOTHESES, 2)
    first = (drawn[:, 0] * n).astype(np.int64)
    return np.stack([first, (first + 1 + (drawn[:, 1] * (n - 1)).astype(np.int64)) % n], axis=1)


def _least_squares(points: Array) -> tuple[Array, Array]:
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre)[2][0]


def _distances(points: Array, origin: Array, direction: Array) -> Array:
    apart = points - origin
    found: Array = np.linalg.norm(apart - np.outer(apart @ direction, direction), axis=1)
    return found


def _leftward(direction: Array) -> Array:
    """The direction or its opposite: the one that leads left and up or, where neither does clearly, forward."""
    side = direction[1] + direction[2]
    forward = side > 0 if abs(side) > 0.1 else direction[0] > 0
    return direction if forward else -direction


def _radical_inverse(number: int, base: int) -> float:
    """The radical inverse: the digits mirrored at the radix point, as 6 = 110 in base 2 gives 0.011 = 3/8."""
    value, digit = 0.0, 1.0 / base
    while number:
        number, rest = divmod(number, base)
        value, digit = value + rest * digit, digit / base
    return value
