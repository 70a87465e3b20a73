"""Checks every claim in the proof that two bodies stay apart: disjoint boxes, and separating axes.

Nothing is searched. A claim is about a piece of the path and a range of convex parts of each body. What a body sweeps
over this piece lies in the hull of its poses at both ends and at all way points between, enlarged by the deviation of
the path from the chords and by that of the trajectory from the path. Poses are given in the world as if the last joint
that carries both bodies stayed in its first pose.
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.plan import PairProof
from kabo.verify.certificate.parts import Parts
from kabo.verify.motion.chord_bounds import deviations, frame_of, reach, strays
from kabo.verify.motion.sweep import Path, Poses, SweptBody

POSITIONS_PER_PIECE = 1 << 20  # positions in the path are integers, so many to the piece between two way points
MAX_HALVINGS = 200  # nested halvings of a claim; a proof needs 20 in time and a few of parts
SIDES = np.vstack([np.eye(3), -np.eye(3)])  # of boxes
UNIT_ROUNDING = 2.0**-53  # the relative rounding error of one operation


class Refuted(Exception):
    """A claim of a proof does not hold, or its form is wrong."""


@dataclass
class Margin:
    """The least margin of a proof's claims [m], and how many separating axes were evaluated.

    `claims` are those below `near`: unit axes, along which the first body is ahead of the second one, and gaps [m].
    """

    least: float = np.inf
    axes: int = 0
    claims: list[tuple[Array, float]] = field(default_factory=list)


class Frames:
    """The poses of all joints along a path, each computed once."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._known: dict[int, Poses] = {}

    def at(self, s: int) -> Poses:
        """The poses of all joints at a position of the path."""
        if s not in self._known:
            piece, share = divmod(s, POSITIONS_PER_PIECE)
            q = self.path.configurations[piece]
            if share:
                q = q + share / POSITIONS_PER_PIECE * (self.path.configurations[piece + 1] - q)
            self._known[s] = {
                name: arm.joint_poses(q[self.path.columns[name]].tolist()) for name, arm in self.path.arms.items()
            }
        return self._known[s]


class Side:
    """One body of a pair along a path."""

    def __init__(self, frames: Frames, thing: SweptBody, parts: Parts, robot: str | None, joint: int) -> None:
        self.parts, self._frames, self._thing, self._robot, self._joint = parts, frames, thing, robot, joint
        path, mount = frames.path, thing.mount
        # Balls need no chords: their centres have them.
        radius = 0.0 if mount is None else reach(mount, parts.vertices, parts.of_vertices(parts.discs))
        self.deviations, self.moves = deviations(path, mount, joint if mount is not None else 0, radius)
        self.strays = strays(path, mount, joint if mount is not None else 0, radius)
        self.moves = self.moves or bool(self.strays.any())
        self._poses: dict[int, Array] = {}
        self._stretches: dict[tuple[int, int], tuple[Array, Array]] = {}
        self._boxes: dict[tuple[int, int], tuple[list[list[float]], list[list[float]], float]] = {}
        joints = 0 if mount is None else len(path.arms[mount.robot].parents)
        # The rounding error of a point, by its distance from the origin; twice the products for balls and discs.
        products = 16.0 if parts.rounded else 8.0
        self.rounding = UNIT_ROUNDING * (products + 2.0 * (8.0 * joints + 4.0))

    def pose(self, s: int) -> Array:
        """The pose (4, 4) of the body at a position of the path."""
        if s not in self._poses:
            pose = self._thing.pose(self._frames.at(s))
            if self._robot is not None and self._joint > 0:
                start, now = (self._frames.at(k)[self._robot][self._joint] for k in (0, s))
                pose = start @ np.linalg.inv(now) @ pose
            self._poses[s] = pose
        return self._poses[s]

    def poses(self, s0: int, s1: int) -> tuple[Array, Array]:
        """The body's rotations (P, 3, 3) and translations (P, 3) at positions s0, s1 and way points between."""
        if not self.moves:
            s0 = s1 = 0
        if (s0, s1) not in self._stretches:
            step = POSITIONS_PER_PIECE if s1 - s0 >= POSITIONS_PER_PIECE else max(1, s1 - s0)
            poses = np.array([self.pose(s) for s in range(s0, s1 + 1, step)])
            self._stretches[s0, s1] = np.ascontiguousarray(poses[:, :3, :3]), poses[:, :3, 3].copy()
        return self._stretches[s0, s1]

    def deviation(self, s0: int, s1: int) -> float:
        """An upper bound of how far the body's points leave their chords between two positions of the path [m].

        Inside a piece the path bends less, but the trajectory may deviate from it as much as anywhere on the piece.
        """
        first, last = s0 // POSITIONS_PER_PIECE, s1 // POSITIONS_PER_PIECE
        if s1 - s0 < POSITIONS_PER_PIECE:
            share = (s1 - s0) / POSITIONS_PER_PIECE
            return float(self.deviations[first]) * share**2 + float(self.strays[first])
        return float((self.deviations[first:last] + self.strays[first:last]).max())

    def box(self, s0: int, s1: int, low: int, high: int) -> tuple[Any, Any, Any]:
        """The box (lower, upper) around all that a range of parts sweeps, and the rounding error [m]."""
        if not self.moves:
            s0 = s1 = 0
        if (s0, s1) not in self._boxes:
            self._boxes[s0, s1] = self._all_boxes(s0, s1)
        lower, upper, far = self._boxes[s0, s1]
        number = self.parts.ranges[low, high]
        return lower[number], upper[number], self.rounding * 2.0 * far

    def _all_boxes(self, s0: int, s1: int) -> tuple[list[list[float]], list[list[float]], float]:
        """The boxes around what each range of parts sweeps, and the greatest coordinate among them."""
        (turns, places), (middles, halves) = self.poses(s0, s1), self.parts.boxes
        middle = np.einsum("prc,nc->pnr", turns, middles) + places[:, None]
        half = np.einsum("prc,nc->pnr", np.abs(turns), halves)
        grow = self.deviation(s0, s1) if self.moves else 0.0
        lower, upper = (middle - half).min(axis=0) - grow, (middle + half).max(axis=0) + grow
        return lower.tolist(), upper.tolist(), float(max(np.abs(lower).max(), np.abs(upper).max()))

    def farthest(self, s0: int, s1: int, low: int, high: int, axis: Array) -> tuple[float, float]:
        """The greatest dot product of an axis with a point that parts sweep, and its rounding error."""
        turns, places = self.poses(s0, s1)
        own = axis @ turns
        products = self.parts.range(low, high) @ own.T + places @ axis
        if self.parts.rounded:
            products = products + self.parts.bulges(low, high, own)
        far = float(np.abs(places).max()) + self.parts.radius
        return float(products.max()) + self.deviation(s0, s1), self.rounding * far * 2.0


SideOf = Callable[[Any, SweptBody, Parts, str | None, int], Side]


class ProvenPair:
    """Two bodies that move along a path, for checking a proof that they stay apart."""

    def __init__(
        self,
        frames: Frames,
        first: SweptBody,
        second: SweptBody,
        parts: Callable[[SweptBody], Parts],
        side: "SideOf | None" = None,
    ) -> None:
        robot, self.joint = frame_of(frames.path, first, second)  # claims are in its frame; 0: in the world
        self.end = (len(frames.path.configurations) - 1) * POSITIONS_PER_PIECE
        made = side or Side
        self.sides = tuple(made(frames, thing, parts(thing), robot, self.joint) for thing in (first, second))

    def turned(self) -> "ProvenPair":
        """A copy of the pair with its two bodies exchanged."""
        other = copy(self)
        other.sides = self.sides[::-1]
        return other

    @property
    def moves(self) -> bool:
        """Whether the two bodies move relative to each other."""
        return any(side.moves for side in self.sides)

    def apart(self) -> float:
        """The distance between the boxes around all that each body sweeps [m]; negative if the boxes overlap."""
        return float(self.box_gap(0, self.end, [side.parts.all for side in self.sides])[0])

    def box_gap(self, s0: int, s1: int, ranges: list[tuple[int, int]], most: float = np.inf) -> tuple[Any, Array]:
        """The distance of the two bodies' boxes over a piece of the path, less the rounding error [m], and its axis."""
        (low, high, a), (other_low, other_high, b) = (
            side.box(s0, s1, *own) for side, own in zip(self.sides, ranges, strict=True)
        )
        ahead = [x - y for x, y in zip(low, other_high, strict=True)]
        behind = [x - y for x, y in zip(other_low, high, strict=True)]
        gap, side = max((gap, k) for k, gap in enumerate([*ahead, *behind]))
        return min(gap - a - b, most), SIDES[side]

    def axis_gap(self, s0: int, s1: int, ranges: list[tuple[int, int]], axis: Array) -> tuple[Any, Array]:
        """The gap between the two bodies along an axis over a piece of the path, less the rounding error [m]; and it."""
        first, a = self.sides[0].farthest(s0, s1, *ranges[0], -axis)
        second, b = self.sides[1].farthest(s0, s1, *ranges[1], axis)
        return -first - second - a - b, axis

    def check(self, proof: PairProof, near: float, finest: int = 1) -> Margin:
        """Checks a proof that two bodies stay apart; returns its least margin and the number of evaluated axes.

        Margins between boxes count as `near` [m] at most. A proof may not halve a piece of the path of `finest`
        positions or fewer.

        Raises:
            Refuted: a claim does not hold; the text says which.
        """
        margin, axes = Margin(), _Axes(proof)
        ahead = [(0, self.end, [side.parts.all for side in self.sides], 0)]
        for letter in proof.walk:
            if not ahead:
                raise Refuted("its walk goes on where nothing is left to prove")
            s0, s1, ranges, depth = ahead.pop()
            if depth > MAX_HALVINGS:
                raise Refuted(f"it is halved more than {MAX_HALVINGS} times")
            if letter in "ae":
                gap, axis = self.axis_gap(s0, s1, ranges, axes.next(letter))
                margin.axes += 1
            elif letter == "b":
                gap, axis = self.box_gap(s0, s1, ranges, near)
            else:
                ahead.extend((*half, depth + 1) for half in reversed(_halves(letter, s0, s1, ranges, finest)))
                continue
            if not gap > 0.0:
                what = "boxes overlap" if letter == "b" else f"an axis leaves {float(gap):.3g} m"
                raise Refuted(
                    f"between {s0 / POSITIONS_PER_PIECE:.4g} and {s1 / POSITIONS_PER_PIECE:.4g} of its path {what}"
                )
            margin.least = min(margin.least, float(gap))
            margin.claims += [(axis, float(gap))] if gap < near else []
        if ahead:
            raise Refuted("its walk ends before all is proven")
        return margin


def _halves(
    letter: str, s0: int, s1: int, ranges: list[tuple[int, int]], finest: int
) -> list[tuple[int, int, list[tuple[int, int]]]]:
    if letter == "t":
        if s1 - s0 <= finest:
            raise Refuted("a stretch is halved that cannot be")
        middle = (
            (s0 // POSITIONS_PER_PIECE + s1 // POSITIONS_PER_PIECE) // 2 * POSITIONS_PER_PIECE
            if s1 - s0 > POSITIONS_PER_PIECE
            else (s0 + s1) // 2
        )
        return [(s0, middle, ranges), (middle, s1, ranges)]
    if letter not in "fs":
        raise Refuted(f"its walk has the letter {letter!r}")
    side = "fs".index(letter)
    low, high = ranges[side]
    if high - low < 2:
        raise Refuted("one part is halved")
    middle, other = (low + high) // 2, ranges[1 - side]
    return [(s0, s1, [own, other] if side == 0 else [other, own]) for own in ((low, middle), (middle, high))]


class _Axes:
    """The unit vectors of a proof's axes, in the order in which the proof uses them."""

    def __init__(self, proof: PairProof) -> None:
        count = 6 * proof.walk.count("a")
        if len(proof.axes) != count + 24 * proof.walk.count("e"):
            raise Refuted("its axes are not those that its walk names")
        short = np.frombuffer(proof.axes[:count], "<i2").astype(np.float64).reshape(-1, 3)
        exact = np.frombuffer(proof.axes[count:], "<f8").astype(np.float64).reshape(-1, 3)
        self._left = {"a": iter(short), "e": iter(exact)}

    def next(self, letter: str) -> Array:
        axis = next(self._left[letter])
        length = float(np.linalg.norm(axis))
        if not np.isfinite(length) or length == 0.0:
            raise Refuted("an axis is no direction")
        return np.asarray(axis / length)
