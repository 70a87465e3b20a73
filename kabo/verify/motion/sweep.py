"""Proves that two bodies stay apart along a whole path, by conservative advancement for each pair of bodies.

A path is straight between way points. Along it the distance of a pair shrinks by no more than the bound of its relative
motion, in metres; a distance d measured at one place therefore proves the path for d metres to both sides. Balls decide
most pairs, hulls most of the rest, meshes the others. A pair is free only if the whole path is proven.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.surfaces import Surface, encloses, hull_depth, hull_gap, mesh_distance
from kabo.verify.motion.trajectories.curves import Curve

Poses = Mapping[str, Array]  # robot that moves -> the poses of its joints (J, 4, 4)
Intervals = list[tuple[float, float]]  # from, to, in metres of a pair's relative motion

CONTACT_DISTANCE = 1e-7  # [m] bodies nearer than this count as touching
MIN_STEP_SHARE = 1e-6  # of a pair's whole motion: a smaller step is given up as undecided
STATION_SPACING = 0.04  # [m] of motion, about, between the places where balls are compared
HULLS_TELL = 1e-4  # [m]: convex bodies farther apart are as far apart as their hulls
MAX_STATIONS = 400  # such places, at most


@dataclass(frozen=True)
class SweptBody:
    """A body with its pose in the world, or its mount on a robot that moves."""

    name: str
    surface: Surface
    world_T: Array | None = None  # (4, 4) if it stands
    mount: Mount | None = None  # if it hangs on a robot that moves

    @property
    def lever(self) -> float:
        """The greatest distance of any point of the body from the joint that carries it [m]."""
        assert self.mount is not None
        placed = self.mount.joint_T_body
        return float(np.linalg.norm(placed[:3, :3] @ self.surface.centre + placed[:3, 3])) + self.surface.radius

    def pose(self, joint_poses: Poses) -> Array:
        """The body's pose in the world, given the poses of the robots' joints."""
        if self.mount is None:
            assert self.world_T is not None
            return self.world_T
        result: Array = joint_poses[self.mount.robot][self.mount.joint] @ self.mount.joint_T_body
        return result


class Path:
    """A path of a robot, or of several that move together: configurations (m, n) of all their joints, times (m,).

    The columns are the joints of one robot after the other, in the order of `arms`. While they follow a piece of the
    path, no joint is ever farther from it than its deviation (m - 1, n) [rad or m]; None: they follow it exactly.
    Each robot by itself is no farther from its own part of the path than `alone` (m - 1, n); None: than `deviations`.
    `curves` are the trajectories of some columns. `in_time`: way points are where the trajectories are at
    `times`; else a trajectory is somewhere on the piece between two times.
    """

    def __init__(
        self,
        arms: Arm | Sequence[Arm],
        configurations: Array,
        times: Sequence[float] | Array,
        deviations: Array | None = None,
        curves: Sequence[tuple[tuple[int, ...], Curve]] = (),
        *,
        alone: Array | None = None,
        in_time: bool = False,
    ) -> None:
        together = (arms,) if isinstance(arms, Arm) else tuple(arms)
        self.arms = {arm.robot.name: arm for arm in together}
        ends = np.cumsum([0, *(len(arm.robot.joint_names) for arm in together)])
        self.columns = {name: slice(ends[k], ends[k + 1]) for k, name in enumerate(self.arms)}
        self.configurations, self.times = configurations, np.asarray(times)
        self.steps = np.abs(np.diff(configurations, axis=0))  # (m - 1, n)
        none = np.zeros_like(self.steps)
        self.deviations = none if deviations is None else deviations
        self.alone = self.deviations if alone is None else alone
        self.exact = not (self.deviations.any() or self.alone.any())
        self.curves, self.in_time = tuple(curves), in_time

    def strays(self, bounds: Array) -> Array:
        """How far the motion may bring pairs of bodies from the path on each piece (m - 1, P) [m].

        Where only one robot moves one body relative to the other, what the others do at the same time does not count.

        Args:
            bounds: the greatest relative motion of each pair per unit of each joint (P, n).
        """
        movers = sum(bounds[:, own].any(axis=1).astype(int) for own in self.columns.values())
        return np.asarray(np.where(movers > 1, self.deviations @ bounds.T, self.alone @ bounds.T))

    def at(self, piece: int, share: float) -> Array:
        """The configuration at a place in a piece; `share` goes from 0 to 1."""
        first, last = self.configurations[piece], self.configurations[piece + 1]
        return np.asarray((1.0 - share) * first + share * last)

    def time(self, piece: int, share: float) -> float:
        """The time when the robots are at a place in a piece [s]."""
        return float((1.0 - share) * self.times[piece] + share * self.times[piece + 1])

    def poses(self, piece: int, share: float) -> Poses:
        """The poses of the robots' joints at a place in a piece."""
        q = self.at(piece, share)
        return {name: arm.joint_poses(q[self.columns[name]].tolist()) for name, arm in self.arms.items()}


@dataclass(frozen=True)
class Contact:
    """A place where a pair is not proven apart; `distance` is None if they touch, else too small to decide.

    `stray` is how much nearer than on the path the bodies may be, as their motion deviates from it [m].
    """

    time: float
    distance: float | None
    depth: float
    inside: bool = False
    stray: float = 0.0


@dataclass(frozen=True)
class Proof:
    """The result for one pair: a contact or None, the least distance that was measured, and when.

    `least` is measured between meshes if it is less than `below`; if not, the bodies are nowhere nearer than `below`.
    """

    contact: Contact | None = None
    least: float = np.inf
    time: float = 0.0
    distances: int = 0
    below: float = np.inf

    def tells(self, below: float) -> bool:
        """Whether it says how near the bodies come, if that is nearer than `below` [m]."""
        return self.least < self.below or below <= self.below


class Pair:
    """Two bodies along a path; `bound` (n,) is their greatest relative motion per unit of each joint."""

    def __init__(self, path: Path, first: SweptBody, second: SweptBody, bound: Array) -> None:
        self.path, self.first, self.second = path, first, second
        self.ends = np.concatenate([[0.0], np.cumsum(path.steps @ bound)])  # metres at every way point
        self.strays = path.strays(bound[None])[:, 0]  # (m - 1,) [m]

    def stray(self, start: float, end: float) -> float:
        """The most by which the bodies may be nearer than on the path, from `start` to `end` metres of motion [m]."""
        first = int(np.searchsorted(self.ends, start, side="left")) - 1
        last = int(np.searchsorted(self.ends, end, side="right"))
        return float(self.strays[max(0, first) : max(1, last)].max())

    @property
    def length(self) -> float:
        """An upper bound of the relative motion of the two bodies along the whole path [m]."""
        return float(self.ends[-1])

    def place(self, s: float) -> tuple[int, float]:
        """The piece, and the share of this piece, at which the bound of the relative motion reaches `s` metres."""
        piece = min(int(np.searchsorted(self.ends, s, side="right")) - 1, len(self.ends) - 2)
        piece = max(piece, 0)
        width = self.ends[piece + 1] - self.ends[piece]
        return piece, float(min(1.0, max(0.0, (s - self.ends[piece]) / width))) if width > 0 else 0.0

    def poses(self, s: float, shift: Array | None = None) -> tuple[Array, Array]:
        """The poses of both bodies where the bound of their relative motion reaches `s` metres.

        `shift`: a vector (3,) in the world by which the first body is shifted.
        """
        joints = self.path.poses(*self.place(s))
        first, second = self.first.pose(joints), self.second.pose(joints)
        if shift is not None:
            first = first.copy()
            first[:3, 3] += shift
        return first, second

    def contained(self, shift: Array | None = None) -> bool:
        """Whether one body begins inside the other when the first is shifted by `shift` (3,) in the world."""
        a, b = self.poses(0.0, shift)
        return encloses(self.first.surface, a, self.second.surface, b) or encloses(
            self.second.surface, b, self.first.surface, a
        )

    def advance(self, intervals: Intervals, shift: Array | None = None, below: float = np.inf) -> Proof:
        """Tries to prove that the pair stays apart on the given intervals of the path.

        Args:
            intervals: the start and end of each interval, in metres of the pair's relative motion.
            shift: a vector (3,) in the world by which the first body is shifted before distances are measured.
            below: how near bodies come is of interest only where it is less than this [m].
        """
        least, when, count = np.inf, 0.0, 0
        stack = list(reversed(intervals))
        shortest, exact = MIN_STEP_SHARE * self.length, not self.strays.any()
        convex = self.first.surface.is_convex and self.second.surface.is_convex
        while stack:
            start, end = stack.pop()
            middle, half = (start + end) / 2, (end - start) / 2
            stray = 0.0 if exact else self.stray(start, end)
            a, b = self.poses(middle, shift)
            distance = hull_gap(self.first.surface, a, self.second.surface, b)
            left = distance - stray
            helps = left <= half and left < 0.5 * half + CONTACT_DISTANCE or left <= CONTACT_DISTANCE
            helps = helps and not (convex and distance > HULLS_TELL)
            if helps or distance < min(least, below):  # hulls prove, only meshes say how near the bodies come
                distance = max(distance, mesh_distance(self.first.surface, a, self.second.surface, b))
            count += 1
            if distance < least:
                least, when = distance, self.path.time(*self.place(middle))
            if distance <= CONTACT_DISTANCE:
                depth = hull_depth(self.first.surface, a, self.second.surface, b)
                return Proof(Contact(when, None, depth), least, when, count, below)
            left = distance - stray
            if left > half:
                continue
            if left < shortest or left <= 0.0:
                if exact or half <= shortest:
                    time = self.path.time(*self.place(middle))
                    return Proof(Contact(time, distance, 0.0, stray=stray), least, when, count, below)
                left = 0.0  # other pieces of the path may have a smaller deviation
            # The later half goes onto the stack first, so that contacts are found in the order of time.
            stack.append((middle + left, end))
            stack.append((start, middle - left))
        return Proof(None, least, when, count, below)


def weights(path: Path, first: SweptBody, second: SweptBody) -> Array:
    """The greatest relative motion of two bodies per unit of each joint (n,); 0 if the joint moves both bodies."""
    total = np.zeros(path.configurations.shape[1])
    for thing, other in ((first, second), (second, first)):
        if thing.mount is None:
            continue
        arm = path.arms[thing.mount.robot]
        joints = arm.chains[thing.mount.joint]
        if other.mount is not None and other.mount.robot == thing.mount.robot:
            joints = joints - arm.chains[other.mount.joint]
        if joints:
            total[path.columns[thing.mount.robot]] += arm.reach(thing.mount.joint, thing.lever, joints)
    return total


def open_intervals(
    path: Path, pairs: Sequence[tuple[SweptBody, SweptBody]]
) -> tuple[int, list[tuple[Pair, Intervals]]]:
    """The number of pairs with relative motion, and the pairs and intervals that balls do not prove free.

    Balls are compared at places about `STATION_SPACING` apart; the intervals around the places that they prove
    free are removed.
    """
    bounds = np.array([weights(path, *pair) for pair in pairs]).reshape(len(pairs), path.steps.shape[1])
    travel = path.steps @ bounds.T if path.exact else path.steps @ bounds.T + path.strays(bounds)
    moving = [int(i) for i in np.flatnonzero(travel.sum(axis=0) > 0.0)]
    if not moving:
        return 0, []
    places = stations(path, path.steps @ bounds.max(axis=0))
    apart = _apart(path, [pairs[i] for i in moving], places)  # (P, stations)
    if not path.exact:
        apart = apart - path.strays(bounds[moving]).max(axis=0)[:, None]
    travelled = np.concatenate([np.zeros((1, path.steps.shape[1])), np.cumsum(path.steps, axis=0)])
    passed = np.array([travelled[k] + share * path.steps[k] for k, share in places])
    s = bounds[moving] @ passed.T
    joined = (s[:, 1:] - s[:, :-1] <= apart[:, 1:] + apart[:, :-1]).all(axis=1)
    settled = joined & (apart > 0.0).all(axis=1)
    result = []
    for row in np.flatnonzero(~settled):
        pair = Pair(path, *pairs[moving[row]], bounds[moving[row]])
        intervals = _uncovered(s[row], apart[row], pair.length)
        if intervals:
            result.append((pair, intervals))
    return len(moving), result


def stations(path: Path, lengths: Array) -> list[tuple[int, float]]:
    """Every way point, and places between them about `STATION_SPACING` apart, given lengths (m - 1,) of pieces."""
    spacing = max(STATION_SPACING, float(lengths.sum()) / MAX_STATIONS)
    result: list[tuple[int, float]] = []
    for piece, length in enumerate(lengths):
        count = max(1, int(np.ceil(length / spacing)))
        result.extend((piece, k / count) for k in range(count))
    return [*result, (len(lengths) - 1, 1.0)]


def _apart(path: Path, pairs: Sequence[tuple[SweptBody, SweptBody]], places: Sequence[tuple[int, float]]) -> Array:
    """The distances (P, stations) of the balls around the two bodies of each pair."""
    at = [path.poses(*place) for place in places]
    joints = {name: np.array([poses[name] for poses in at]) for name in path.arms}  # (stations, J, 4, 4) each
    things = {id(thing): thing for pair in pairs for thing in pair}
    row = {key: i for i, key in enumerate(things)}
    centres = np.array([_centres(thing, joints, len(at)) for thing in things.values()])
    radii = np.array([thing.surface.radius for thing in things.values()])
    first, second = (np.array([row[id(pair[k])] for pair in pairs]) for k in (0, 1))
    distances = np.linalg.norm(centres[first] - centres[second], axis=2)
    apart: Array = distances - (radii[first] + radii[second] + 1e-9)[:, None]
    return apart


def _centres(thing: SweptBody, joints: Poses, stations: int) -> Array:
    """The centre of a body's ball at every station (stations, 3)."""
    own = thing.mount
    poses = thing.pose({})[None] if own is None else joints[own.robot][:, own.joint] @ own.joint_T_body
    centres = poses[:, :3, :3] @ thing.surface.centre + poses[:, :3, 3]
    return np.asarray(np.broadcast_to(centres, (stations, 3)))


def _uncovered(s: Array, apart: Array, length: float) -> Intervals:
    """The intervals of [0, length] that no interval (s - apart, s + apart) covers."""
    result: Intervals = []
    reached = 0.0  # all before this is covered
    for centre, radius in zip(s, apart, strict=True):
        if radius <= 0.0:
            continue
        if centre - radius > reached:
            result.append((reached, float(centre - radius)))
        reached = max(reached, float(centre + radius))
    if reached < length or not (apart > 0).any():
        result.append((reached, length))
    return result
