"""Bodies as convex parts: enclosures, and groups of parts attached to a joint or standing in the world."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers

Mesh = tuple[Array, Integers]  # vertices (V, 3) [m], faces (F, 3)

COLUMNS = 24  # vertices of a part at most


class Packed(NamedTuple):
    """The parts of an enclosure as arrays for kernels; unused columns repeat the first vertex."""

    blocks: Array  # (B, 3, 24)
    sizes: Integers  # (B,) 8, 16 or 24: how many columns to read
    diameters: Array  # (B,) greatest distance of two vertices [m]


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Convex parts whose union encloses a body; none of their points is farther than `deviation` [m] from the body."""

    parts: tuple[Array, ...]  # each (V <= 24, 3) [m], in the body's frame
    deviation: float

    def __post_init__(self) -> None:
        """Raises an error for a negative deviation, which would silently enlarge epsilon.

        Raises:
            ValueError: the deviation is negative, or no number.
        """
        if not self.deviation >= 0.0:
            raise ValueError(f"an enclosure deviates by {self.deviation:g} m, which is no distance")

    @property
    def nbytes(self) -> int:
        """The memory size of the parts and of their blocks for kernels [bytes]."""
        return sum(part.nbytes for part in self.parts) + len(self.parts) * 8 * (3 * COLUMNS + 2)

    @cached_property
    def packed(self) -> Packed:
        """The parts as blocks for kernels.

        Raises:
            ValueError: a part is empty, not (V, 3) float64, has more than 24 vertices or a value that is not finite.
        """
        blocks = np.empty((len(self.parts), 3, COLUMNS))
        sizes = np.empty(len(self.parts), np.int64)
        diameters = np.empty(len(self.parts))
        for index, part in enumerate(self.parts):
            require_vertices(part)
            blocks[index, :, : len(part)], blocks[index, :, len(part) :] = part.T, part[0][:, None]
            sizes[index] = -(-len(part) // 8) * 8
            diameters[index] = np.sqrt(((part[:, None] - part[None]) ** 2).sum(axis=2).max()) * (1 + 1e-12)
        return Packed(blocks, sizes, diameters)


def require_vertices(part: Array) -> None:
    """Raises an error unless an array is a valid part for kernels, which do not validate their inputs.

    Raises:
        ValueError: the array is not a valid part, see `Enclosure.packed`.
    """
    if part.dtype != np.float64 or part.ndim != 2 or part.shape[1] != 3 or not 1 <= len(part) <= COLUMNS:
        raise ValueError(
            f"a convex part is (V, 3) float64 with 1 to {COLUMNS} vertices, not {part.shape} {part.dtype}"
        )
    wrong = np.flatnonzero(~np.isfinite(part).all(axis=1))
    if len(wrong):
        raise ValueError(f"vertex {wrong[0]} of a convex part is not finite: {part[wrong[0]].tolist()}")


@dataclass(frozen=True, eq=False)
class MovingGroup:
    """A rigid body attached to a joint: a link, or an object in a gripper."""

    joint: int
    joint_T_group: Array  # (12,)
    enclosure: Enclosure
    mesh: Mesh | None = None  # the original, for exact views


@dataclass(frozen=True, eq=False)
class FixedGroup:
    """A rigid body that is fixed in the world."""

    world_T_group: Array  # (12,)
    enclosure: Enclosure
    mesh: Mesh | None = None


def poses_of(moving: Sequence[MovingGroup], fixed: Sequence[FixedGroup]) -> Array:
    """The poses (G, 12) of all groups in their joint's or the world's frame.

    Raises:
        ValueError: a pose is not 12 finite numbers.
    """
    rows = [np.asarray(g.joint_T_group, float) for g in moving] + [
        np.asarray(g.world_T_group, float) for g in fixed
    ]
    poses = np.array(rows, dtype=np.float64).reshape(len(rows), 12)
    if not np.isfinite(poses).all():
        raise ValueError("the pose of a group is not finite")
    return poses
