"""One motion out of several stretches of an arm: corners rounded, borders passed without stopping, proven anew.

Each stretch keeps the contacts, the constraint and the scene that it was made for: a corner between two of them is
rounded by a blend whose first half belongs to the one and whose second half belongs to the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from kabo.geometry_server import Keep
from kabo.motion import Blended, blended, fastest, thinned
from kabo.tasks.robots.keeping import keep_of
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration

Array = npt.NDArray[np.float64]

THIN = 0.1  # share of the deviation that is spent on leaving way points out
ROUNDS = 30  # of making blends that are not proven smaller
LEAST = 1.0 / 16  # share of the deviation: where less is left, the motion stops at the corner
SHARP = 1.9  # norm of the difference of unit vectors: the motion turns back, which no blend can do
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

    def proven(self, a: Array, b: Array) -> bool:
        """Whether the straight joint segment is proven free and to keep the constraint."""
        return (self._keep is None or self._keep.keeps(a, b)) and self._free(a, b, SPLITS)

    def _free(self, a: Array, b: Array, splits: int) -> bool:
        """Whether it is free; a proof that fails by little may succeed in halves."""
        if self.scene.workspace(self.stretch.robot).segment_hit(a, b) < 0:
            return True
        middle = (a + b) / 2
        return splits > 0 and self._free(a, middle, splits - 1) and self._free(middle, b, splits - 1)


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
    for _ in range(ROUNDS):
        path = blended(route.corners, (1.0 - THIN) * deviation, shares)
        failed = [i for i in range(1, len(shares) - 1) if shares[i] > 0.0 and not route.blend_proven(path, i)]
        if not failed:
            made = route.timed(path, limits)
            if isinstance(made, Smoothed):
                return made
            failed = [i for i in made if shares[i] > 0.0]
            if not failed:
                return None
        shares[failed] = np.where(shares[failed] > LEAST, 0.5 * shares[failed], 0.0)
    return None


@dataclass(frozen=True)
class _Route:
    """The corners (m, planned) of a motion; piece i, from corner i to the next, belongs to part `owners[i]`."""

    parts: Sequence[Part]
    corners: Array
    owners: tuple[int, ...]
    hand: Array

    @property
    def sharp(self) -> list[int]:
        """The inner corners at which the motion turns back."""
        ways = np.diff(self.corners, axis=0)
        units = ways / np.linalg.norm(ways, axis=1)[:, None]
        return [i + 1 for i, bend in enumerate(np.linalg.norm(np.diff(units, axis=0), axis=1)) if bend > SHARP]

    def whole(self, q: Array) -> Array:
        """The configuration with the gripper's joints, as plans keep it."""
        return np.array(configuration(np.concatenate([q, self.hand])))

    def blend_proven(self, path: Blended, corner: int) -> bool:
        """Whether each half of a blend is proven by the part to which it belongs."""
        middle, trim = path.corner(corner), path.trims[corner]
        for owner, (low, high) in (
            (self.owners[corner - 1], (middle - trim, middle)),
            (self.owners[corner], (middle, middle + trim)),
        ):
            bend = float(np.linalg.norm(path.at(middle, 2)))
            pieces = max(1, int(np.ceil((high - low) / _reach(bend))))
            way = [self.whole(q) for q in path.at(np.linspace(low, high, pieces + 1))]
            if not all(self.parts[owner].proven(a, b) for a, b in zip(way, way[1:], strict=False)):
                return False
        return True

    def timed(self, path: Blended, limits: Limits) -> Smoothed | list[int]:
        """The stretches along a path, as fast as the limits allow; the corners by a piece that is not proven."""
        stops = [i for i in range(1, len(self.corners) - 1) if path.trims[i] == 0.0]
        borders = [i for i in range(1, len(self.corners) - 1) if self.owners[i] != self.owners[i - 1]]
        times, places = _passed(
            path, [0, *stops, len(self.corners) - 1], [path.corner(i) for i in borders], limits
        )
        cuts = [0.0, *(path.corner(i) for i in borders), path.length]
        made, order = [], list(dict.fromkeys(self.owners))
        for owner, low, high in zip(order, cuts, cuts[1:], strict=False):
            chosen = (places >= low - 1e-12) & (places <= high + 1e-12)
            way = [self.whole(q) for q in path.at(places[chosen])]
            for k, (a, b) in enumerate(zip(way, way[1:], strict=False)):
                if not self.parts[owner].proven(a, b):
                    return self._corners_by(path, *places[chosen][k : k + 2])
            own = np.round(times[chosen], DECIMALS)
            seconds = tuple(round(float(t - own[0]), DECIMALS) for t in own)
            part = self.parts[owner]
            waypoints = tuple(map(configuration, way))
            made.append(replace(part.stretch, waypoints=waypoints, times=seconds, stage=part.stage))
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
    return _Route(parts, np.array(corners)[:, :n], tuple(owners), parts[0].stretch.path[0, n:])


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
