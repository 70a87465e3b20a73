"""Evaluates proofs in exact arithmetic: poses, boxes and dot products are integers, in units of 2^-160 m.

For the paranoid mode. Sines and cosines are sums of their series, everything else is sums and products; the error of
cutting off after 160 bits is far below `SLACK`. Placements of joints and bodies are the given floating-point numbers,
whose rotations are off by 1e-16; `SLACK` covers that, too. Bounds of deviations are rounded up.
"""

from fractions import Fraction
from functools import cache
from math import isqrt
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.verify.certificate.pair_proof import POSITIONS_PER_PIECE, Frames, Side
from kabo.verify.certificate.parts import Parts
from kabo.verify.motion.sweep import Path, SweptBody

BITS = 160  # after the binary point
SLACK = Fraction(1, 10**12)  # [m] the error allowed for, for each metre from the origin and one metre more
Integers = Any  # numpy arrays of Python's integers, BITS after the point


def integers(values: Any) -> Integers:
    """Floating-point numbers as integers with `BITS` bits after the point; further bits are cut off."""
    return _integers(np.asarray(values, dtype=np.float64))


def _integer(value: float) -> int:
    numerator, denominator = float(value).as_integer_ratio()
    return (numerator << BITS) // denominator


_integers = np.vectorize(_integer, otypes=[object])


def product(first: Integers, second: Integers) -> Integers:
    """The matrix product of two arrays of fixed-point integers, again with `BITS` bits after the point."""
    return np.dot(first, second) >> BITS


def sine_and_cosine(angle: Fraction) -> tuple[int, int]:
    """The sine and cosine of an angle [rad] as integers with `BITS` bits after the point."""
    turn = 2 * _pi()
    x = int(angle * (1 << BITS)) % turn
    x = x - turn if 2 * x > turn else x
    sums, term, n = [0, 0], 1 << BITS, 0
    while term:
        sums[n % 2] += -term if n % 4 > 1 else term
        n += 1
        term = (term * abs(x) >> BITS) // n
    return (sums[1] if x >= 0 else -sums[1]), sums[0]


@cache
def _pi() -> int:
    """Pi with BITS after the point [Machin 1706]."""

    def arctangent(inverse: int) -> int:
        term = (1 << (BITS + 32)) // inverse
        total, n = 0, 1
        while term:
            total += term // n if n % 4 == 1 else -(term // n)
            term //= inverse * inverse
            n += 2
        return total

    return int(4 * (4 * arctangent(5) - arctangent(239)) >> 32)


def _length(vector: Integers) -> int:
    """The length of a vector of fixed-point integers, rounded up."""
    return isqrt(sum(int(v) ** 2 for v in vector)) + 1


class ExactFrames(Frames):
    """The poses of all joints along a path, as integers (4, 4)."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._exact: dict[tuple[str, int], list[Integers]] = {}
        self._turns: dict[str, list[Integers]] = {}

    def joints(self, robot: str, s: int) -> list[Integers]:
        """The poses of a robot's joints at a position of the path, in pinocchio's frames."""
        if (robot, s) not in self._exact:
            arm = self.path.arms[robot]
            piece, share = divmod(s, POSITIONS_PER_PIECE)
            columns = self.path.columns[robot]
            rows = self.path.configurations[piece : piece + 2, columns]
            q = [
                Fraction(a) + Fraction(share, POSITIONS_PER_PIECE) * (Fraction(rows[-1][i]) - Fraction(a))
                for i, a in enumerate(rows[0])
            ]
            self._exact[robot, s] = [
                product(pose, turn)
                for pose, turn in zip(_along(arm.robot.tree, q), self._turned(robot), strict=True)
            ]
        return self._exact[robot, s]

    def _turned(self, robot: str) -> list[Integers]:
        """The rotation of pinocchio's frame of each joint relative to that of the tree, where every axis is z."""
        if robot not in self._turns:
            arm = self.path.arms[robot]
            zero = np.zeros(arm.robot.tree.size)
            poses = arm.joint_poses(zero.tolist())
            own = [pose.astype(object) for pose in _along(arm.robot.tree, [Fraction(0)] * len(zero))]
            floats = [
                np.array([[float(Fraction(int(v), 1 << BITS)) for v in row] for row in pose]) for pose in own
            ]
            self._turns[robot] = [integers(np.linalg.inv(a) @ b) for a, b in zip(floats, poses, strict=True)]
        return self._turns[robot]


def _along(tree: Any, q: list[Fraction]) -> list[Integers]:
    """The poses of all joints of a tree in configuration q."""
    poses = [integers(np.eye(4))]
    for j in range(1, len(tree.parent)):
        placed = integers(np.eye(4))
        placed[:3, :3], placed[:3, 3] = (
            integers(tree.placement[j][:9].reshape(3, 3)),
            integers(tree.placement[j][9:]),
        )
        value = Fraction(tree.ratio[j]) * q[int(tree.source[j])] + Fraction(tree.shift[j])
        moved = integers(np.eye(4))
        if tree.kind[j] == 0:
            sine, cosine = sine_and_cosine(value)
            moved[0, 0], moved[0, 1], moved[1, 0], moved[1, 1] = cosine, -sine, sine, cosine
        else:
            moved[2, 3] = int(value * (1 << BITS))
        poses.append(product(product(poses[int(tree.parent[j])], placed), moved))
    return poses


class ExactSide(Side):
    """One body of a pair along a path, in exact arithmetic."""

    def __init__(self, frames: ExactFrames, thing: SweptBody, parts: Parts, robot: str | None, joint: int) -> None:
        super().__init__(frames, thing, parts, robot, joint)
        self._integers: dict[int, Integers] = {}
        self._vertices: Integers = parts.exact(integers)

    def _matrix(self, s: int) -> Integers:
        if s not in self._integers:
            frames, thing = self._frames, self._thing
            assert isinstance(frames, ExactFrames)
            if thing.mount is None:
                pose = integers(thing.world_T)
            else:
                pose = product(
                    frames.joints(thing.mount.robot, s)[thing.mount.joint], integers(thing.mount.joint_T_body)
                )
            if self._robot is not None and self._joint > 0:
                start, now = (frames.joints(self._robot, k)[self._joint] for k in (0, s))
                back = integers(np.eye(4))
                back[:3, :3] = now[:3, :3].T
                back[:3, 3] = -product(now[:3, :3].T, now[:3, 3])
                pose = product(product(start, back), pose)
            self._integers[s] = pose
        return self._integers[s]

    def _stretch(self, s0: int, s1: int) -> list[Integers]:
        if not self.moves:
            return [self._matrix(0)]
        step = POSITIONS_PER_PIECE if s1 - s0 >= POSITIONS_PER_PIECE else s1 - s0
        return [self._matrix(s) for s in range(s0, s1 + 1, step)]

    def box(self, s0: int, s1: int, low: int, high: int) -> tuple[Any, Any, Any]:
        """The box (lower, upper) around all that a range of parts sweeps, and the rounding error, as fractions."""
        number = self.parts.ranges[low, high]
        own_middle, own_half = (integers(each[number]) for each in self.parts.boxes)
        lower, upper = [], []
        for pose in self._stretch(s0, s1):
            middle = product(pose[:3, :3], own_middle) + pose[:3, 3]
            half = product(np.abs(pose[:3, :3]), own_half)
            lower.append(middle - half)
            upper.append(middle + half)
        grow = Fraction(self.deviation(s0, s1))
        fractions = [
            [Fraction(int(v), 1 << BITS) for v in row] for row in (np.min(lower, axis=0), np.max(upper, axis=0))
        ]
        return (
            np.array([v - grow for v in fractions[0]], dtype=object),
            np.array([v + grow for v in fractions[1]], dtype=object),
            self._slack(),
        )

    def farthest(self, s0: int, s1: int, low: int, high: int, axis: Array) -> tuple[Any, Any]:
        """The greatest dot product of an axis with a swept point, and its rounding error, as fractions."""
        own = self._vertices[self.parts.starts[low] : self.parts.starts[high]]
        along, best = integers(axis), None
        for pose in self._stretch(s0, s1):
            turned = product(pose[:3, :3].T, along)
            heights = product(own, turned) + product(pose[:3, 3], along)
            if self.parts.rounded:
                heights = heights + self._bulges(low, high, turned)
            best = max(int(heights.max()), int(heights.max()) if best is None else best)
        assert best is not None
        return Fraction(best, 1 << BITS) + Fraction(self.deviation(s0, s1)), self._slack()

    def _bulges(self, low: int, high: int, axis: Integers) -> Integers:
        """How far ball and disc reach beyond each vertex along an axis of the body's frame, rounded up."""
        reaches, length = [], _length(axis)
        for part in range(low, high):
            n = integers(self.parts.axes[part])
            crossed = np.roll(axis, -1) * np.roll(n, 1) - np.roll(axis, 1) * np.roll(n, -1)
            across = _length(crossed >> BITS)
            ball, disc = (int(integers(float(own[part]))) + 1 for own in (self.parts.balls, self.parts.discs))
            reaches.append((ball * length + disc * across >> BITS) + 2)
        return np.repeat(np.array(reaches, dtype=object), np.diff(self.parts.starts[low : high + 1]))

    def _slack(self) -> Fraction:
        far = float(np.abs(self.pose(0)[:3, 3]).max()) + self.parts.radius
        return SLACK * (1 + Fraction(far + float(self.deviations.sum())))
