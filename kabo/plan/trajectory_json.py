"""Trajectories in files: `times`, `coefficients` and `deviation`, beside the joints and way points of their segment.

Each coefficient has as many decimals as its effect in its piece needs (`kabo/motion/rounding.py`), so that values and
derivatives on both sides of a border of pieces still agree to 1e-9; powers whose coefficients are 0 at the end of a list
are left out.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from kabo.motion import MAX_DEGREE, Trajectory
from kabo.plan.checked_json import JsonValue

TIME_DECIMALS, DEVIATION_DECIMALS = 6, 9

Row = tuple[float, ...]


def rounded_trajectory(trajectory: Trajectory, waypoints: tuple[Row, ...]) -> Trajectory:
    """The trajectory with its numbers rounded as in a file, beside `waypoints` (m, n), which already are.

    Times are whole microseconds; the deviation is rounded up.
    """
    return replace(
        trajectory,
        waypoints=waypoints,
        times=tuple(round(float(t), TIME_DECIMALS) + 0.0 for t in trajectory.times),
        deviation=_rounded_up(float(trajectory.deviation)),
    ).rounded()


def trajectory_to_json(trajectory: Trajectory) -> dict[str, Any]:
    """The trajectory as JSON values, without what its segment says: joints and way points."""
    return {
        "times": list(trajectory.times),
        "coefficients": [[list(own) for own in piece] for piece in trajectory.coefficients],
        "deviation": trajectory.deviation,
    }


def trajectory_from_json(
    place: JsonValue, joints: tuple[str, ...], waypoints: tuple[Row, ...], segment_times: Sequence[float]
) -> Trajectory:
    """The trajectory of a segment; faults of its form are added to the findings.

    Args:
        place: the object with `times`, `coefficients` and `deviation`.
        joints: the n joints of the segment.
        waypoints: its way points (m, n).
        segment_times: its times (m,), with which the trajectory begins and ends.
    """
    fields = place.fields(("times", "coefficients", "deviation"))
    times = _times(fields["times"], segment_times)
    pieces = fields["coefficients"].items()
    if isinstance(fields["coefficients"].value, list) and times and len(pieces) != len(times) - 1:
        fields["coefficients"].add_finding(f"{len(pieces)} pieces for {len(times)} times: one between each two")
    coefficients = tuple(tuple(map(_powers, piece.items(exactly=len(joints)))) for piece in pieces)
    deviation = fields["deviation"].number()
    if deviation < 0.0:
        fields["deviation"].add_finding("a deviation is a distance, never negative")
    return Trajectory(joints, waypoints, times, coefficients, deviation)


def _rounded_up(deviation: float) -> float:
    nearest = round(deviation, DEVIATION_DECIMALS) + 0.0
    return nearest if nearest >= deviation else round(nearest + 10.0**-DEVIATION_DECIMALS, DEVIATION_DECIMALS)


def _times(place: JsonValue, segment_times: Sequence[float]) -> Row:
    entries = place.items(2)
    times = tuple(entry.number() for entry in entries)
    if times and times[0] < 0.0:
        entries[0].add_finding("a time is never negative")
    for before, after, entry in zip(times, times[1:], entries[1:], strict=False):
        if after <= before:
            entry.add_finding(f"times increase, but {after:g} follows {before:g}")
    if len(times) > 1 and len(segment_times) > 1:
        for entry, found, due, end in (
            (entries[0], times[0], segment_times[0], "begins"),
            (entries[-1], times[-1], segment_times[-1], "ends"),
        ):
            if found != due:
                entry.add_finding(f"the segment {end} at {due:g} s, its trajectory at {found:g} s")
    return times


def _powers(place: JsonValue) -> Row:
    found = place.value
    usual = isinstance(found, list) and 1 <= len(found) <= MAX_DEGREE + 1
    if usual and all(type(c) is float and math.isfinite(c) for c in found):  # without an object for each number
        return tuple(c + 0.0 for c in found)
    entries = place.items(1)
    if len(entries) > MAX_DEGREE + 1:
        place.add_finding(f"{len(entries)} coefficients: a piece has degree {MAX_DEGREE} or less")
    return tuple(entry.number() for entry in entries)
