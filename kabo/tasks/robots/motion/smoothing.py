"""One motion from rest to rest through several parts, without stops between them, with rounded corners.

Corners are rounded as far as the motion is proven: the trajectory that is sent, not only the path that it is near. Where
no round is proven the motion stops at the corner.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.motion import Held, MotionLimits, Timed, timed_path
from kabo.motion.bernstein import derivative, values
from kabo.tasks.robots.motion.curves import curves_of, finer_samples
from kabo.tasks.robots.motion.insertions import insertion_nearness, inserts
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.rounds import Rounds
from kabo.tasks.robots.motion.routes import Refused, Route, route_of
from kabo.tasks.robots.timed_paths import TimedPath, cut

DEVIATION = 0.4  # rad, L2: how far a motion may pass by a way point, where nobody says otherwise
# rad, L2: the same where the base drives. Chords of wider rounds are farther from them, and all of the robot with it: too
# little of the clearance would be proven.
DRIVEN_DEVIATION = 0.2
AT_GOALS = 0.2  # rad, L2: the same where a stage reaches its goal, which a person has chosen
EXACT_DEVIATION = 1e-3  # rad, L2: the same where the motion keeps its shape
JOINING_DEVIATION = 2e-6  # rad, L2: the same where parts are put together
THINNING_SHARE = 0.1  # share of the deviation that may be used by leaving out way points
MAX_THINNING = 5e-3  # rad, L2: the same, at most
SHRINKING = 0.5**0.25  # of rounds that are not proven
LEAST_SHARE = 1.0 / 64  # of the greatest blend, below which the motion stops at the corner
TOLERANCE = 1e-4  # rad or m by which a joint may leave a blend, so that the pieces of a motion are few
LEAST_TOLERANCE = 1e-6  # rad or m: the same, at least
AT_REST = 1e-6  # rad/s or m/s
COARSEST_CHORD = 4e-3  # rad, L2: how far chords of a blend may be from it, before any proof
COARSEST_DRIVEN_CHORD = 5e-4  # m: the same where the base drives, which moves all of a robot by as much


@dataclass(frozen=True)
class Smoothed:
    """The motions of all parts, from time 0 on, and the number of inner corners where the whole still stops."""

    parts: tuple[TimedPath, ...]
    stops: int


def smoothed(
    parts: Sequence[MotionPart],
    limits: MotionLimits,
    deviation: float,
    held: Held | None = None,
    at_goals: float = np.inf,
) -> Smoothed:
    """The fastest motion from rest to rest along all parts that is proven, and passes way points within `deviation`.

    Args:
        parts: stretches of the same joints, each beginning where the one before ends; all of them move.
        limits: of these joints.
        deviation: how far the motion may be from the straight pieces between way points [rad, L2]; 0: it stops at each.
        held: what the robot holds.
        at_goals: the same where one part ends and the next one begins, if that is less.

    Raises:
        ValueError: a joint that moves has no limits above 0, or what is held slips even at rest.
    """
    found = smoothed_within(parts, limits, deviation, held, at_goals, np.inf)
    assert found is not None
    return found


def smoothed_within(
    parts: Sequence[MotionPart],
    limits: MotionLimits,
    deviation: float,
    held: Held | None,
    at_goals: float,
    seconds: float,
) -> Smoothed | None:
    """As `smoothed`; None as soon as the motion is not faster than some time, for it only gets slower by its proof."""
    thinning = min(THINNING_SHARE * deviation, MAX_THINNING)
    within = deviation - thinning
    curves = curves_of(parts) if deviation > 0.0 else frozenset()
    finer: dict[int, Array | None] = {}  # samples of curves whose way points were too few
    while True:
        samples = {number: found for number, found in finer.items() if found is not None}
        route = route_of(parts, thinning, curves, samples)
        greatest = np.zeros(len(route.corners))
        if within > 0.0:
            greatest = route.greatest_shares(within, max(0.0, at_goals - thinning))
        found = _rounded(route, limits, within, greatest, held, seconds)
        if found is None:
            return None
        if isinstance(found, Timed):
            return Smoothed(tuple(cut(found, parts[0].joints, route.borders)), _stops(found))
        tried = {number: finer_samples(parts[number]) for number in sorted(found - finer.keys())}
        curves -= {number for number in found if tried.get(number) is None}
        finer |= tried


def _rounded(
    route: Route, limits: MotionLimits, within: float, greatest: Array, held: Held | None, seconds: float
) -> Timed | frozenset[int] | None:
    """The motion along a route with corners rounded as far as it is proven, or the curves of which it is not.

    `greatest` are the shares (m,) of rounds that are tried first. None if it does not take less than some seconds.
    """
    near = nearness_of(route.parts, route.curves, within)
    chord = min(COARSEST_DRIVEN_CHORD if any(part.drives for part in route.parts) else COARSEST_CHORD, near)
    rounds = Rounds(route, within, chord)
    if seconds < np.inf:  # times cost less than proofs: with the widest rounds the motion is the fastest
        widest = _timed(route, limits, within, greatest, chord, min(TOLERANCE, near), held)
        if widest.duration >= seconds:
            return None
    shares = _fitting(rounds, greatest, greatest, rounds.looked_at)
    while True:
        made = _timed(route, limits, within, shares, chord, min(TOLERANCE, near), held)
        if made.duration >= seconds:
            return None
        found = route.proven(made)
        if isinstance(found, Timed):
            return found
        if not shares[found.corners].any():
            # With stops at all corners in question nothing is left to shrink: the straight path was proven before.
            return found.curves or route.curves or made
        less = _fitting(rounds, shares, greatest, rounds.judged)
        shares = _shrunk(shares, found.corners, greatest) if np.array_equal(less, shares) else less


def _timed(
    route: Route,
    limits: MotionLimits,
    within: float,
    shares: Array,
    chord: float,
    tolerance: float,
    held: Held | None,
) -> Timed:
    """The motion along a route, not proven yet; branches of a plan share those that differ in what is around them."""

    def made() -> Timed:
        return timed_path(
            route.corners,
            limits,
            deviation=within,
            shares=shares,
            chord=chord,
            tolerance=tolerance,
            held=held,
            slopes=route.slopes,
        )

    if held is not None:  # where it is, is a function
        return made()
    slopes = None if route.slopes is None else route.slopes.tobytes()
    arrays = *(each.tobytes() for each in limits.rows), route.corners.tobytes(), shares.tobytes(), slopes
    key = "timed", len(route.corners), *arrays, within, chord, tolerance
    found: Timed = route.parts[0].scene.context.surroundings.remembered(key, made)
    return found


def _fitting(rounds: Rounds, shares: Array, greatest: Array, judge: Callable[[Array], Refused | None]) -> Array:
    """Shares (m,), none greater than those given, with which a judge does not refuse the path for its rounds.

    The path is judged before the motion along it, as times cost more.
    """
    while shares.any():
        refused = judge(shares)
        bending = [] if refused is None else rounds.bending(shares, refused)
        if not bending:
            break
        shares = _shrunk(shares, bending, greatest)
    return shares


def _shrunk(shares: Array, corners: list[int], greatest: Array) -> Array:
    """The shares (m,) with less at some corners; none where little is left of the greatest ones."""
    found, less = np.array(shares), SHRINKING * shares[corners]
    found[corners] = np.where(less >= LEAST_SHARE * greatest[corners], less, 0.0)
    return found


def _stops(made: Timed) -> int:
    """The number of inner corners at which a motion stops: where no round is proven, or none would save time."""
    times = made.passing[list(made.corners[1:-1])]
    k = np.clip(np.searchsorted(made.times, times, side="right") - 1, 0, len(made.coefficients) - 1)
    speeds = values(np.asarray(derivative(made.coefficients[k], 1)), (times - made.times[k])[:, None])
    return int((np.abs(speeds).max(axis=1, initial=0.0) < AT_REST).sum())


def nearness_of(parts: Sequence[MotionPart], curves: frozenset[int], within: float) -> float:
    """How far joints may leave chords, and chords the path [rad or m]: curves on which parts are joined have their own."""
    if len(parts) == 1 and curves and inserts(parts[0]):
        return insertion_nearness(parts[0])
    return max(within, LEAST_TOLERANCE)


def deviation_of(parts: Sequence[MotionPart]) -> float:
    """How far a motion through parts may pass by their way points [rad, L2]."""
    if inserts(parts[0]):
        return JOINING_DEVIATION
    if parts[0].stretch.exact:
        return EXACT_DEVIATION
    return DRIVEN_DEVIATION if any(part.drives for part in parts) else DEVIATION
