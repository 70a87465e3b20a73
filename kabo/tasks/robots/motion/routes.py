"""Routes: the corners of a motion through several parts, and the proof of a motion that rounds them.

Each part keeps the contacts, the constraint and the scene that it was made for: a straight piece and the blends that
reach over it are proven with those of its part. Where a body is lifted from another, contact between the two is
permitted on that stroke only; motion that leaves the stroke is proven without it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.motion import Timed, thinned
from kabo.motion.blending import CORNER_SHARE, GENTLE_TURN
from kabo.motion.kernels.near_pieces import REFUSED, Whose, asked_of
from kabo.tasks.robots.motion.curves import knots_of, slopes_of
from kabo.tasks.robots.motion.insertions import inserts, keeps_insertion
from kabo.tasks.robots.motion.parts import JOINT_DECIMALS, MOVING, MotionPart
from kabo.tasks.robots.motion.resting_strokes import CLOSENESS, CURVED, ROUNDING, RestingStroke, resting_stroke
from kabo.tasks.robots.timed_paths import TIME_DECIMALS

ON_PATH = 1e-8  # rad or m: deviations of straight pieces; they are proven already
# Where a chord of a blend is proven with this multiple of what the motion deviates from it, it is near enough: then
# most of the distance to the nearest obstacle is left.
MARGIN = 4.0
AT_LIMIT = 1e-10  # rad or m by which rounding may take a joint out of its limits
MAX_HALVINGS = 4  # of a chord that is not proven with its margin; the last ones are proven without
NEARNESS = np.array([CLOSENESS, CURVED, ROUNDING])  # of a motion to strokes
LINE_PLACES = np.linspace(0.0, 1.0, 9)  # shares of the time of a stroke at which its line is compared
BENDING_SHARE = 0.7  # rounds that bend the path as much as this share of the most that one does, shrink
STROKE_TOLERANCE = 1e-9  # rad of the distance of a point from a stroke


class Refused(NamedTuple):
    """What is not proven of a motion: the corners next to it, the parts that are curves there, and the times (k, 2)."""

    corners: list[int]
    curves: frozenset[int]
    spans: Array


@dataclass(frozen=True)
class Route:
    """The corners (m, n) of a motion; piece i, from corner i to corner i + 1, belongs to part `owners[i]`.

    The path through corners of a part that is a curve is a spline without turns; all of it is proven with the motion.
    """

    parts: Sequence[MotionPart]
    corners: Array
    owners: tuple[int, ...]
    stroke: float  # rad, L2: distance from which the motion has left a stroke on which bodies may touch
    curves: frozenset[int] = frozenset()  # numbers of parts
    slopes: Array | None = None  # (m - 1, 2, n) where each piece begins and ends; None without curves

    @property
    def borders(self) -> list[int]:
        """The inner corners at which one part ends and the next begins."""
        return [i for i in range(1, len(self.owners)) if self.owners[i] != self.owners[i - 1]]

    @cached_property
    def _resting(self) -> Array:
        return np.array(self.parts[0].stretch.start)

    def whole(self, rows: Array) -> Array:
        """Configurations (k, N) for values (k, n) of the joints that move, as plans store them."""
        found = np.empty((len(rows), len(self._resting)))
        found[:] = self._resting
        found[:, self.parts[0].columns] = np.round(rows, JOINT_DECIMALS) + 0.0
        return found

    @cached_property
    def bends(self) -> Array:
        """The norm (m,) of the turn at each corner; 0 at both ends, and inside of curves."""
        if self.slopes is None:
            return turns(self.corners)
        inner = np.linalg.norm(self.slopes[1:, 0] - self.slopes[:-1, 1], axis=1)
        return np.concatenate([[0.0], inner, [0.0]])

    def proven(self, made: Timed) -> Timed | Refused:
        """A motion with as many way points on its blends as their proofs need, or what has none."""
        if beyond := self._beyond(made):
            return self._refused(made, beyond)
        waiting = np.arange(len(made.passing) - 1)
        for level in range(MAX_HALVINGS + 1):
            margin = MARGIN if level < MAX_HALVINGS else 1.0
            refused = self._unproven(made, waiting, margin)
            if not len(refused):
                return self._bent(made) or made
            if level < MAX_HALVINGS:
                made, waiting = made.with_middles(refused, TIME_DECIMALS)
        return self._refused(made, refused)

    def looked_at(self, made: Timed) -> Refused | None:
        """What is surely not proven of a motion, by a cheap look: joints beyond limits, bent strokes, places that hit."""
        if beyond := self._beyond(made):
            return self._refused(made, beyond)
        bent = self._bent(made, inserted=False)
        if bent is not None:
            return bent
        hopeless = self._unproven(made, np.arange(len(made.passing) - 1), None)
        return self._refused(made, hopeless) if len(hopeless) else None

    def _refused(self, made: Timed, refused: Sequence[int] | Integers) -> Refused:
        pieces = np.asarray(refused, np.int64)
        owners = frozenset(self._owners_of(made, pieces).tolist())
        corners = sorted({corner for i in pieces for corner in self._corners_by(made, i)})
        return Refused(
            corners, owners & self.curves, np.stack([made.passing[pieces], made.passing[pieces + 1]], axis=1)
        )

    def _owners_of(self, made: Timed, pieces: Integers) -> Integers:
        """The numbers of the parts to which pieces of the path belong."""
        at = np.searchsorted(made.corners, pieces, side="right") - 1
        return np.asarray(self.owners)[np.minimum(at, len(self.owners) - 1)]

    @cached_property
    def _places(self) -> Array:
        """The lengths (m,) of the straight pieces up to each corner [rad, L2]."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.corners, axis=0), axis=1))])

    @cached_property
    def _strokes(self) -> tuple[RestingStroke, ...]:
        """The strokes from where the motion rests: its first part and its last one, where they are strokes."""
        places = self._places
        cuts = [0, *self.borders, len(self.corners) - 1]
        first, last = range(cuts[1] + 1), range(cuts[-1], cuts[-2] - 1, -1)
        found = (
            resting_stroke(self.parts[0], first, np.abs(places[first] - places[0]), backward=False),
            resting_stroke(self.parts[-1], last, np.abs(places[last] - places[-1]), backward=True),
        )
        return tuple(each for each in found if each is not None)

    def greatest_shares(self, deviation: float, at_borders: float) -> Array:
        """The greatest share (m,) of each corner's trim with which strokes keep their shape, and borders are near.

        Args:
            deviation: how far the motion may pass by corners [rad, L2]: what whole trims are for.
            at_borders: the same where one part ends and the next one begins, if that is less.
        """
        bends, places = self.bends, self._places
        found = np.where(bends > 0.0, 1.0, 0.0) if self.curves else np.ones(len(self.corners))
        room = np.minimum(places, places[-1] - places)
        per_trim = CORNER_SHARE * np.maximum(bends, GENTLE_TURN)
        room = np.minimum(room, deviation / per_trim)[1:-1]
        inner = np.array(self.borders, np.int64)
        found[inner] = np.minimum(found[inner], at_borders / per_trim[inner] / room[inner - 1])
        for stroke in self._strokes:
            most = stroke.greatest_trims(places, bends)[1:-1]
            found[1:-1] = np.minimum(found[1:-1], most / room)
        return found

    def bending(self, path: Timed, trims: Array, spans: Array) -> list[int]:
        """The corners whose rounds bend a path most on parts of it: on each, nearly as much as another one, or more.

        Args:
            path: at unit speed.
            trims: of its rounds, for each corner (m,).
            spans: where the parts begin and end (k, 2).
        """
        places = path.passing[list(path.corners)][:, None]
        away = np.maximum(np.maximum(spans[:, 0] - places, places - spans[:, 1]), 0.0)
        t = np.maximum(0.0, 1.0 - away / np.maximum(trims, MOVING)[:, None]) / 2.0
        bent = (self.bends * trims)[:, None] * (2.0 * t**3 - t**4)
        most = bent.max(axis=0)
        return list(np.flatnonzero(((bent >= BENDING_SHARE * most) & (most > 0.0)).any(axis=1)).tolist())

    def _bent(self, made: Timed, *, inserted: bool = True) -> Refused | None:
        """The corners of strokes whose lines are not kept, and those strokes that are curves.

        `inserted`: whether curves on which parts are put together must be near enough to their line, too.
        """
        found: set[int] = set()
        curves: set[int] = set()
        spans = []
        for stroke in self._strokes:
            near, far = (made.passing[made.corners[stroke.corners[k]]] for k in (0, -1))
            rows = self.whole(made.at(near + (far - near) * LINE_PLACES))
            number = 0 if stroke.part is self.parts[0] else len(self.parts) - 1
            if stroke.kept(rows) and not (inserted and not self._inserted(made, stroke, number)):
                continue
            found.update(corner for corner in stroke.corners[1:] if corner not in (0, len(self.corners) - 1))
            curves.update({number} & self.curves)
            spans.append(sorted((near, far)))
        return Refused(sorted(found), frozenset(curves), np.array(spans)) if found or curves else None

    def _inserted(self, made: Timed, stroke: RestingStroke, number: int) -> bool:
        """Whether a curve on which parts may be put together keeps to its line, as mates want it."""
        if number not in self.curves or not inserts(stroke.part):
            return True
        low, high = sorted(made.corners[stroke.corners[k]] for k in (0, -1))
        rows = self.whole(made.waypoints[low : high + 1])
        return keeps_insertion(stroke.part, rows, made.deviations[low:high])

    def _beyond(self, made: Timed) -> list[int]:
        """The pieces of the path on which a joint leaves its limits: way points on a limit leave no room for a round."""
        first = self.parts[0]
        tree = first.scene.robot(first.stretch.robot).tree
        lower, upper = tree.lower[first.columns] - AT_LIMIT, tree.upper[first.columns] + AT_LIMIT
        found: set[int] = set()
        for k in np.flatnonzero(made.beyond(lower, upper)):
            ends = np.searchsorted(made.passing, made.times[k : k + 2], side="right") - 1
            found.update(range(max(0, int(ends[0])), min(int(ends[1]), len(made.deviations) - 1) + 1))
        return sorted(found)

    def _unproven(self, made: Timed, pieces: Integers, margin: float | None) -> Integers:
        """Those pieces of the path that are not proven for a motion near them; without a margin, in their middle only."""
        asked = asked_of(made.course, self._whose, pieces, -1.0 if margin is None else margin, ON_PATH, NEARNESS)
        chosen, owners, kinds, starts, ends, strays = asked
        proven = kinds != REFUSED
        for owner, part in enumerate(self.parts):
            # A way does without a round for which parts would be divided; curves and strokes keep their shape.
            early = not (owner in self.curves or part.touches or part.stretch.exact)
            for apart in (False, True):
                rows = np.flatnonzero((owners == owner) & (kinds == apart))
                if len(rows):
                    near = starts[rows], ends[rows], strays[rows]
                    proven[rows] = part.proven_near(*near, apart=apart, early=early)
        return np.asarray(chosen[~proven])

    @cached_property
    def _whose(self) -> Whose:
        numbers, strokes = range(len(self.parts)), self._strokes
        whose = [(owner, each) for each in strokes for owner in numbers if self.parts[owner] is each.part]
        rests = [each.rest for _, each in whose]
        touching = [
            self.stroke + self._bulge(owner) + STROKE_TOLERANCE if part.touches else -1.0
            for owner, part in enumerate(self.parts)
        ]
        return Whose(
            self.corners,
            np.array(self.owners, np.int64),
            np.array([owner in self.curves for owner in numbers], np.bool_),
            np.array(touching, np.float64),
            np.array(rests, np.float64).reshape(-1, self.corners.shape[1]),
            np.array([owner for owner, _ in whose], np.int64),
            self._resting,
            self.parts[0].columns.start,
        )

    def _bulge(self, owner: int) -> float:
        """How far the curve that a part is may be from the straight pieces between its corners [rad, L2]."""
        if self.slopes is None or owner not in self.curves:
            return 0.0
        own = np.flatnonzero(np.asarray(self.owners) == owner)
        steps = self.corners[own + 1] - self.corners[own]
        lengths = np.linalg.norm(steps, axis=1)
        # Of a cubic with slopes a, b off its chord the greatest distance is 4/27 of both, or less.
        slopes = self.slopes[own] - (steps / lengths[:, None])[:, None]
        return float((4.0 / 27.0 * lengths * np.linalg.norm(slopes, axis=2).sum(axis=1)).max())

    def _corners_by(self, made: Timed, piece: int) -> list[int]:
        """The inner corners before and after a piece of the path, next to it or at the ends of its curve."""
        after = int(np.searchsorted(made.corners, piece, side="right"))
        before, last = after - 1, len(self.corners) - 1
        if self.curves:
            while before > 0 and self.bends[before] == 0.0:
                before -= 1
            while after < last and self.bends[after] == 0.0:
                after += 1
        return [i for i in (before, after) if 0 < i < last]


def turns(corners: Array) -> Array:
    """The norm (m,) of the difference of the directions before and after each corner; 0 at both ends."""
    steps = np.diff(corners, axis=0)
    units = steps / np.linalg.norm(steps, axis=1)[:, None]
    return np.concatenate([[0.0], np.linalg.norm(np.diff(units, axis=0), axis=1), [0.0]])


def route_of(
    parts: Sequence[MotionPart],
    tolerance: float,
    curves: frozenset[int] = frozenset(),
    finer: Mapping[int, Array] = MappingProxyType({}),
) -> Route:
    """The route through the way points that are needed, with every straight piece proven.

    The parts with the numbers `curves` become splines, which are not proven yet: through their way points, or through
    the samples (m, n) that `finer` has for them.
    """
    columns, path = parts[0].columns, parts[0].stretch.path
    corners: list[Array] = [path[0, columns]]
    owners: list[int] = []
    for number, part in enumerate(parts):
        path = part.stretch.path
        rows = knots_of(part, finer.get(number)) if number in curves else path[_needed(part, tolerance), columns]
        for q in rows:
            if np.linalg.norm(q - corners[-1]) > MOVING:
                corners.append(q)
                owners.append(number)
    corners[-1] = path[-1, columns]  # the end is reached exactly
    found = np.array(corners)
    slopes = slopes_of(found, owners, curves) if curves else None
    return Route(parts, found, tuple(owners), tolerance, curves, slopes)


def _needed(part: MotionPart, tolerance: float) -> list[int]:
    """The way points after the first that are needed, so that every straight piece is proven."""
    path, found = part.stretch.path, list[int]()
    keeps_shape = part.touches or part.stretch.exact
    kept = thinned(path[:, part.columns], 0.0 if keeps_shape else tolerance)
    for a, b in zip(kept, kept[1:], strict=False):
        direct = b == a + 1 or part.proven(path[a], path[b])
        found += [b] if direct else range(a + 1, b + 1)
    return found
