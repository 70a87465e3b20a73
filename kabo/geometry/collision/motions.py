"""Motions of bodies on a chain along straight joint-space segments, and their arrays for the kernels.

Links, tools and held objects are all bodies on a joint; a fixed body is a motion without joints.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from kabo.arrays import Array
from kabo.geometry.collision.kernels.boxes import place_groups
from kabo.geometry.collision.kernels.bundles import DISC, EXTENT_COLUMNS, Extents, Hulls, Swept
from kabo.geometry.collision.kernels.tracks import turning
from kabo.geometry.collision.kernels.volumes import frames_on, part_bounds
from kabo.geometry.collision.view_arrays import chain_of, reach, way_of
from kabo.geometry.parts import FixedGroup, MovingGroup
from kabo.scene import KinematicTree

Segment = tuple[Array, Array]  # start and end (n,)


class PlacedParts(NamedTuple):
    """The parts of one body in its joint's frame."""

    hulls: Hulls
    extents: Array  # (B, 8) as in `Extents`
    radii: Array  # (B,) of corners and discs about the joint's origin [m]
    diameters: Array  # (B,) of corners and discs [m]
    far: float  # how far any point is from the joint's origin [m]


@dataclass(frozen=True, eq=False)
class Motion:
    """Bodies on a kinematic chain that moves from waypoint to waypoint, straight in joint space."""

    tree: KinematicTree
    bodies: tuple[MovingGroup, ...]
    waypoints: Array  # (W, n), W >= 1

    def __post_init__(self) -> None:
        """Checks that the waypoints are configurations of the tree.

        Raises:
            ValueError: another shape, a value that is not finite or far out of a sliding joint's limits, a tree
                with a sliding joint without limits, a body on a joint that is not there.
        """
        rows = np.ascontiguousarray(self.waypoints, np.float64)
        if rows.ndim != 2 or len(rows) == 0 or rows.shape[1] != self.tree.size:
            raise ValueError(f"waypoints are (W, {self.tree.size}) with W >= 1, not {rows.shape}")
        if not (np.abs(rows) <= chain_of(self.tree).bound).all():
            raise ValueError("a waypoint is not finite, or out of the limits of a sliding joint")
        if any(not 0 <= body.joint < len(self.tree.parent) for body in self.bodies):
            raise ValueError("a body hangs on a joint that the tree does not have")
        object.__setattr__(self, "waypoints", rows)

    @property
    def deviation(self) -> float:
        """The greatest deviation of the bodies' enclosures [m]."""
        return max((body.enclosure.deviation for body in self.bodies), default=0.0)

    @property
    def reach(self) -> float:
        """An upper bound of the distance of any vertex from the world's origin [m]."""
        far = reach(chain_of(self.tree))
        return max(
            (far[b.joint] + p.far for b, p in zip(self.bodies, self.placed, strict=True)),
            default=0.0,
        )

    @cached_property
    def placed(self) -> list[PlacedParts]:
        """The parts of every body.

        Raises:
            ValueError: vertices or poses are not finite.
        """
        return [placed(body) for body in self.bodies]

    @property
    def segments(self) -> list[Segment]:
        """Start and end of every straight segment; a single waypoint gives one segment of length 0."""
        if len(self.waypoints) == 1:
            return [(self.waypoints[0], self.waypoints[0])]
        return list(zip(self.waypoints, self.waypoints[1:], strict=False))

    def swept(self, start: Array, end: Array, intervals: int) -> list[Swept]:
        """Every body on a straight segment, with poses at the nodes of 2^k intervals (one interval if it stands still)."""
        chain = chain_of(self.tree)
        way = way_of(chain, np.zeros((intervals + 1, len(self.tree.parent), 12)))
        way.segment[:] = start, end, start
        turning(way, chain)
        frames_on(way, chain)
        found = []
        for body, own in zip(self.bodies, self.placed, strict=True):
            bounds = np.empty((len(own.radii), 3))
            part_bounds(way, chain, body.joint, own.radii, own.diameters, bounds)
            poses = np.ascontiguousarray(way.frames[:, body.joint])
            found.append(Swept(poses, own.hulls, own.extents, bounds))
        return found


def placed(body: MovingGroup) -> PlacedParts:
    """The parts of a body in its joint's frame.

    Raises:
        ValueError: vertices or a pose are not finite.
    """
    packed = body.enclosure.packed
    pose = np.asarray(body.joint_T_group, np.float64).reshape(1, -1)
    if pose.shape != (1, 12) or not np.isfinite(pose).all():
        raise ValueError("the pose of a body is not 12 finite numbers")
    count = len(packed.sizes)
    hulls = Hulls(np.zeros(packed.blocks.shape), np.zeros(count, np.int64), np.zeros((count, 5)))
    extents = Extents(np.zeros((count, EXTENT_COLUMNS)), np.zeros((1, EXTENT_COLUMNS)))
    groups = np.array([[0, 0], [0, count], [0, 0], [count, 0]], np.int64)
    far = np.empty((1, 2))
    place_groups(Hulls(packed.blocks, packed.sizes, packed.rounds), groups, pose, hulls, extents, far)
    radii = np.linalg.norm(hulls.blocks, axis=1).max(axis=1, initial=0.0) * (1.0 + 1e-12) + packed.rounds[:, DISC]
    return PlacedParts(hulls, extents.parts, radii, packed.diameters, float(far[0, 1]))


_STANDING: "WeakKeyDictionary[FixedGroup, PlacedParts]" = WeakKeyDictionary()


def standing_parts(body: FixedGroup) -> PlacedParts:
    """The parts of a fixed body in the world, computed once for each body object.

    Raises:
        ValueError: as `placed`.
    """
    known = _STANDING.get(body)
    if known is None:
        known = _STANDING[body] = placed(MovingGroup(0, body.world_T_group, body.enclosure))
    return known


def _nothing() -> KinematicTree:
    whole, none, one = np.zeros(1, np.int64), np.empty(0), np.zeros(1)
    world = np.array([[1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]])
    return KinematicTree(whole, whole, whole, one, one, world, none, none, none)


WORLD_TREE = _nothing()  # the world alone, for standing bodies


def standing(*bodies: FixedGroup) -> Motion:
    """A motion in which the given fixed bodies stand still."""
    groups = tuple(MovingGroup(0, body.world_T_group, body.enclosure, body.mesh, body.elements) for body in bodies)
    return Motion(WORLD_TREE, groups, np.zeros((1, 0)))
