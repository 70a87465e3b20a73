"""Trajectories for the player: as in files, with as many digits as the page needs to place joints to `WITHIN`."""

import math
from collections.abc import Sequence
from typing import Any

from kabo.motion import MAX_DEGREE, Trajectory

DECIMALS = 8  # of joint values [rad or m]: what one coefficient is off moves a joint by half of the last at most
WITHIN = 0.5 * (MAX_DEGREE + 1) * 10.0**-DECIMALS  # rad or m


def shown_trajectory(trajectory: Trajectory) -> dict[str, Any]:
    """The `times` and `coefficients` of a trajectory; higher powers of short pieces have fewer digits."""
    return {
        "times": list(trajectory.times),
        "coefficients": [
            [_rounded(own, end - begin) for own in piece]
            for piece, begin, end in zip(
                trajectory.coefficients, trajectory.times, trajectory.times[1:], strict=False
            )
        ],
    }


def _rounded(own: Sequence[float], duration: float) -> list[float]:
    longest = max(duration, 1e-6)
    return [round(c, DECIMALS + math.ceil(power * math.log10(longest))) + 0.0 for power, c in enumerate(own)]


def trajectory_of_report(
    joints: Sequence[str], waypoints: Sequence[Sequence[float]], times: Sequence[float], given: Any
) -> Trajectory | None:
    """The trajectory of a report's segment; None without one.

    Raises:
        ValueError: its pieces do not fit its times, its joints, or the segment's times.
    """
    if given is None:
        return None
    own, pieces = given["times"], given["coefficients"]
    fits = len(own) == len(pieces) + 1 > 1 and (own[0], own[-1]) == (times[0], times[-1])
    degrees = {len(each) for piece in pieces for each in piece}
    if (
        not fits
        or {len(piece) for piece in pieces} != {len(joints)}
        or not degrees <= set(range(1, MAX_DEGREE + 2))
    ):
        raise ValueError("a trajectory does not fit its segment")
    rows = tuple(tuple(row) for row in waypoints)
    coefficients = tuple(tuple(tuple(each) for each in piece) for piece in pieces)
    return Trajectory(tuple(joints), rows, tuple(own), coefficients, given["deviation"])
