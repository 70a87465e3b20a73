"""Bodies as convex parts, round ones too: enclosures, and groups of parts on a joint or standing in the world.

A part is the Minkowski sum of the hull of its corners, a ball and a flat disc: hulls need neither, a sphere is one
corner and a ball, a capsule two corners and a ball, a cylinder two corners and a disc across its axis, all exact.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.meshes import Rounding
from kabo.scene import Element

Mesh = tuple[Array, Integers]  # vertices (V, 3) [m], faces (F, 3)

COLUMNS = 64  # corners of a part at most: `farthest` has six bits for their numbers
LANE = 8  # columns of blocks are a multiple of it
AXIS_TOLERANCE = 1e-12  # by which the length of a disc's axis may differ from 1


SHARP = Rounding()  # of a part that is the hull of its corners


class Packed(NamedTuple):
    """The parts of an enclosure as arrays for kernels; unused columns repeat the first corner."""

    blocks: Array  # (B, 3, K), K the least multiple of 8 for the part with the most corners
    sizes: Integers  # (B,) multiples of 8: how many columns to read
    diameters: Array  # (B,) greatest distance of two points of the corners with the disc [m]; balls do not turn
    rounds: Array  # (B, 5) radius, disc [m], and the disc's axis


@dataclass(frozen=True, eq=False)
class Enclosure:
    """Convex parts whose union encloses a body, perhaps as a tree in which children cover what their part covers.

    No point of a part is farther from the body than the part's deviation. A part without children whose deviation
    is more than a caller can accept is *open*: `finer` makes its children.
    """

    parts: tuple[Array, ...]  # the corners of each (V <= 64, 3) [m], in the body's frame; roots first
    deviation: float  # the greatest one of a part without children [m]
    roundings: tuple[Rounding, ...] = ()  # of each part; empty: none is round
    deviations: tuple[float, ...] = ()  # of each part [m]; empty: `deviation` for all
    children: tuple[tuple[int, int], ...] = ()  # first child and number of children; empty: no part has any
    roots: int | None = None  # how many of the parts; None: all
    finer: Callable[[int], "Enclosure"] | None = (
        None  # the enclosure in which part i has children; always the same
    )

    def __post_init__(self) -> None:
        """Raises an error for what would silently enlarge epsilon, or make kernels read what is not there.

        Raises:
            ValueError: a deviation or a rounding is negative, or no number; the tree is none.
        """
        for deviation in (self.deviation, *self.deviations):
            if not deviation >= 0.0:
                raise ValueError(f"an enclosure deviates by {deviation:g} m, which is no distance")
        for name in ("roundings", "deviations", "children"):
            if len(getattr(self, name)) not in (0, len(self.parts)):
                raise ValueError(f"{len(self.parts)} parts have {len(getattr(self, name))} {name}")
        for rounding in self.roundings:
            _require_rounding(rounding)
        _require_tree(self)

    def rounding_of(self, part: int) -> Rounding:
        """The rounding of a part."""
        return self.roundings[part] if self.roundings else SHARP

    def deviation_of(self, part: int) -> float:
        """How far points of a part may be from the body [m]."""
        return self.deviations[part] if self.deviations else self.deviation

    def children_of(self, part: int) -> range:
        """The numbers of a part's children; none for a leaf."""
        first, count = self.children[part] if self.children else (0, 0)
        return range(first, first + count)

    @cached_property
    def every_deviation(self) -> Array:
        """How far points of each part may be from the body (B,) [m]."""
        return np.array(self.deviations or (self.deviation,) * len(self.parts), np.float64)

    @cached_property
    def every_child(self) -> Integers:
        """The first child and the number of children (B, 2) of each part; zeros for a leaf."""
        return np.array(self.children or [(0, 0)] * len(self.parts), np.int64).reshape(-1, 2)

    @cached_property
    def within(self) -> dict[float, Integers]:
        """What `children_within` has found for each deviation that was asked for [m]."""
        return {}

    @cached_property
    def deviation_of_roots(self) -> float:
        """How far points of the roots may be from the body [m]."""
        return max((self.deviation_of(part) for part in self.root_parts), default=0.0)

    @property
    def root_parts(self) -> range:
        """The numbers of the parts that cover the body and are children of none."""
        return range(len(self.parts) if self.roots is None else self.roots)

    def support(self, directions: Array) -> Array:
        """How far the roots reach in each of the unit directions (H, 3), from the origin of the body's frame (H,) [m]."""
        reached = np.full(len(directions), -np.inf)
        for index in self.root_parts:
            own = (directions @ self.parts[index].T).max(axis=1) + self.rounding_of(index).reach(directions)
            reached = np.maximum(reached, own)
        return reached

    def box_corners(self) -> Array:
        """The corners (8, 3) of the box around the body, in its own frame [m]."""
        high, low = self.support(np.eye(3)), -self.support(-np.eye(3))
        return np.array(
            [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
        )

    @property
    def nbytes(self) -> int:
        """The memory size of the parts and of their blocks for kernels [bytes]."""
        widest = _columns_for(max((len(part) for part in self.parts), default=0))
        return sum(part.nbytes for part in self.parts) + len(self.parts) * 8 * (3 * widest + 7)

    @cached_property
    def packed(self) -> Packed:
        """The parts as blocks for kernels.

        Raises:
            ValueError: a part is empty, not (V, 3) float64, has more than 64 corners or a value that is not finite.
        """
        found, rounded = self.unmeasured, map(self.rounding_of, range(len(self.parts)))
        return found._replace(diameters=np.fromiter(map(_diameter, self.parts, rounded), np.float64))

    @cached_property
    def unmeasured(self) -> Packed:
        """As `packed`, and raises as it, but without diameters, which proofs do not need: to find them takes longest."""
        for part in self.parts:
            require_vertices(part)
        count, widest = len(self.parts), _columns_for(max((len(part) for part in self.parts), default=0))
        blocks, rounds = np.empty((count, 3, widest)), np.zeros((count, 5))
        sizes = np.empty(count, np.int64)
        for index, part in enumerate(self.parts):
            blocks[index, :, : len(part)], blocks[index, :, len(part) :] = part.T, part[0][:, None]
            sizes[index] = _columns_for(len(part))
            rounding = self.rounding_of(index)
            rounds[index] = rounding.radius, rounding.disc, *rounding.axis
        return Packed(blocks, sizes, np.full(count, np.nan), rounds)


BALL_POINTS, DISC_POINTS = 256, 64  # of the polytope around a ball, and of the polygon around a disc


@cache
def ball_around() -> Array:
    """Points (256, 3) whose hull contains the ball of radius 1; they lie at most 2 % outside of it."""
    from scipy.spatial import ConvexHull

    number = np.arange(BALL_POINTS) + 0.5
    height, angle = 1.0 - 2.0 * number / BALL_POINTS, np.pi * (1.0 + np.sqrt(5.0)) * number
    across = np.sqrt(1.0 - height**2)
    points = np.column_stack([across * np.cos(angle), across * np.sin(angle), height])
    scaled: Array = points / -ConvexHull(points).equations[:, 3].max() * (1.0 + 1e-9)
    return scaled


def disc_around(axis: Sequence[float] | Array) -> Array:
    """Points (64, 3) whose hull contains the disc of radius 1 across an axis; they lie at most 0.2 % outside of it."""
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angle = 2.0 * np.pi * np.arange(DISC_POINTS) / DISC_POINTS
    points = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(axis, first)
    return np.asarray(points / np.cos(np.pi / DISC_POINTS) * (1.0 + 1e-9))


def points_around(part: Array, rounding: Rounding) -> Array:
    """Points (P, 3) whose hull contains a part: its corners, or corners of polytopes around its ball and its disc."""
    if rounding.disc:
        part = (part[:, None] + rounding.disc * disc_around(rounding.axis)[None]).reshape(-1, 3)
    if rounding.radius:
        part = (part[:, None] + rounding.radius * ball_around()[None]).reshape(-1, 3)
    return part


def body_points(enclosure: Enclosure) -> Array:
    """Points (P, 3) whose hull contains the body: those around all roots."""
    return np.concatenate(
        [points_around(enclosure.parts[i], enclosure.rounding_of(i)) for i in enclosure.root_parts]
    )


def _columns_for(corners: int) -> int:
    return max(LANE, -(-corners // LANE) * LANE)


def with_columns(blocks: Array, columns: int) -> Array:
    """Blocks (B, 3, K) with `columns` >= K columns; the added ones repeat the first corner."""
    more = columns - blocks.shape[2]
    return np.concatenate([blocks, np.repeat(blocks[:, :, :1], more, axis=2)], axis=2) if more else blocks


def stacked(packed: Sequence[Packed]) -> Packed:
    """The parts of several enclosures, one after the other, with the columns of the widest."""
    columns = max((own.blocks.shape[2] for own in packed), default=LANE)
    return Packed(
        np.concatenate([np.empty((0, 3, columns)), *(with_columns(own.blocks, columns) for own in packed)]),
        np.concatenate([np.empty(0, np.int64), *(own.sizes for own in packed)]),
        np.concatenate([np.empty(0), *(own.diameters for own in packed)]),
        np.concatenate([np.empty((0, 5)), *(own.rounds for own in packed)]),
    )


def _diameter(part: Array, rounding: Rounding) -> float:
    """An upper bound of the distance of two points of a part without its ball [m]."""
    between = part[:, None] - part[None]
    if not rounding.disc:
        return float(np.sqrt((between**2).sum(axis=2).max())) * (1 + 1e-12)
    across = np.linalg.norm(np.cross(between, rounding.axis), axis=2) + 2.0 * rounding.disc
    along = between @ np.array(rounding.axis)
    return float(np.sqrt((across**2 + along**2).max())) * (1 + 1e-12)


def _require_rounding(rounding: Rounding) -> None:
    if not (0.0 <= rounding.radius < np.inf and 0.0 <= rounding.disc < np.inf):
        raise ValueError(f"a part is rounded by {rounding.radius:g} m and {rounding.disc:g} m, which are no radii")
    if not abs(np.linalg.norm(rounding.axis) - 1.0) <= AXIS_TOLERANCE:
        raise ValueError(f"the axis {rounding.axis} of a disc does not have length 1")


def _require_tree(enclosure: Enclosure) -> None:
    """Raises an error unless each part is a root or the child of one part before it."""
    roots, count = len(enclosure.root_parts), len(enclosure.parts)
    follow = roots
    for part, (first, number) in enumerate(enclosure.children):
        if number < 0 or (number and not first > part):
            raise ValueError(f"the children of part {part} of an enclosure do not follow it")
        follow += number
    own = [i for part in range(count if enclosure.children else 0) for i in enclosure.children_of(part)]
    if follow != count or sorted(own) != list(range(roots, count)):
        raise ValueError(f"{count} parts are no tree: {roots} roots and {follow - roots} children")


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
    elements: tuple[Element, ...] = ()  # what the mesh lies around, if it is round; for exact views, too
    kept: float = 0.0  # [m]: a pair of bodies keeps the sum of both from each other, beyond the budget's clearance
    hand: int = 0  # bodies with the same number, other than 0, keep nothing from each other but the clearance


@dataclass(frozen=True, eq=False)
class FixedGroup:
    """A rigid body that is fixed in the world."""

    world_T_group: Array  # (12,)
    enclosure: Enclosure
    mesh: Mesh | None = None
    elements: tuple[Element, ...] = ()
    kept: float = 0.0  # [m], as of a moving group
    hand: int = 0


def poses_of(groups: Sequence[MovingGroup | FixedGroup]) -> Array:
    """The poses (G, 12) of groups in their joint's or the world's frame.

    Raises:
        ValueError: a pose is not 12 finite numbers.
    """
    rows = [each.joint_T_group if isinstance(each, MovingGroup) else each.world_T_group for each in groups]
    poses = np.array(rows, dtype=np.float64).reshape(len(rows), 12)
    if not np.isfinite(poses).all():
        raise ValueError("the pose of a group is not finite")
    return poses
