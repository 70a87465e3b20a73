"""The fastest motion from rest to rest along a straight line, with limits of velocity, acceleration and jerk.

Seven phases of constant jerk, +J 0 -J 0 -J 0 +J, of durations Tj Ta Tj Tv Tj Ta Tj [Biagiotti, Melchiorri 2008, 3.4]. They
move by J Tj (Tj + Ta) (2 Tj + Ta + Tv). Durations are rounded up to whole microseconds, and J is what then remains to
move by exactly the length: jerk, greatest acceleration J Tj and greatest velocity J Tj (Tj + Ta) only fall by this.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.motion.limits import NAMES, MotionLimits

TICK = 1e-6  # [s]: times in plans are whole microseconds
MAX_LIMIT = 1e9  # infinite limits count as this
# Rounded coefficients and times may exceed a limit by this share, or by this much.
LIMIT_SHARE, LIMIT_ROUNDING = 1e-9, 5e-11
MAX_TICKS = 10**13


class Phases(NamedTuple):
    """Durations of the phases with jerk, with constant acceleration, with constant velocity [whole microseconds]."""

    jerk: int
    acceleration: int
    velocity: int

    @property
    def ticks(self) -> int:
        """The duration of the whole motion in microseconds."""
        return 4 * self.jerk + 2 * self.acceleration + self.velocity


def line_limits(step: Array, limits: MotionLimits) -> tuple[float, float, float]:
    """The greatest velocity, acceleration and jerk of the share λ of a straight line by `step` (n,).

    Raises:
        ValueError: nothing moves, or a joint that moves has a limit of zero.
    """
    moved = np.flatnonzero(step)
    if not len(moved):
        raise ValueError("a piece of motion needs a length")
    ways = np.abs(step[moved])
    found = []
    for name, row in zip(NAMES, limits.rows, strict=True):
        own = np.minimum(row[moved], MAX_LIMIT)
        if not np.all(own > 0.0):
            raise ValueError(f"joints that move need limits of {name} above 0, not {row[moved]}")
        own = own - np.minimum(LIMIT_SHARE * own + LIMIT_ROUNDING, own / 2)
        found.append(float((own / ways).min()))
    return found[0], found[1], found[2]


def phases(velocity: float, acceleration: float, jerk: float) -> Phases:
    """The durations of the fastest motion of λ from 0 to 1 within the limits of its derivatives."""
    ramp = acceleration / jerk
    if velocity < acceleration * ramp:  # the greatest acceleration is never reached
        ramp, hold = float(np.sqrt(velocity / jerk)), 0.0
    else:
        hold = velocity / acceleration - ramp
    cruise = 1.0 / velocity - (2.0 * ramp + hold)
    if cruise < 0.0:  # neither is the greatest velocity
        cruise, hold = 0.0, 0.0
        ramp = float(np.cbrt(0.5 / jerk))
        if jerk * ramp > acceleration:
            ramp = acceleration / jerk
            hold = max(0.0, (float(np.sqrt(ramp**2 + 4.0 / acceleration)) - 3.0 * ramp) / 2.0)
    tj, ta, tv = (int(min(MAX_TICKS, np.ceil(t / TICK - 1e-9))) for t in (ramp, hold, cruise))
    return Phases(max(tj, 1), ta, tv)


def stopping_ticks(points: Array, limits: MotionLimits) -> int:
    """The whole microseconds that a motion along way points (m, n) takes which stops at each; all steps are possible."""
    ways = np.abs(np.diff(points, axis=0))
    rows = []
    for row in limits.rows:
        own = np.minimum(row, MAX_LIMIT)
        own = own - np.minimum(LIMIT_SHARE * own + LIMIT_ROUNDING, own / 2)
        rows.append((own / np.maximum(ways, 1e-300)).min(axis=1).tolist())
    return sum(phases(*each).ticks for each in zip(*rows, strict=True))


def line_pieces(start: Array, end: Array, limits: MotionLimits) -> tuple[list[int], Array]:
    """The fastest motion from rest to rest between two different configurations (n,).

    Returns: durations of at most seven pieces [whole microseconds], and their coefficients (pieces, n, 6).

    Raises:
        ValueError: nothing moves, or a joint that moves has a limit of zero.
    """
    step = end - start
    own = phases(*line_limits(step, limits))
    spans = [own.jerk, own.acceleration, own.jerk, own.velocity, own.jerk, own.acceleration, own.jerk]
    tj, ta, tv = (each * TICK for each in own)
    jerk = 1.0 / (tj * (tj + ta) * (2.0 * tj + ta + tv))
    states = _states(jerk, tj, ta, tv)
    kept = [k for k in range(7) if spans[k]]
    shares = np.zeros((len(kept), 6))
    shares[:, :4] = states[kept]
    pieces = step[:, None] * shares[:, None, :]
    # The second half is measured from the end: so the motion ends exactly there.
    begin = np.where(np.asarray(kept) < 4, 0.0, 1.0)[:, None]
    pieces[:, :, 0] += start + begin * step
    return [spans[k] for k in kept], pieces


def _states(jerk: float, tj: float, ta: float, tv: float) -> Array:
    """The four coefficients of λ (of λ - 1 in the last three phases), for each of seven phases."""
    a = jerk * tj
    v1, v2, v3 = a * tj / 2, a * tj / 2 + a * ta, a * (tj + ta)
    s1 = jerk * tj**3 / 6
    s2 = s1 + v1 * ta + a * ta**2 / 2
    s3 = s2 + v2 * tj + a * tj**2 / 2 - jerk * tj**3 / 6
    s4 = s2 + 0.0
    return np.array(
        [
            [0.0, 0.0, 0.0, jerk / 6],
            [s1, v1, a / 2, 0.0],
            [s2, v2, a / 2, -jerk / 6],
            [s3, v3, 0.0, 0.0],
            [-s3, v3, 0.0, -jerk / 6],
            [-s4, v2, -a / 2, 0.0],
            [-s1, v1, -a / 2, jerk / 6],
        ]
    )
