"""Which pair of bodies comes nearest along a path: found by bounds, so that few pairs are measured at few places.

Every pair has a lower bound of its distance: at first that of balls around the bodies, then what was measured with the
parts as they are, then what was found after these were refined. The pair with the least bound is looked at more
closely, until that of a pair that matters was measured [branch and bound].
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import Hulls, Search
from kabo.geometry.collision.kernels.nearest_places import (
    Between,
    body_poses,
    box_gap,
    gap_of_parts,
    poses_at,
    relative,
)
from kabo.geometry.collision.kernels.witness import FIRST_PART, JOINT, LAST_PART

BOUNDED, MEASURED, SETTLED = 0, 1, 2  # stages of a pair


class Pairs(NamedTuple):
    """Pairs of bodies, and what is known of their distances."""

    bodies: Integers  # (P, 3) first, second, frame
    scopes: Integers  # (T,) of each body the number of what has a least distance of its own; 0 for none
    caps: Array  # (S,) the least distance so far, of all pairs and of each scope [m]
    lower: Array  # (P,) a lower bound of each pair's distance [m]
    stage: Integers  # (P,)


class Placed(NamedTuple):
    """Bodies at some places along a path."""

    rows: Integers  # (3, T) joint, first part, part after the last
    joint_T: Array  # (T, 12)
    balls: Array  # (T, 4) around each body, in its frame: middle and radius
    wholes: Integers  # (T,) the rows of `extents` of whole bodies
    extents: Array  # (.., 6) middles and half sides of the boxes of all parts, and of whole bodies
    hulls: Hulls  # of all parts
    poses: Array  # (T, K, 12) in the world; of bodies that stand only the first
    middles: Array  # (T, K, 3) of the balls
    ranges: Array  # (T, 6) of these, lower and upper


class Measuring(NamedTuple):
    """Room for measuring a pair."""

    poses: Array  # (2, 1, 12)
    ends: Integers  # (2, 4)
    between: Between
    search: Search


@lean_kernel
def _at(placed, body, k):
    """The row of a body's pose at a place."""
    return k if placed.rows[JOINT, body] > 0 else 0


@lean_kernel
def _ball_gap(placed, first, second, k):
    """The gap between the balls around two bodies at a place [m]."""
    square, i, j = 0.0, _at(placed, first, k), _at(placed, second, k)
    for r in range(3):
        way = placed.middles[first, i, r] - placed.middles[second, j, r]
        square += way * way
    return np.sqrt(square) - placed.balls[first, 3] - placed.balls[second, 3]


@lean_kernel
def place_bodies(waypoints, places, chain, segment, frames, placed):
    """Writes where all bodies are at places (K,) along a path: way point, and share of its piece."""
    poses_at(waypoints, places, chain, segment, frames)
    for t in range(placed.rows.shape[1]):
        joint = placed.rows[JOINT, t]
        count = places.shape[0] if joint > 0 else 1
        body_poses(frames[:count], joint, placed.joint_T[t], placed.poses[t])
        for k in range(count):
            for r in range(3):
                placed.middles[t, k, r] = placed.poses[t, k, 9 + r]
                for c in range(3):
                    placed.middles[t, k, r] += placed.poses[t, k, 3 * r + c] * placed.balls[t, c]
        for r in range(3):
            placed.ranges[t, r], placed.ranges[t, 3 + r] = np.inf, -np.inf
            for k in range(count):
                placed.ranges[t, r] = min(placed.ranges[t, r], placed.middles[t, k, r])
                placed.ranges[t, 3 + r] = max(placed.ranges[t, 3 + r], placed.middles[t, k, r])


@lean_kernel
def _moves(joint, frame, chain, moving):
    """Whether any joint between a frame and another joint moves."""
    found, factors = False, chain.factors
    while joint != frame and not found:
        found = moving[chain.joints[2, joint]] and factors[0, joint] != 0.0
        joint = chain.joints[0, joint]
    return found


@lean_kernel
def bound_pairs(pairs, placed, chain, moving):
    """Writes the lower bounds that balls along the path give of the distances of all pairs; of those at rest infinity.

    `moving` (n,) says which values of a configuration change along the path.
    """
    for p in range(pairs.bodies.shape[0]):
        first, second, frame, square = pairs.bodies[p, 0], pairs.bodies[p, 1], pairs.bodies[p, 2], 0.0
        pairs.lower[p], pairs.stage[p] = np.inf, SETTLED
        if not (
            _moves(placed.rows[JOINT, first], frame, chain, moving)
            or _moves(placed.rows[JOINT, second], frame, chain, moving)
        ):
            continue
        for r in range(3):
            way = max(
                placed.ranges[first, r] - placed.ranges[second, 3 + r],
                placed.ranges[second, r] - placed.ranges[first, 3 + r],
            )
            square += way * way if way > 0.0 else 0.0
        pairs.lower[p], pairs.stage[p] = (
            np.sqrt(square) - placed.balls[first, 3] - placed.balls[second, 3],
            BOUNDED,
        )


@lean_kernel
def _least_at(placed, first, second, k, limit, room):
    """The distance of two bodies at a place, or `limit` if that is not more [m]."""
    extents, between = placed.extents, room.between
    for i in range(12):
        room.poses[0, 0, i] = placed.poses[first, _at(placed, first, k), i]
        room.poses[1, 0, i] = placed.poses[second, _at(placed, second, k), i]
    relative(room.poses, 0, between.turn, between.at)
    a, b = placed.wholes[first], placed.wholes[second]
    if box_gap(extents, a, b, between.turn, between.at, between.apart, limit) >= limit:
        return limit
    for i in range(placed.rows[FIRST_PART, first], placed.rows[LAST_PART, first]):
        if box_gap(extents, i, b, between.turn, between.at, between.apart, limit) >= limit:
            continue
        for j in range(placed.rows[FIRST_PART, second], placed.rows[LAST_PART, second]):
            if box_gap(extents, i, j, between.turn, between.at, between.apart, limit) < limit:
                gap = gap_of_parts(placed.hulls, i, j, room.poses, 0, limit, room.ends, room.search, between)
                limit = min(limit, gap)
    return limit


@lean_kernel
def _measured(placed, first, second, limit, room):
    """The least distance of two bodies at all places, or `limit` if that is not more [m]."""
    nearest, least = 0, np.inf
    for k in range(placed.poses.shape[1]):
        gap = _ball_gap(placed, first, second, k)
        if gap < least:
            nearest, least = k, gap
    limit = _least_at(placed, first, second, nearest, limit, room)
    for k in range(placed.poses.shape[1]):
        if k != nearest and _ball_gap(placed, first, second, k) < limit:
            limit = _least_at(placed, first, second, k, limit, room)
    return limit


@lean_kernel
def cap_of(pairs, p):
    """The distance [m] from which on a pair is not the least one of anything that it counts for."""
    first, second = pairs.scopes[pairs.bodies[p, 0]], pairs.scopes[pairs.bodies[p, 1]]
    return max(pairs.caps[0], pairs.caps[first], pairs.caps[second])


@lean_kernel
def next_pair(pairs, placed, room):
    """The nearest pair that is not settled but may matter, measured; -1 if there is none."""
    while True:
        found, least = -1, np.inf
        for p in range(pairs.bodies.shape[0]):
            if pairs.stage[p] < SETTLED and pairs.lower[p] < min(least, cap_of(pairs, p)):
                found, least = p, pairs.lower[p]
        if found < 0 or pairs.stage[found] == MEASURED:
            return found
        first, second = pairs.bodies[found, 0], pairs.bodies[found, 1]
        pairs.lower[found] = _measured(placed, first, second, cap_of(pairs, found), room)
        pairs.stage[found] = MEASURED


@lean_kernel
def settle(pairs, p, distance):
    """Notes the distance of a pair [m], which others need not come near."""
    pairs.lower[p], pairs.stage[p] = distance, SETTLED
    pairs.caps[0] = min(pairs.caps[0], distance)
    for e in range(2):
        scope = pairs.scopes[pairs.bodies[p, e]]
        pairs.caps[scope] = min(pairs.caps[scope], distance)


@lean_kernel
def all_caps(pairs, caps):
    """Writes of each pair (P,) the distance that it need not exceed [m]: its own one if that was settled."""
    for p in range(pairs.bodies.shape[0]):
        caps[p] = pairs.lower[p] if pairs.stage[p] == SETTLED else cap_of(pairs, p)
