"""Trapezoidal velocity profiles from rest to rest along a straight segment of joint space.

Plans keep times of way points only, and between them a robot moves at constant speed [docs/reference/plans.md]; so each
ramp has additional way points at equal time steps. The mean speed between two of them is never above the
speed in the profile.
"""

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.motion.timing import TIME_STEP

RAMP_WAYPOINTS = 4  # in the acceleration, and in the deceleration
MIN_CHANGE = 1e-10  # [rad or m]: plans keep nine decimals


def trapezoid(
    start: ArrayLike, end: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, *, steps: int = RAMP_WAYPOINTS
) -> tuple[Array, Array]:
    """Fractions (m,) of a segment from 0 to 1, and their times (m,) [s], for the fastest motion within the limits.

    Args:
        start, end: two different configurations (n,) [rad or m].
        velocity, acceleration: (n,) limits of the absolute values, positive for joints that move.
        steps: the number of way points of each ramp.

    Raises:
        ValueError: nothing moves, or a joint that moves has no positive limit.
    """
    way = np.abs(np.asarray(end, float) - np.asarray(start, float))
    moved = way > MIN_CHANGE
    fastest, hardest = np.asarray(velocity, float)[moved], np.asarray(acceleration, float)[moved]
    if not moved.any() or not (np.all(fastest > 0.0) and np.all(hardest > 0.0)):
        raise ValueError("a piece of motion needs a length, and limits above 0 for the joints that move")
    speed = float((fastest / way[moved]).min())  # in shares of the way [1/s]
    rate = float((hardest / way[moved]).min())  # [1/s2]
    speed = min(speed, float(np.sqrt(rate)))  # a short way never reaches the greatest speed
    ramp, flat = speed / rate, max(0.0, 1.0 / speed - speed / rate)
    up = np.linspace(0.0, ramp, steps + 1)
    shares = np.concatenate([0.5 * rate * up**2, 1.0 - 0.5 * rate * up[::-1] ** 2])
    times = np.concatenate([up, ramp + flat + up])
    if flat * speed < 1e-9:
        shares, times = np.delete(shares, steps), np.delete(times, steps)
    shares[0], shares[-1] = 0.0, 1.0
    return shares, times


def from_rest_to_rest(waypoints: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike) -> tuple[Array, Array]:
    """Denser way points (k, n) of a path that rests at every corner, and their times (k,) [s] in whole microseconds.

    Args:
        waypoints: the path (m, n), in which adjacent way points differ.
        velocity, acceleration: (n,) limits of the absolute values, positive for joints that move.

    Raises:
        ValueError: nothing moves, or a joint that moves has no positive limit.
    """
    path = np.asarray(waypoints, float)
    rows, times = [path[:1]], [np.zeros(1)]
    for a, b in zip(path, path[1:], strict=False):
        shares, own = trapezoid(a, b, velocity, acceleration)
        rows.append(a + shares[1:, None] * (b - a))
        rows[-1][-1] = b
        steps = np.maximum(1, np.ceil(np.diff(own) / TIME_STEP + 1e-3)).astype(np.int64)
        times.append(times[-1][-1] + np.cumsum(steps) * TIME_STEP)
    return np.vstack(rows), np.asarray(np.round(np.concatenate(times), 6), np.float64)
