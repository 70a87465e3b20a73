"""Which pairs of bodies of a course come nearest, before any of them is proven apart.

A proof is worth as much effort as its margin decides something: the least one of the stretch, and of each object. So it is
measured first at some places along the path which pairs these are; of every other pair no more is wanted than theirs.
"""

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.nearest_pairs import (
    Measuring,
    Pairs,
    Placed,
    all_caps,
    bound_pairs,
    cap_of,
    next_pair,
    place_bodies,
    settle,
)
from kabo.geometry.collision.separation_proofs import Course, Prover

PLACES = 72  # along a path, about, where distances are looked at
FARTHEST = 4  # pieces between two places: on longer ways parts that are not refined come nearest unseen


class NearPairs:
    """The pairs of a course by their distances: the nearest first, until none is left that decides anything."""

    def __init__(self, prover: Prover, course: Course, scopes: Integers, caps: Array) -> None:
        """Bounds the distances of all pairs.

        Args:
            prover: has the parts of all bodies.
            course: the bodies, their motion, and the pairs.
            scopes: (T,) the number of what has a least distance of its own, for each body; 0 for none.
            caps: (S,) distances [m] from which on nothing matters, of all pairs and of each scope.
        """
        chain, things, search = prover.setting(course)
        places = _places(len(course.waypoints) - 1)
        count, bodies = len(course.pairs), len(scopes)
        self._pairs = Pairs(course.pairs, scopes, caps.copy(), np.empty(count), np.empty(count, np.int64))
        wholes, balls = prover.whole_bodies(course)
        self._placed = Placed(
            things.rows,
            things.joint_T,
            balls,
            wholes,
            prover.extents,
            things.hulls,
            np.empty((bodies, len(places), 12)),
            np.empty((bodies, len(places), 3)),
            np.empty((bodies, 6)),
        )
        self._room = Measuring(np.zeros((2, 1, 12)), np.zeros((2, 4), np.int64), prover.between, search)
        frames = np.zeros((len(places), chain.joints.shape[1], 12))
        frames[:, 0, [0, 4, 8]] = 1.0
        segment = np.zeros(course.waypoints.shape[1])
        place_bodies(course.waypoints, places, chain, segment, frames, self._placed)
        moving = (course.waypoints != course.waypoints[0]).any(axis=0)
        if course.deviations is not None:
            moving |= (course.deviations > 0.0).any(axis=0)
        bound_pairs(self._pairs, self._placed, chain, moving)

    def next(self) -> int | None:
        """The number of the nearest pair that is not settled but decides something; None if there is none."""
        found = int(next_pair(self._pairs, self._placed, self._room))
        return None if found < 0 else found

    def cap(self, pair: int) -> float:
        """The distance from which on a pair decides nothing [m]."""
        return float(cap_of(self._pairs, pair))

    def distance(self, pair: int) -> float:
        """The distance of a pair as far as it is known [m]."""
        return float(self._pairs.lower[pair])

    def settle(self, pair: int, distance: float) -> None:
        """Notes the distance of a pair [m], which others need not come near."""
        settle(self._pairs, pair, distance)

    @property
    def caps(self) -> Array:
        """The least distances that are settled, of all pairs and of each scope [m]."""
        return self._pairs.caps

    def poses(self, pair: int) -> Array:
        """The poses (2, K, 12) of both bodies of a pair at the places that are looked at."""
        both = self._pairs.bodies[pair, :2].tolist()
        found = np.empty((2, self._placed.poses.shape[1], 12))
        for row, body in zip(found, both, strict=True):
            row[:] = self._placed.poses[body] if self._placed.rows[0, body] else self._placed.poses[body, 0]
        return found

    def wanted(self) -> Array:
        """The margin (P,) [m] that is worth having of each pair: its distance, or what decides nothing."""
        found = np.empty(len(self._pairs.lower))
        all_caps(self._pairs, found)
        return found


def _places(pieces: int) -> Array:
    """Places along a path: numbers of pieces and shares of them."""
    step = min(FARTHEST, max(1, -(-pieces // PLACES)))
    if step > 1:
        return np.append(np.arange(0.0, pieces, step), float(pieces))
    count = -(-PLACES // pieces)
    return np.arange(pieces * count + 1) / count
