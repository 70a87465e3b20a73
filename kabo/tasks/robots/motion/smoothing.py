"""Smoothing an arm's stretches into one motion without stops between them, with rounded corners and proven anew.

Each stretch keeps the contacts, the constraint and the scene that it was made for: a straight piece and the blends that
reach over it are proven with those of its stretch. Where a body is lifted from another, contact between the two is
permitted on that stroke only; motion that leaves the stroke is proven without it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Keep, Workspace
from kabo.motion import Blended, Trajectory, blended, fastest, thinned
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration
from kabo.tasks.robots.timed_paths import TimedPath

THINNING_SHARE = 0.1  # share of the deviation that may be used by leaving out way points
MAX_BLEND_ROUNDS = 40  # rounds of making blends smaller or larger
MIN_TRIM_SHARE = 1.0 / 16  # share of a trim below which the motion stops at the corner
TRIM_RESOLUTION = 1.0 / 16  # share of a trim: least difference between a proven and a refused one
REVERSAL = 1.99  # norm of the difference of two unit vectors from which the motion turns back on itself
STRAIGHT_TOLERANCE = 1e-9  # rad: paths closer than this to the straight pieces count as straight
MAX_SPLITS = 3  # how often a piece whose proof fails is halved
CHORD_TOLERANCE = 1e-3  # rad: deviation of straight pieces between way points from a blend
WAYPOINT_PERIOD = 0.1  # s between way points, approximately
MIN_WAYPOINT_PERIOD = 0.01  # s between way points, at least; times are whole microseconds
TIME_DECIMALS = 6  # decimals of times [s]


@dataclass(frozen=True)
class MotionPart:
    """A stretch to be smoothed, the scene in which it is proven, and the path of the stage that made it."""

    stretch: Stretch
    scene: TaskScene
    stage: str

    @cached_property
    def _keep(self) -> Keep | None:
        return keep_of(self.scene, self.stretch.robot, self.stretch.constraint)

    @cached_property
    def _apart(self) -> TaskScene:
        """The scene without contacts between bodies, which are permitted where one is lifted from another."""
        pairs = [tuple(sorted(pair)) for pair in self.scene.permitted if not any("." in name for name in pair)]
        return self.scene.forbidding((first, second) for first, second in pairs)

    def proven(self, a: Array, b: Array, *, apart: bool = False) -> bool:
        """Whether a straight segment of joint space is proven collision-free and to keep the constraint.

        Args:
            a, b: the ends of the segment, configurations of the arm.
            apart: whether contacts between bodies, permitted by the stretch, are forbidden here.
        """
        if self._keep is not None and not self._keep.keeps(a, b):
            return False
        scene = self._apart if apart else self.scene
        return self._free(scene.workspace(self.stretch.robot), a, b, MAX_SPLITS)

    def _free(self, workspace: Workspace, a: Array, b: Array, splits: int) -> bool:
        """Whether a segment is proven free; if the proof fails, both halves are tried, up to `splits` times."""
        if workspace.segment_hit(a, b) < 0:
            return True
        middle = (a + b) / 2
        return (
            splits > 0
            and self._free(workspace, a, middle, splits - 1)
            and self._free(workspace, middle, b, splits - 1)
        )


@dataclass(frozen=True)
class TimingLimits:
    """Limits of velocity and acceleration, (n,) each, of the planned joints."""

    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Smoothed:
    """The result of smoothing: timed stretches, and the number of inner corners where the motion still stops."""

    stretches: tuple[Stretch, ...]
    stops: int


def smoothed(parts: Sequence[MotionPart], deviation: float, limits: TimingLimits) -> Smoothed | None:
    """One motion from rest to rest along all parts, which passes each way point within `deviation` [rad, L2].

    The result is None if no such motion could be proven.

    Raises:
        ImportError: toppra is not installed.
    """
    route = _route(parts, THINNING_SHARE * deviation)
    shares = np.ones(len(route.corners))
    shares[route.sharp] = 0.0
    shares = _largest(route, deviation, shares)
    for _ in range(MAX_BLEND_ROUNDS):
        made = route.timed(_rounded(route, deviation, shares), limits)
        if isinstance(made, Smoothed):
            return made
        failed = [i for i in made if shares[i] > 0.0]
        if not failed:
            return None
        shares[failed] = _smaller(shares[failed])
    return None


def _rounded(route: "_Route", deviation: float, shares: Array) -> Blended:
    return blended(route.corners, (1.0 - THINNING_SHARE) * deviation, shares)  # type: ignore[arg-type]


def _smaller(shares: Array) -> Array:
    return np.where(shares > MIN_TRIM_SHARE, 0.5 * shares, 0.0)


def _largest(route: "_Route", deviation: float, shares: Array) -> Array:
    """The largest shares with which all blends are proven, up to `FINE`."""
    shares, proven, refused = shares.copy(), np.zeros_like(shares), np.full(len(shares), np.inf)
    for _ in range(MAX_BLEND_ROUNDS):
        unproven = route.refused(_rounded(route, deviation, shares))
        failed = [i for i in unproven if shares[i] > proven[i]]
        if unproven and not failed:
            break
        if failed:
            refused[failed] = shares[failed]
            shares[failed] = np.where(proven[failed] > 0.0, proven[failed], _smaller(shares[failed]))
            continue
        proven = shares.copy()
        larger = (proven > 0.0) & (refused - proven > TRIM_RESOLUTION) & np.isfinite(refused)
        if not larger.any():
            break
        shares[larger] = 0.5 * (proven + refused)[larger]
    return proven


@dataclass(frozen=True)
class _Route:
    """The corners (m, planned joints) of a motion; piece i, from corner i to corner i + 1, belongs to part `owners[i]`."""

    parts: Sequence[MotionPart]
    corners: Array
    owners: tuple[int, ...]
    hand: Array
    stroke: float  # rad, L2: distance from which the motion has left a stroke on which bodies may touch

    @property
    def sharp(self) -> list[int]:
        """The inner corners at which the motion turns back."""
        ways = np.diff(self.corners, axis=0)
        units = ways / np.linalg.norm(ways, axis=1)[:, None]
        return [i + 1 for i, bend in enumerate(np.linalg.norm(np.diff(units, axis=0), axis=1)) if bend > REVERSAL]

    def whole(self, q: Array) -> Array:
        """The configuration with the gripper's joints added, as plans store it."""
        return np.array(configuration(np.concatenate([q, self.hand])))

    def refused(self, path: Blended) -> list[int]:
        """The inner corners whose blends meet a piece that is not proven; straight pieces are not examined."""
        found: set[int] = set()
        cuts, away = path.deviations
        for low, high, far in zip(cuts, cuts[1:], away, strict=False):
            if far <= STRAIGHT_TOLERANCE:
                continue
            owner = self.owners[int(np.searchsorted(path.places, (low + high) / 2)) - 1]
            bend = float(np.linalg.norm(path.at((low + high) / 2, 2)))
            places = np.linspace(low, high, max(1, int(np.ceil((high - low) / _reach(bend)))) + 1)
            for a, b in self._unproven(path, owner, places):
                found.update(self._corners_by(path, a, b))
        return sorted(found)

    def _unproven(self, path: Blended, owner: int, places: Array) -> list[tuple[float, float]]:
        """The pieces between neighbouring places along a path that are not proven with the part they belong to.

        Where bodies may touch on a stroke, pieces that leave the stroke must be proven without contact.
        """
        part, there = self.parts[owner], path.at(places)
        way = [self.whole(q) for q in there]
        left = np.zeros(len(way), np.bool_)
        if _touches(part.stretch):
            left = np.linalg.norm(there - path.straight(places), axis=1) > self.stroke + STRAIGHT_TOLERANCE
        return [
            (float(places[k]), float(places[k + 1]))
            for k in range(len(way) - 1)
            if not part.proven(way[k], way[k + 1], apart=bool(left[k] or left[k + 1]))
        ]

    def timed(self, path: Blended, limits: TimingLimits) -> Smoothed | list[int]:
        """The stretches along a path, as fast as the limits allow; or the corners next to pieces that are not proven."""
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
            own = np.round(times[chosen], TIME_DECIMALS)
            seconds = tuple(round(float(t - own[0]), TIME_DECIMALS) for t in own)
            part = self.parts[owner]
            waypoints = tuple(map(configuration, way))
            joints = part.scene.robot(part.stretch.robot).planned_joints
            rows = [q[: len(joints)] for q in waypoints]
            timed = TimedPath(seconds, Trajectory.linear(joints, rows, seconds))
            made.append(replace(part.stretch, waypoints=waypoints, timed=timed, stage=part.stage))
        if unproven:
            return sorted({i for low, high in unproven for i in self._corners_by(path, low, high)})
        return Smoothed(tuple(made), len(stops))

    def _corners_by(self, path: Blended, low: float, high: float) -> list[int]:
        """The inner corners whose blends overlap a piece of the path."""
        inner = range(1, len(self.corners) - 1)
        return [i for i in inner if low < path.corner(i) + path.trims[i] and path.corner(i) - path.trims[i] < high]


def _route(parts: Sequence[MotionPart], tolerance: float) -> _Route:
    """The route through the way points that are needed, with every straight piece proven."""
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
    """Whether bodies may touch during a stretch, as where one is lifted; such a stroke keeps its shape."""
    return any(not any("." in name for name in pair) for pair in stretch.permitted)


def _reach(bend: float) -> float:
    """How long a straight piece next to a blend with that second derivative may be."""
    return float(np.sqrt(8.0 * CHORD_TOLERANCE / bend)) if bend > 0.0 else np.inf


def _passed(path: Blended, stops: list[int], borders: list[float], limits: TimingLimits) -> tuple[Array, Array]:
    """The times and places of way points along a path that stops at the corners `stops`."""
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
    """The indices of the grid places that become way points, without the first place."""
    bends = np.linalg.norm(path.at(grid, 2), axis=1)
    borders = [0, *sorted(int(np.argmin(np.abs(grid - s))) for s in needed), len(grid) - 1]
    chosen: list[int] = []
    for first, end in zip(borders, borders[1:], strict=False):
        last = first
        for k in range(first + 1, end):
            too_far = grid[k + 1] - grid[last] > _reach(float(bends[last : k + 2].max()))
            if too_far or times[k + 1] - times[last] > WAYPOINT_PERIOD:
                last = k
                if times[k] - times[first] > MIN_WAYPOINT_PERIOD and times[end] - times[k] > MIN_WAYPOINT_PERIOD:
                    chosen.append(k)
        chosen.append(end)
    return chosen
