"""Bounds of what a joint does while the rate of the clock changes: at all times, not only at those that are looked at.

With q of the trajectory and s the rate of its clock, the acceleration is a = q'' s² + q' s' and the jerk is
j = q''' s³ + 3 q'' s s' + q' s''. Between two times that are h apart, a is at most h/2 of the greatest jerk above its
values there, and j, inside a piece of the trajectory, h/2 of the greatest derivative of j.
"""

import numpy as np

from kabo.arrays import Array
from kabo.execution.clock import Change
from kabo.motion import MotionLimits, Trajectory

STEP = 2.5e-4  # [s] between times that are looked at
SIDE = 1e-9  # [s] before a border of pieces: the piece before counts
SLOPES = (
    15.0 / 8.0,
    10.0 / np.sqrt(3.0),
    60.0,
)  # the greatest derivatives of the quintic law from 0 to 1 in a second


def keeps_limits(trajectory: Trajectory, limits: MotionLimits, change: Change, start: float) -> bool:
    """Whether a trajectory that is within its limits at a rate of one stays within them while the rate is changed.

    Args:
        trajectory: it. limits: of its joints.
        change: of the rate; both rates are 1 or less.
        start: when the change was asked for, on the clock of the motion [s].
    """
    seconds, times = _looked_at(trajectory, change, start)
    if not len(times):
        return True
    s, ds, dds = (each[:, None] for each in change.rate(seconds))
    q1, q2, q3, q4 = (trajectory.at(times, order) for order in (1, 2, 3, 4))
    acceleration, jerk = q2 * s * s + q1 * ds, q3 * s**3 + 3.0 * q2 * s * ds + q1 * dds
    half = 0.5 * np.diff(seconds, append=seconds[-1] + STEP).max()
    step = abs(change.last - change.first)
    d1, d2, d3 = (step * slope / change.lasts**order for order, slope in enumerate(SLOPES, 1))
    # Pieces have degree five or less, so the fourth derivative is greatest at the ends of what is looked at of them.
    slope = np.abs(q4).max(axis=0) + 6.0 * limits.jerk * d1
    slope = slope + limits.acceleration * (4.0 * d2 + 3.0 * d1 * d1) + limits.velocity * d3
    return bool(
        (np.abs(acceleration) + half * limits.jerk <= limits.acceleration).all()
        and (np.abs(jerk) + half * slope <= limits.jerk).all()
    )


def _looked_at(trajectory: Trajectory, change: Change, start: float) -> tuple[Array, Array]:
    """Seconds since the change was asked for (k,) while it is under way, with the times of the motion (k,)."""
    seconds = np.append(np.arange(change.delay, change.ends, STEP), change.ends)
    times = start + change.passed(seconds)
    knots = trajectory.knots
    inner = knots[(knots > times[0] + SIDE) & (knots <= times[-1])]
    at = np.interp(inner, times, seconds)
    for _ in range(2):  # Newton's steps: the time at which the clock passes a border of pieces
        at = at - (start + change.passed(at) - inner) / change.rate(at)[0]
    order = np.argsort(seconds := np.concatenate([seconds, at, at]), kind="stable")
    seconds, times = seconds[order], np.concatenate([times, inner, inner - SIDE])[order]
    inside = (times >= knots[0]) & (times <= knots[-1])
    return seconds[inside], times[inside]
