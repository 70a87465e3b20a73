"""Motions of bodies on a chain along straight joint-space segments, and their arrays for the kernels.

Links, tools and held objects are all bodies on a joint; a fixed body is a motion without joints.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.boxes import place_groups
from kabo.geometry.collision.kernels.tracks import turning
from kabo.geometry.collision.kernels.volumes import frames_on, part_bounds
from kabo.geometry.collision.view_arrays import chain_of, reach
from kabo.geometry.parts import FixedGroup, MovingGroup
from kabo.scene import KinematicTree

Segment = tuple[Array, Array]  # start and end (n,)


class PlacedParts(NamedTuple):
    """The parts of one body in its joint's frame."""

    blocks: Array  # (B, 3, K)
    sizes: Integers  # (B,)
    extents: Array  # (B, 6) centre and half extents
    radii: Array  # (B,) about the joint's origin [m]
    diameters: Array  # (B,) [m]


class Swept(NamedTuple):
    """A body that moves along a segment, as arrays for `kernels.volumes`."""

    poses: Array  # (N + 1, 12) of its joint, at the nodes
    blocks: Array
    sizes: Integers
    extents: Array
    bounds: Array  # (B, 3) deviation, angle * diameter / 4, diameter / 4


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
            (far[b.joint] + p.radii.max(initial=0.0) for b, p in zip(self.bodies, self.placed, strict=True)),
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
        lengths = np.linalg.norm(chain.placement[:, 9:], axis=1)
        segment, turned = np.array([start, end, start]), np.zeros(len(lengths))
        turning(segment, chain.joints, chain.factors, turned)
        frames = np.zeros((intervals + 1, len(lengths), 12))
        frames[:, 0, [0, 4, 8]] = 1.0
        frames_on(segment, chain.joints, chain.factors, chain.placement, frames)
        found = []
        for body, own in zip(self.bodies, self.placed, strict=True):
            bounds = np.empty((len(own.sizes), 3))
            part_bounds(
                *(segment, chain.joints, chain.factors, lengths, turned, body.joint),
                *(own.radii, own.diameters, bounds),
            )
            poses = np.ascontiguousarray(frames[:, body.joint])
            found.append(Swept(poses, own.blocks, own.sizes, own.extents, bounds))
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
    blocks, extents = np.zeros(packed.blocks.shape), np.empty((count, 6))
    starts = np.array([0, count], np.int64)
    place_groups(packed.blocks, packed.sizes, starts, pose, blocks, extents, np.empty((1, 6)), np.empty(1))
    radii = np.linalg.norm(blocks, axis=1).max(axis=1, initial=0.0) * (1.0 + 1e-12)
    return PlacedParts(blocks, packed.sizes, extents, radii, packed.diameters)


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
    groups = tuple(MovingGroup(0, body.world_T_group, body.enclosure, body.mesh) for body in bodies)
    return Motion(WORLD_TREE, groups, np.zeros((1, 0)))
