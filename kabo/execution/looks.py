"""Poses that are seen with noise are averaged, over as many looks as it takes to tell whether a proof covers them.

The mean of n looks at a body that stands, or is held, errs by at most z σ / √n, but for one case in a thousand. As soon as
the body is within its margin, or beyond it, on both sides of this error, no more looks are needed: how many there are is
decided by noise and margin, and bounded.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import ceil, sqrt

import numpy as np

from kabo.arrays import Array
from kabo.execution.displacements import Displacement, displacement
from kabo.given import require_number

SURE = 4.033  # lengths of three normal numbers exceed so many standard deviations once in a thousand times
MOST_LOOKS = 100  # at a body, until it counts as what it seems to be
MOVED = 6.0  # standard deviations between the mean and that of the last looks, beyond which a body was moved since
LAST_LOOKS = (2, 4, 8)
OF_THEM = (
    0.25  # share of their mean by which each of the last looks is beside the mean of all, if the body was moved
)


@dataclass(frozen=True)
class PoseNoise:
    """Standard deviations of a look at a body: along each axis [m], and about each axis [rad]."""

    position: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        """Checks the numbers; raises ArgumentError for one that is below 0, or not finite."""
        require_number("position", self.position, 0.0, unit="m")
        require_number("angle", self.angle, 0.0, unit="rad")

    def bound(self, radius: float, looks: int = 1) -> float:
        """How far the mean of some looks may have a point within a radius of a body's origin from where it is [m]."""
        return SURE * (self.position + self.angle * radius) / sqrt(looks)

    def needed(self, radius: float, margin: float) -> int:
        """How many looks bring the bound below a margin [m], `MOST_LOOKS` at most."""
        if margin <= 0.0:
            return MOST_LOOKS
        return min(MOST_LOOKS, max(1, ceil((self.bound(radius) / margin) ** 2)))


@dataclass
class _Mean:
    wanted: Array  # (4, 4) where the plan has the body
    key: str  # by whom it is held
    count: int = 0
    off: Array = field(default_factory=lambda: np.zeros(6))  # [m] in the frame in which it is constant, and [rad]
    last: list[Array] = field(default_factory=list)  # shift and turn (6,) of the last looks
    time: float | None = None  # of the last one [s]

    def pose(self, wanted: Array) -> Array:
        """Where the body is (4, 4), if it should be at `wanted`."""
        found = wanted.copy()
        found[:3, 3] += (wanted[:3, :3] if self.key else np.eye(3)) @ self.off[:3]
        found[:3, :3] = wanted[:3, :3] @ rotation(self.off[3:])
        return found


@dataclass(frozen=True, eq=False)
class Seen:
    """What is known of a body's place after some looks: how far it is off, and by how much that may err [m]."""

    displaced: Displacement
    size: float
    looks: int = 1
    error: float = 0.0

    def with_error(self, sign: float) -> Displacement:
        """The displacement if the error makes it larger (1) or smaller (-1)."""
        return replace(self.displaced, error=sign * self.error)


class Looks:
    """The means of what was seen of bodies, each since it was moved last.

    Args:
        noise: of a look; None: poses are seen as they are, and one look is enough.
    """

    def __init__(self, noise: PoseNoise | None) -> None:
        self.noise = noise
        self._means: dict[str, _Mean] = {}
        self._last: dict[str, Array] = {}  # poses that are seen without noise

    def note(self, seen: Mapping[str, Array]) -> None:
        """Notes poses (4, 4) of bodies while robots stand: without noise they hold until robots move, or hands act."""
        if self.noise is None:
            self._last |= seen

    def forget(self) -> None:
        """Robots move, or a hand acts: bodies that are not seen again may be elsewhere."""
        self._last = {}

    def take(
        self,
        name: str,
        wanted: Array,
        pose: Array,
        held_by: str | None,
        corners: Array,
        time: float | None = None,
    ) -> Seen:
        """Takes a look at a body into account; one picture counts once, however often it is looked at.

        Args:
            name: the body. wanted, pose: where it should be, and where it is seen (4, 4), in the world.
            held_by: the robot that holds it: it is off in its hand, not in the world.
            corners: (8, 3) of the box around the body, in its own frame [m].
            time: when it is seen [s]; None: at no other time before.
        """
        if self.noise is None:
            found = displacement(wanted, pose, corners)
            return Seen(found, found.size)
        mean = self._means.get(name)
        key = held_by or ""
        if mean is None or mean.key != key or (not key and not np.allclose(mean.wanted, wanted, atol=1e-6)):
            mean = self._means[name] = _Mean(wanted, key)
        mean.wanted = wanted
        if time is None or time != mean.time:
            frame, mean.time = wanted[:3, :3] if key else np.eye(3), time
            shift = frame.T @ (pose[:3, 3] - wanted[:3, 3])
            self._add(mean, np.concatenate([shift, rotation_vector(wanted[:3, :3].T @ pose[:3, :3])]))
        found = displacement(wanted, mean.pose(wanted), corners)
        radius = float(np.linalg.norm(corners, axis=1).max())
        return Seen(found, found.size, mean.count, self.noise.bound(radius, mean.count))

    def _add(self, mean: _Mean, off: Array) -> None:
        """Adds a look to the mean, which begins anew if the last looks say that the body was moved."""
        assert self.noise is not None
        spread = np.repeat([max(self.noise.position, 1e-9), max(self.noise.angle, 1e-9)], 3)
        mean.last = [*mean.last, off][-max(LAST_LOOKS) :]
        for number in LAST_LOOKS:
            beside = np.array(mean.last[-number:]) - mean.off
            moved = beside.mean(axis=0)
            among = MOVED * spread * sqrt(1.0 / number + 1.0 / max(1, mean.count))
            all_of_them = (beside * np.sign(moved)).min(axis=0) > OF_THEM * np.abs(moved)
            if mean.count > number <= len(mean.last) and ((np.abs(moved) > among) & all_of_them).any():
                mean.count, mean.off, mean.last = number, mean.off + moved, mean.last[-number:]
                return
        mean.count = min(mean.count + 1, MOST_LOOKS)  # older looks are forgotten
        mean.off = mean.off + (off - mean.off) / mean.count

    def are_enough(self, margin: float) -> bool:
        """Whether there are as many looks at each body as bring the error of its place below a margin [m]."""
        if self.noise is None:
            return True
        return all(mean.count >= self.noise.needed(0.0, margin) for mean in self._means.values())

    def still(self, exact: float) -> float:
        """By how much poses of bodies that stand may differ between two looks [m, or of a turn]; `exact`: without noise."""
        if self.noise is None:
            return exact
        least = min((mean.count for mean in self._means.values()), default=1)
        return max(exact, self.noise.bound(1.0, max(1, least)))

    def counts(self) -> dict[str, int]:
        """How many looks the mean of each body is of."""
        return {name: mean.count for name, mean in self._means.items()}

    def poses(self, seen: Mapping[str, Array]) -> dict[str, Array]:
        """The poses (4, 4) of bodies that are seen, or were looked at since they moved, by the means of looks at them."""
        found = {**self._last, **seen}
        for name, mean in self._means.items():
            if mean.count:
                found[name] = mean.pose(mean.wanted)
        return found


def rotation_vector(turn: Array) -> Array:
    """The vector (3,) along the axis of a rotation (3, 3), as long as its angle [rad]."""
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    length = float(np.linalg.norm(axis))
    angle = float(np.arctan2(0.5 * length, 0.5 * (np.trace(turn) - 1.0)))
    if length > 1e-9:
        return np.asarray(axis * (angle / length))
    return np.array([angle, 0.0, 0.0])  # by nothing, or by half a turn about any axis


def rotation(vector: Array) -> Array:
    """The rotation (3, 3) about a vector by its length [rad] [Rodrigues]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)
