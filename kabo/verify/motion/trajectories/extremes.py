"""The greatest size of polynomials and of their derivatives: proven limits, and how much of each limit is used."""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array, Integers
from kabo.verify.motion.trajectories.curves import Curve, bernstein, derived, halves

LIMIT_TOLERANCE = 1e-9  # share of a limit, or [rad or m] of a position, by which rounding may exceed it
MAX_HALVINGS = 40
SHARE_ACCURACY = 1e-4  # within which the greatest share of a limit is told


@dataclass(frozen=True)
class Extreme:
    """The greatest share of a limit that is used: which joint, when [s], and the value reached there."""

    share: float
    joint: int
    time: float
    value: float

    @property
    def too_much(self) -> bool:
        """Whether the limit is exceeded."""
        return self.share > 1.0 + LIMIT_TOLERANCE


def greatest(curve: Curve, order: int, limits: Array, known: float = 0.0) -> Extreme:
    """The greatest size of a derivative of a curve, as a share of the joints' limits (n,).

    It is decided exactly whether the share exceeds 1; the share itself is exact within `SHARE_ACCURACY` if it exceeds
    `known`.
    """
    powers = curve.powers
    for _ in range(order):
        powers = derived(powers)
    sizes = np.maximum(limits, 1e-300)
    shares = bernstein(powers, np.diff(curve.times)) / sizes[:, None]
    rows = np.stack(np.meshgrid(*map(np.arange, shares.shape[:2]), indexing="ij"), axis=-1).reshape(-1, 2)
    flat = shares.reshape(-1, 6)
    found = _search(curve, np.concatenate([flat, -flat]), np.tile(rows, (2, 1)), known)
    speed = curve.at(np.array([found.time]), order)[0, found.joint]
    value = found.share * float(limits[found.joint])
    return Extreme(found.share, found.joint, found.time, value if value > 0.0 else abs(float(speed)))


def outside(curve: Curve, lower: Array, upper: Array) -> Extreme | None:
    """Where a curve leaves the limits of its joints (n,) farthest, with the value there; None if it does not."""
    coefficients = bernstein(curve.powers, np.diff(curve.times))
    worst: Extreme | None = None
    for sign, bound in ((1.0, upper), (-1.0, -lower)):
        over = sign * coefficients - bound[:, None]
        rows = np.argwhere((over > LIMIT_TOLERANCE).any(axis=2))
        if not len(rows):
            continue
        found = _search(curve, 1.0 + over[rows[:, 0], rows[:, 1]], rows, np.inf)
        if found.too_much and (worst is None or found.share > worst.share):
            value = sign * (found.share - 1.0 + float(bound[found.joint]))
            worst = Extreme(found.share, found.joint, found.time, value)
    return worst


def _search(curve: Curve, shares: Array, rows: Integers, known: float) -> Extreme:
    """The greatest value of polynomials with Bernstein coefficients (T, 6), by branch and bound over halved intervals.

    `rows` (T, 2) are the piece and the joint of each.
    """
    places = np.zeros((len(shares), 2))
    places[:, 1] = 1.0  # the interval, as shares of the piece
    best, where = -np.inf, (0, 0, 0.0)
    for depth in range(MAX_HALVINGS + 1):
        ends = shares[:, [0, -1]]
        k, side = np.unravel_index(int(ends.argmax()), ends.shape)
        if ends[k, side] > best:
            best, where = float(ends[k, side]), (int(rows[k, 0]), int(rows[k, 1]), float(places[k, side]))
        bounds = shares.max(axis=1)
        if depth == MAX_HALVINGS:
            best = max(best, float(bounds.max()))  # what could not be excluded counts
            break
        # What is greater than all that is known, and beside that what is not yet known to be within the limit.
        open_ = bounds > max(best, known) * (1.0 + SHARE_ACCURACY)
        if best <= 1.0 + LIMIT_TOLERANCE:
            open_ |= bounds > 1.0 + LIMIT_TOLERANCE
        if not open_.any():
            break
        first, second = halves(shares[open_])
        middle = places[open_].mean(axis=1)
        before = np.stack([places[open_, 0], middle], axis=1)
        after = np.stack([middle, places[open_, 1]], axis=1)
        shares, places = np.concatenate([first, second]), np.concatenate([before, after])
        rows = np.tile(rows[open_], (2, 1))
    piece, joint, place = where
    time = float(curve.times[piece] + place * (curve.times[piece + 1] - curve.times[piece]))
    return Extreme(best, joint, time, best)
