"""Whether two bodies stay apart along a whole path: conservative advancement, each pair at its own pace.

A path is straight between way points. Along it a pair approaches by no more than its bounded relative motion, in
metres; a distance d measured at one place therefore proves the path for d metres to both sides. Balls settle most
pairs at once, hulls most of the rest, meshes what is left. A pair is free only if every stretch is proven.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.surfaces import Surface, encloses, hull_depth, hull_gap, mesh_distance

Poses = Mapping[str, Array]  # robot that moves -> the poses of its joints (J, 4, 4)
Stretches = list[tuple[float, float]]  # from, to: metres of a pair's own motion

LEAST = 1e-7  # [m] bodies nearer than this count as touching
VANISHING = 1e-6  # a step smaller than this share of a pair's whole motion decides nothing
SPACING = 0.04  # [m] about how far bodies move between the places where balls are compared
STATIONS = 400  # of these places, at most


@dataclass(frozen=True)
class Thing:
    """A body at its place: in the world, or on a robot that moves."""

    name: str
    surface: Surface
    world_T: Array | None = None  # (4, 4) if it stands
    mount: Mount | None = None  # if it hangs on a robot that moves

    @property
    def lever(self) -> float:
        """How far its points are at most from the joint that carries it [m]."""
        assert self.mount is not None
        placed = self.mount.joint_T_body
        return float(np.linalg.norm(placed[:3, :3] @ self.surface.centre + placed[:3, 3])) + self.surface.radius

    def pose(self, joint_poses: Poses) -> Array:
        """Its pose in the world, given those of the robots' joints."""
        if self.mount is None:
            assert self.world_T is not None
            return self.world_T
        result: Array = joint_poses[self.mount.robot][self.mount.joint] @ self.mount.joint_T_body
        return result


class Path:
    """A path of a robot, or of several that move together: configurations (m, n) of all their joints, times (m,).

    The columns are the joints of one robot after the other, in the order of `arms`.
    """

    def __init__(self, arms: Arm | Sequence[Arm], configurations: Array, times: Sequence[float] | Array) -> None:
        together = (arms,) if isinstance(arms, Arm) else tuple(arms)
        self.arms = {arm.robot.name: arm for arm in together}
        ends = np.cumsum([0, *(len(arm.robot.joint_names) for arm in together)])
        self.columns = {name: slice(ends[k], ends[k + 1]) for k, name in enumerate(self.arms)}
        self.configurations, self.times = configurations, np.asarray(times)
        self.steps = np.abs(np.diff(configurations, axis=0))  # (m - 1, n)

    def at(self, piece: int, share: float) -> Array:
        """The configuration in a piece, `share` between 0 and 1 of the way."""
        first, last = self.configurations[piece], self.configurations[piece + 1]
        return np.asarray((1.0 - share) * first + share * last)

    def time(self, piece: int, share: float) -> float:
        """When the robots are there [s]."""
        return float((1.0 - share) * self.times[piece] + share * self.times[piece + 1])

    def poses(self, piece: int, share: float) -> Poses:
        """The poses of the robots' joints there."""
        q = self.at(piece, share)
        return {name: arm.joint_poses(q[self.columns[name]].tolist()) for name, arm in self.arms.items()}


@dataclass(frozen=True)
class Contact:
    """Where a pair is not proven apart: `distance` is None where it touches, else too little to decide."""

    time: float
    distance: float | None
    depth: float
    inside: bool = False


@dataclass(frozen=True)
class Proof:
    """What became of one pair: a contact or None, the least distance that was measured and when."""

    contact: Contact | None = None
    least: float = np.inf
    time: float = 0.0
    distances: int = 0


class Pair:
    """Two bodies along a path; `bound` (n,) says how far they move against each other by each coordinate."""

    def __init__(self, path: Path, first: Thing, second: Thing, bound: Array) -> None:
        self.path, self.first, self.second = path, first, second
        self.ends = np.concatenate([[0.0], np.cumsum(path.steps @ bound)])  # metres at every way point

    @property
    def length(self) -> float:
        """How far the two move relative to each other, at most [m]."""
        return float(self.ends[-1])

    def place(self, s: float) -> tuple[int, float]:
        """The piece and the share in it where the pair has moved `s` metres."""
        piece = min(int(np.searchsorted(self.ends, s, side="right")) - 1, len(self.ends) - 2)
        piece = max(piece, 0)
        width = self.ends[piece + 1] - self.ends[piece]
        return piece, float(min(1.0, max(0.0, (s - self.ends[piece]) / width))) if width > 0 else 0.0

    def poses(self, s: float) -> tuple[Array, Array]:
        """The poses of both bodies where the pair has moved `s` metres."""
        joints = self.path.poses(*self.place(s))
        return self.first.pose(joints), self.second.pose(joints)

    def contained(self, shift: Array | None = None) -> bool:
        """Whether one body begins inside the other, the first moved by `shift` (3,) in the world."""
        a, b = self.poses(0.0)
        if shift is not None:
            a = a.copy()
            a[:3, 3] += shift
        return encloses(self.first.surface, a, self.second.surface, b) or encloses(
            self.second.surface, b, self.first.surface, a
        )

    def advance(self, stretches: Stretches, shift: Array | None = None) -> Proof:
        """Proves stretches [from, to] in metres of the pair's own motion.

        Args:
            stretches: what is left to prove.
            shift: moves the first body by this vector in the world before distances are taken.
        """
        least, when, count = np.inf, 0.0, 0
        stack = list(reversed(stretches))
        shortest = VANISHING * self.length
        while stack:
            start, end = stack.pop()
            middle, half = (start + end) / 2, (end - start) / 2
            a, b = self.poses(middle)
            if shift is not None:
                a = a.copy()
                a[:3, 3] += shift
            distance = hull_gap(self.first.surface, a, self.second.surface, b)
            if distance <= half and distance < 0.5 * half + LEAST or distance <= LEAST:
                distance = max(distance, mesh_distance(self.first.surface, a, self.second.surface, b))
            count += 1
            if distance < least:
                least, when = distance, self.path.time(*self.place(middle))
            if distance <= LEAST:
                depth = hull_depth(self.first.surface, a, self.second.surface, b)
                return Proof(Contact(when, None, depth), least, when, count)
            if distance > half:
                continue
            if distance < shortest:
                return Proof(Contact(when, distance, 0.0), least, when, count)
            # The later half first onto the stack: contacts are then found in the order of time.
            stack.append((middle + distance, end))
            stack.append((start, middle - distance))
        return Proof(None, least, when, count)


def weights(path: Path, first: Thing, second: Thing) -> Array:
    """Bounds (n,) of the relative motion by each coordinate: only joints that move one of the two count."""
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


def open_stretches(path: Path, couples: Sequence[tuple[Thing, Thing]]) -> tuple[int, list[tuple[Pair, Stretches]]]:
    """How many couples move against each other at all, and the stretches of these that balls do not prove apart.

    The balls are compared at places about `SPACING` of motion apart; what they prove to both sides is taken away.
    """
    bounds = np.array([weights(path, *couple) for couple in couples]).reshape(len(couples), -1)
    moving = [int(i) for i in np.flatnonzero((path.steps @ bounds.T).sum(axis=0) > 0.0)]
    if not moving:
        return 0, []
    places = stations(path, path.steps @ bounds.max(axis=0))
    apart = _apart(path, [couples[i] for i in moving], places)  # (P, stations)
    travelled = np.concatenate([np.zeros((1, path.steps.shape[1])), np.cumsum(path.steps, axis=0)])
    passed = np.array([travelled[k] + share * path.steps[k] for k, share in places])
    s = bounds[moving] @ passed.T  # (P, stations) metres of the couple's own motion
    joined = (s[:, 1:] - s[:, :-1] <= apart[:, 1:] + apart[:, :-1]).all(axis=1)
    settled = joined & (apart > 0.0).all(axis=1)
    result = []
    for row in np.flatnonzero(~settled):
        pair = Pair(path, *couples[moving[row]], bounds[moving[row]])
        stretches = _uncovered(s[row], apart[row], pair.length)
        if stretches:
            result.append((pair, stretches))
    return len(moving), result


def stations(path: Path, lengths: Array) -> list[tuple[int, float]]:
    """Places along a path, every way point among them, about `SPACING` apart by the lengths (m - 1,) of its pieces."""
    spacing = max(SPACING, float(lengths.sum()) / STATIONS)
    result: list[tuple[int, float]] = []
    for piece, length in enumerate(lengths):
        count = max(1, int(np.ceil(length / spacing)))
        result.extend((piece, k / count) for k in range(count))
    return [*result, (len(lengths) - 1, 1.0)]


def _apart(path: Path, couples: Sequence[tuple[Thing, Thing]], places: Sequence[tuple[int, float]]) -> Array:
    """The distances (P, stations) of the balls around the two of each couple."""
    at = [path.poses(*place) for place in places]
    joints = {name: np.array([poses[name] for poses in at]) for name in path.arms}  # (stations, J, 4, 4) each
    things = {id(thing): thing for couple in couples for thing in couple}
    row = {key: i for i, key in enumerate(things)}
    centres = np.array([_centres(thing, joints, len(at)) for thing in things.values()])
    radii = np.array([thing.surface.radius for thing in things.values()])
    first, second = (np.array([row[id(couple[k])] for couple in couples]) for k in (0, 1))
    distances = np.linalg.norm(centres[first] - centres[second], axis=2)
    apart: Array = distances - (radii[first] + radii[second] + 1e-9)[:, None]
    return apart


def _centres(thing: Thing, joints: Poses, stations: int) -> Array:
    """Where the middle of a body is at every station (stations, 3)."""
    if thing.mount is None:
        poses = thing.pose({})[None]
    else:
        poses = joints[thing.mount.robot][:, thing.mount.joint] @ thing.mount.joint_T_body
    centres = poses[:, :3, :3] @ thing.surface.centre + poses[:, :3, 3]
    return np.asarray(np.broadcast_to(centres, (stations, 3)))


def _uncovered(s: Array, apart: Array, length: float) -> Stretches:
    """What of [0, length] no ball (s - apart, s + apart) covers."""
    result: Stretches = []
    reached = 0.0  # everything before is covered
    for centre, radius in zip(s, apart, strict=True):
        if radius <= 0.0:
            continue
        if centre - radius > reached:
            result.append((reached, float(centre - radius)))
        reached = max(reached, float(centre + radius))
    if reached < length or not (apart > 0).any():
        result.append((reached, length))
    return result
