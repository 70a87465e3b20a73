"""Checks that a motion is a straight stroke: from its near end, it leads in a given direction over a given length.

The near end of a stroke is where the hand takes or lets go, where the object stands, or where the parts are joined. The
proof covers the whole path, not samples only: on a piece that is straight in joint space, a point leaves its chord by no
more than `deviations` [K Eq. 4.19-4.22], and its velocity differs from the chord's by no more than eight times as much.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.arms import Mount
from kabo.verify.motion.chord_bounds import deviations, strays
from kabo.verify.motion.sweep import Path

STRAIGHT_SHARE = 1.0 / 3.0  # of a family's least length is straight; after that a corner may be rounded
MIN_STRAIGHT = 0.01  # [m] the least length of the straight part
MAX_OFFSET = 2e-4  # [m] between the tool and its line at the near end
MAX_OFFSET_SLOPE = 0.2  # [m per m of the way] by which this offset may grow in the straight part
MAX_CORNER_SLOPE = 1.0  # [m per m of the way] by which it may grow in the rounded corner
MAX_TURN, MAX_CORNER_TURN = 0.02, 0.2  # [rad] rotation of the tool in the straight part, and in the corner
MIN_LENGTH_SHARE = 0.5  # of a family's least length that a stroke with a rounded corner must have
LENGTH_SLACK = 1e-3  # [m] by which a stroke may be longer than its family says
MAX_HALVINGS = 16  # of a piece; a condition that is not proven then is at its bound


@dataclass(frozen=True)
class Limits:
    """The limits of a stroke; lengths in metres, angles in radians."""

    least: float  # the least length
    most: float  # the greatest length
    near: float  # the length of the straight part
    aside: float  # the greatest offset from the line at the near end
    slope: float  # the growth of this offset along the straight part
    turned: float  # the greatest rotation in the straight part

    def may_leave(self, progress: float) -> float:
        """The greatest permitted offset of a point from its line [m] after it has moved `progress` metres."""
        return self.aside + (self.slope if progress < self.near else MAX_CORNER_SLOPE) * max(0.0, progress)

    def may_turn(self, progress: float) -> float:
        """The greatest permitted rotation of the tool [rad] after it has moved `progress` metres."""
        return self.turned if progress < self.near else MAX_CORNER_TURN


def of_family(least: float, most: float, *, any_length: bool = False) -> Limits:
    """The limits of an approach, lift, lowering or retreat with its family's range of lengths [m]."""
    shortest, longest = (0.0, np.inf) if any_length else (MIN_LENGTH_SHARE * least, most + LENGTH_SLACK)
    return Limits(
        shortest, longest, max(STRAIGHT_SHARE * least, MIN_STRAIGHT), MAX_OFFSET, MAX_OFFSET_SLOPE, MAX_TURN
    )


def of_mate(least: float, most: float, tolerance: float) -> Limits:
    """The limits of an insertion with these lengths [m], which must be straight from its beginning to its end."""
    return Limits(least - LENGTH_SLACK, most + LENGTH_SLACK, np.inf, tolerance, 0.0, MAX_TURN)


@dataclass(frozen=True)
class Fault:
    """The first fault of a stroke: what is wrong, when [s], and by how much."""

    text: str
    time: float
    by: float


@dataclass
class Stroke:
    """A motion that must be a stroke.

    Attributes:
        path: the whole motion, of one robot or of several that move together.
        mount: the joint of one of its robots that carries the points (the mount's own pose is not used).
        points: (P, 3) in the frame of that joint; each must move away from the near end all the time, and the first
            `straight` of them must stay on the line.
        away: (3,) the unit vector in the world that leads away from the near end.
        limits: the limits of the stroke.
        backward: whether the near end is the end of the path, not its beginning.
        beside: the mount relative to which the motion is measured, or None; it may be translated, not rotated.
    """

    path: Path
    mount: Mount
    points: Array
    away: Array
    limits: Limits
    backward: bool = False
    straight: int = 1
    beside: Mount | None = None
    _known: dict[tuple[int, float], tuple[Array, Array, float]] = field(default_factory=dict)

    def fault(self) -> Fault | None:
        """The fault nearest to the near end of the stroke; None if the motion is a valid stroke."""
        pieces = range(len(self.path.steps))
        bends, turning = self._bounds()
        strays, twists = self._strays()
        if self.beside is not None and self._turns(self.beside).max() > 1e-9:
            return Fault("both parts turn, which is not judged", float(self.path.times[0]), 0.0)
        for piece in reversed(pieces) if self.backward else pieces:
            if self.path.steps[piece].any():
                margins = float(strays[piece]), float(twists[piece])
                wrong = self._piece(piece, float(bends[piece]), float(turning[piece]), margins)
                if wrong is not None:
                    return wrong
        return self._length()

    def _length(self) -> Fault | None:
        far = (0, 0.0) if self.backward else (len(self.path.steps) - 1, 1.0)
        length = float(self._at(*far)[0][0])
        low, high = self.limits.least, self.limits.most
        if low <= length <= high:
            return None
        text = f"is {1000 * length:.4g} mm long, not {1000 * low:.4g} to {1000 * high:.4g} mm"
        return Fault(text, self.path.time(*far), max(low - length, length - high))

    def _bounds(self) -> tuple[Array, Array]:
        """For every piece the most that points leave their chords [m], and the rotation of the moving body [rad]."""
        radius = float(np.linalg.norm(self.points, axis=1).max())
        bends, _ = deviations(self.path, self.mount, 0, radius)
        if self.beside is not None:
            bends = bends + deviations(self.path, self.beside, 0, 1.0)[0]
        return bends, self._turns(self.mount)

    def _strays(self) -> tuple[Array, Array]:
        """How far the trajectory may bring points [m] and turn the body [rad] from where the path has them."""
        path, mount, beside = self.path, self.mount, self.beside
        found = strays(path, mount, 0, float(np.linalg.norm(self.points, axis=1).max()))
        if beside is not None:
            found = found + strays(path, beside, 0, float(np.linalg.norm(beside.joint_T_body[:3, 3])))
        off = path.deviations[:, path.columns[mount.robot]]
        return found, np.asarray(off @ path.arms[mount.robot].turning(mount.joint))

    def _turns(self, mount: Mount) -> Array:
        steps = self.path.steps[:, self.path.columns[mount.robot]]
        return np.asarray(steps @ self.path.arms[mount.robot].turning(mount.joint))

    def _piece(self, piece: int, bend: float, turning: float, margins: tuple[float, float]) -> Fault | None:
        ends = (1.0, 0.0) if self.backward else (0.0, 1.0)
        stack: list[tuple[float, float, int]] = [(*ends, 0)]
        while stack:
            nearer, farther, depth = stack.pop()
            wrong = self._fault_at(piece, nearer) or self._fault_at(piece, farther)
            if wrong is not None:
                return wrong
            missing = self._unproven(piece, nearer, farther, bend, turning, margins)
            if missing is None:
                continue
            if depth >= MAX_HALVINGS:
                return Fault(missing, self.path.time(piece, farther), 0.0)
            middle = (nearer + farther) / 2
            stack += [(middle, farther, depth + 1), (nearer, middle, depth + 1)]
        return None

    def _fault_at(self, piece: int, share: float) -> Fault | None:
        """The fault at one place of a piece; None if there is none."""
        along, aside, turned = self._at(piece, share)
        far = float(along[0])
        over = float(aside[: self.straight].max()) - self.limits.may_leave(far)
        time = self.path.time(piece, share)
        if over > 0.0:
            off = 1000 * float(aside[: self.straight].max())
            return Fault(f"leaves its line by {off:.3g} mm after {1000 * far:.4g} mm", time, over)
        if turned > self.limits.may_turn(far):
            return Fault(f"turns by {turned:.3g} rad after {1000 * far:.4g} mm", time, turned)
        return None

    def _unproven(
        self, piece: int, nearer: float, farther: float, bend: float, turning: float, margins: tuple[float, float]
    ) -> str | None:
        """The condition that is not proven between two places of a piece; None if all are.

        `margins`: how far the trajectory may bring points [m] and turn the body [rad] from where the path has them.
        """
        (a, off_a, turned_a), (b, off_b, turned_b) = self._at(piece, nearer), self._at(piece, farther)
        width = abs(farther - nearer)
        stray, twist = margins
        curved = bend * width * width
        least = min(float(a[0]), float(b[0])) - curved - stray
        if least < self.limits.near and float((b - a).min()) <= 8.0 * curved:
            return "does not lead away all the time"
        off = max(float(off_a[: self.straight].max()), float(off_b[: self.straight].max())) + curved + stray
        if off > self.limits.may_leave(least):
            return f"is not proven to keep to its line after {1000 * least:.4g} mm"
        if max(turned_a, turned_b) + turning * width / 2 + twist > self.limits.may_turn(least):
            return f"is not proven to keep its orientation after {1000 * least:.4g} mm"
        return None

    def _at(self, piece: int, share: float) -> tuple[Array, Array, float]:
        """The way of each point along the direction (P,) [m], its offset from the line (P,) [m], and the rotation [rad]."""
        key = piece, share
        if key not in self._known:
            rotation, places, frame = self._places(piece, share)
            first, start, origin = self._near
            moved = places - start - (frame - origin)
            along = moved @ self.away
            aside = np.linalg.norm(moved - np.outer(along, self.away), axis=1)
            sine = np.linalg.norm(first.T @ rotation - np.eye(3)) / np.sqrt(8.0)  # the sine of half the angle
            self._known[key] = along, aside, 2.0 * float(np.arcsin(min(1.0, sine)))
        return self._known[key]

    @cached_property
    def _near(self) -> tuple[Array, Array, Array]:
        return self._places(*((len(self.path.steps) - 1, 1.0) if self.backward else (0, 0.0)))

    def _places(self, piece: int, share: float) -> tuple[Array, Array, Array]:
        poses = self.path.poses(piece, share)
        pose = poses[self.mount.robot][self.mount.joint]
        beside = self.beside
        frame = np.zeros(3) if beside is None else (poses[beside.robot][beside.joint] @ beside.joint_T_body)[:3, 3]
        return pose[:3, :3], self.points @ pose[:3, :3].T + pose[:3, 3], frame


def box_corners(lower: Array, upper: Array) -> Array:
    """The corners (8, 3) of the box between its lower and upper corner (3,)."""
    picks = np.array(list(np.ndindex(2, 2, 2)), bool)
    return np.where(picks, upper, lower)


def first_fault(strokes: Sequence[tuple[str, Stroke]]) -> tuple[str, Fault] | None:
    """The fault of the first stroke if every stroke has a fault; None if at least one has none."""
    faults = list(_faults(strokes))
    return None if len(faults) < len(strokes) else faults[0]


def _faults(strokes: Sequence[tuple[str, Stroke]]) -> Iterator[tuple[str, Fault]]:
    for name, stroke in strokes:
        wrong = stroke.fault()
        if wrong is None:
            return
        yield name, wrong
