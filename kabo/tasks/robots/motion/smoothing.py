"""One motion out of several stretches of an arm: corners rounded, borders passed without stopping, proven anew.

Each stretch keeps the contacts, the constraint and the scene that it was made for: what belongs to a straight piece of
one, blends that reach over it included, is proven by that one. Where a body is lifted from another, they may touch on
the stroke alone: what leaves it is proven without that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Keep, Workspace
from kabo.motion import Blended, blended, fastest, thinned
from kabo.tasks.robots.motion.keeping import keep_of
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration

THIN = 0.1  # share of the deviation that is spent on leaving way points out
ROUNDS = 40  # of making blends that are not proven smaller, and of making them larger again
LEAST = 1.0 / 16  # share of a trim: where less is left, the motion stops at the corner
FINE = 1.0 / 16  # share of a trim: what is proven and what was refused are no nearer to each other
SHARP = 1.99  # norm of the difference of unit vectors: the motion turns back, on the way on which it came
STRAIGHT = 1e-9  # rad: a path that is nearer to the straight pieces is on them
SPLITS = 3  # halvings of a piece whose proof fails
CHORD = 1e-3  # rad: how far straight pieces between way points may pass by a blend
PERIOD = 0.1  # s between way points, about
TICK = 0.01  # s between way points at least: their times are whole microseconds
DECIMALS = 6  # of times


@dataclass(frozen=True)
class Part:
    """A stretch, the scene in which it is proven, and the path of its stage."""

    stretch: Stretch
    scene: TaskScene
    stage: str

    @cached_property
    def _keep(self) -> Keep | None:
        return keep_of(self.scene, self.stretch.robot, self.stretch.constraint)

    @cached_property
    def _apart(self) -> TaskScene:
        """The scene in which bodies may not touch each other, as they may where one is lifted from another."""
        pairs = [tuple(sorted(pair)) for pair in self.scene.permitted if not any("." in name for name in pair)]
        return self.scene.forbidding((first, second) for first, second in pairs)

    def proven(self, a: Array, b: Array, *, apart: bool = False) -> bool:
        """Whether the straight joint segment is proven free and to keep the constraint; if `apart`, without contacts."""
        if self._keep is not None and not self._keep.keeps(a, b):
            return False
        scene = self._apart if apart else self.scene
        return self._free(scene.workspace(self.stretch.robot), a, b, SPLITS)

    def _free(self, workspace: Workspace, a: Array, b: Array, splits: int) -> bool:
        """Whether it is free; a proof that fails by little may succeed in halves."""
        if workspace.segment_hit(a, b) < 0:
            return True
        middle = (a + b) / 2
        return (
            splits > 0
            and self._free(workspace, a, middle, splits - 1)
            and self._free(workspace, middle, b, splits - 1)
        )


@dataclass(frozen=True)
class Limits:
    """Of velocity and acceleration, (n,) for the planned joints."""

    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Smoothed:
    """The stretches with times, and the number of inner corners where the motion still stops."""

    stretches: tuple[Stretch, ...]
    stops: int


def smoothed(parts: Sequence[Part], deviation: float, limits: Limits) -> Smoothed | None:
    """The parts as one motion from rest to rest that passes each way point by `deviation` [rad, L2] or less.

    None if what came out is not proven.

    Raises:
        ImportError: toppra is not installed.
    """
    route = _route(parts, THIN * deviation)
    shares = np.ones(len(route.corners))
    shares[route.sharp] = 0.0
    shares = _largest(route, deviation, shares)
    for _ in range(ROUNDS):
        made = route.timed(_rounded(route, deviation, shares), limits)
        if isinstance(made, Smoothed):
            return made
        failed = [i for i in made if shares[i] > 0.0]
        if not failed:
            return None
        shares[failed] = _smaller(shares[failed])
    return None


def _rounded(route: "_Route", deviation: float, shares: Array) -> Blended:
    return blended(route.corners, (1.0 - THIN) * deviation, shares)  # type: ignore[arg-type]


def _smaller(shares: Array) -> Array:
    return np.where(shares > LEAST, 0.5 * shares, 0.0)


def _largest(route: "_Route", deviation: float, shares: Array) -> Array:
    """Shares with which all blends are proven, each larger than what is proven by no more than `FINE`."""
    shares, proven, refused = shares.copy(), np.zeros_like(shares), np.full(len(shares), np.inf)
    for _ in range(ROUNDS):
        unproven = route.refused(_rounded(route, deviation, shares))
        failed = [i for i in unproven if shares[i] > proven[i]]
        if unproven and not failed:
            break
        if failed:
            refused[failed] = shares[failed]
            shares[failed] = np.where(proven[failed] > 0.0, proven[failed], _smaller(shares[failed]))
            continue
        proven = shares.copy()
        larger = (proven > 0.0) & (refused - proven > FINE) & np.isfinite(refused)
        if not larger.any():
            break
        shares[larger] = 0.5 * (proven + refused)[larger]
    return proven


@dataclass(frozen=True)
class _Route:
    """The corners (m, planned) of a motion; piece i, from corner i to the next, belongs to part `owners[i]`."""

    parts: Sequence[Part]
    corners: Array
    owners: tuple[int, ...]
    hand: Array
    stroke: float  # rad, L2: what is farther from a stroke on which bodies may touch has left it

    @property
    def sharp(self) -> list[int]:
        """The inner corners at which the motion turns back."""
        ways = np.diff(self.corners, axis=0)
        units = ways / np.linalg.norm(ways, axis=1)[:, None]
        return [i + 1 for i, bend in enumerate(np.linalg.norm(np.diff(units, axis=0), axis=1)) if bend > SHARP]

    def whole(self, q: Array) -> Array:
        """The configuration with the gripper's joints, as plans keep it."""
        return np.array(configuration(np.concatenate([q, self.hand])))

    def refused(self, path: Blended) -> list[int]:
        """The inner corners whose blends meet a piece that is not proven; what is on the straight pieces is not asked."""
        found: set[int] = set()
        cuts, away = path.deviations
        for low, high, far in zip(cuts, cuts[1:], away, strict=False):
            if far <= STRAIGHT:
                continue
            owner = self.owners[int(np.searchsorted(path.places, (low + high) / 2)) - 1]
            bend = float(np.linalg.norm(path.at((low + high) / 2, 2)))
            places = np.linspace(low, high, max(1, int(np.ceil((high - low) / _reach(bend)))) + 1)
            for a, b in self._unproven(path, owner, places):
                found.update(self._corners_by(path, a, b))
        return sorted(found)

    def _unproven(self, path: Blended, owner: int, places: Array) -> list[tuple[float, float]]:
        """The pieces between neighbours of places along a path that are not proven by the part to which they belong.

        Where bodies may touch, what leaves the stroke must be proven without that.
        """
        part, there = self.parts[owner], path.at(places)
        way = [self.whole(q) for q in there]
        left = np.zeros(len(way), np.bool_)
        if _touches(part.stretch):
            left = np.linalg.norm(there - path.straight(places), axis=1) > self.stroke + STRAIGHT
        return [
            (float(places[k]), float(places[k + 1]))
            for k in range(len(way) - 1)
            if not part.proven(way[k], way[k + 1], apart=bool(left[k] or left[k + 1]))
        ]

    def timed(self, path: Blended, limits: Limits) -> Smoothed | list[int]:
        """The stretches along a path, as fast as the limits allow; the corners by pieces that are not proven."""
        stops = [i for i in range(1, len(self.corners) - 1) if path.trims[i] == 0.0]
        borders = [i for i in range(1, len(self.corners) - 1) if self.owners[i] != self.owners[i - 1]]
        times, places = _passed(
            path, [0, *stops, len(self.corners) - 1], [path.corner(i) for i in borders], limits
        )
        cuts = [0.0, *(path.corner(i) for i in borders), path.length]
        made, order = [], list(dict.fromkeys(self.owners))
        unproven: list[tuple[float, float]] = []
        for owner, low, high in zip(order, cuts, cuts[1:], strict=False):
            chosen = (places >= low - 1e-12) & (places <= high + 1e-12)
            unproven += self._unproven(path, owner, places[chosen])
            way = [self.whole(q) for q in path.at(places[chosen])]
            own = np.round(times[chosen], DECIMALS)
            seconds = tuple(round(float(t - own[0]), DECIMALS) for t in own)
            part = self.parts[owner]
            waypoints = tuple(map(configuration, way))
            made.append(replace(part.stretch, waypoints=waypoints, times=seconds, stage=part.stage))
        if unproven:
            return sorted({i for low, high in unproven for i in self._corners_by(path, low, high)})
        return Smoothed(tuple(made), len(stops))

    def _corners_by(self, path: Blended, low: float, high: float) -> list[int]:
        """The inner corners whose blends a piece of the path meets."""
        inner = range(1, len(self.corners) - 1)
        return [i for i in inner if low < path.corner(i) + path.trims[i] and path.corner(i) - path.trims[i] < high]


def _route(parts: Sequence[Part], tolerance: float) -> _Route:
    """The way points that are needed, each straight piece proven."""
    n = parts[0].scene.robot(parts[0].stretch.robot).planned
    corners: list[Array] = [parts[0].stretch.path[0]]
    owners: list[int] = []
    for number, part in enumerate(parts):
        path = part.stretch.path
        kept = thinned(path[:, :n], 0.0 if _touches(part.stretch) else tolerance)
        for a, b in zip(kept, kept[1:], strict=False):
            direct = b == a + 1 or part.proven(path[a], path[b])
            for k in (b,) if direct else range(a + 1, b + 1):
                if np.linalg.norm(path[k, :n] - corners[-1][:n]) > 1e-6:
                    corners.append(path[k])
                    owners.append(number)
    return _Route(parts, np.array(corners)[:, :n], tuple(owners), parts[0].stretch.path[0, n:], tolerance)


def _touches(stretch: Stretch) -> bool:
    """Whether a body may touch another one meanwhile, as where it is lifted: that stroke stays as it is."""
    return any(not any("." in name for name in pair) for pair in stretch.permitted)


def _reach(bend: float) -> float:
    """How long a straight piece may be beside a blend of that second derivative."""
    return float(np.sqrt(8.0 * CHORD / bend)) if bend > 0.0 else np.inf


def _passed(path: Blended, stops: list[int], borders: list[float], limits: Limits) -> tuple[Array, Array]:
    """Times and places of way points along a path that rests at the corners `stops`."""
    times, places = [np.zeros(1)], [np.zeros(1)]
    for first, last in zip(stops, stops[1:], strict=False):
        low, high = path.corner(first), path.corner(last)
        between = Blended(path.corners[first : last + 1], path.trims[first : last + 1])
        inner = [s - low for s in borders if low < s < high]
        grid, passed = fastest(between, limits.velocity, limits.acceleration, through=inner)
        chosen = _chosen(between, grid, passed, inner)
        times.append(times[-1][-1] + passed[chosen])
        places.append(low + grid[chosen])
    return np.concatenate(times), np.concatenate(places)


def _chosen(path: Blended, grid: Array, times: Array, needed: Sequence[float]) -> list[int]:
    """The numbers of the places on a grid that become way points, but for the first."""
    bends = np.linalg.norm(path.at(grid, 2), axis=1)
    borders = [0, *sorted(int(np.argmin(np.abs(grid - s))) for s in needed), len(grid) - 1]
    chosen: list[int] = []
    for first, end in zip(borders, borders[1:], strict=False):
        last = first
        for k in range(first + 1, end):
            too_far = grid[k + 1] - grid[last] > _reach(float(bends[last : k + 2].max()))
            if too_far or times[k + 1] - times[last] > PERIOD:
                last = k
                if times[k] - times[first] > TICK and times[end] - times[k] > TICK:
                    chosen.append(k)
        chosen.append(end)
    return chosen
