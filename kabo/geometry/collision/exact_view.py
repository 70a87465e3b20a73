"""Collision on the original meshes and round shapes, through python-fcl: the exact alternative to a `CollisionView`.

It has the same methods on the same groups, for comparison and for `--geometry exact`. Only given pairs whose boxes
meet reach python-fcl; a body wholly inside another one collides, too. Segments are proven free by distances of the
meshes and bounds of their motion, halving segments as needed, so that both geometries guarantee that no collision
is overlooked.
"""

from collections.abc import Iterator, Sequence
from functools import cache

import fcl
import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.collision_view import Counters
from kabo.geometry.collision.exact_surfaces import Surface, distance, placed, surface_of, surrounds, touch
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.geometry.collision.kernels.tracks import motion, turning
from kabo.geometry.collision.view_arrays import chain_of, last_shared_joints, usable_deviations, way_of
from kabo.geometry.parts import FixedGroup, MovingGroup, poses_of
from kabo.scene import KinematicTree
from kabo.scene.kernels.poses import forward_kinematics

BOX_SLACK = 1e-12  # [m] added to boxes against rounding


class ExactView:
    """Finds a pair of bodies that collides, at a configuration or along a straight joint-space segment.

    Not safe for use by several threads at once.
    """

    def __init__(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: Integers,
        budget: Budget,
    ) -> None:
        """As `CollisionView`; every group needs its `mesh`.

        Raises:
            ValueError: a group without a mesh, or arrays of wrong values.
        """
        groups: list[MovingGroup | FixedGroup] = [*moving, *fixed]
        if any(group.mesh is None for group in groups):
            raise ValueError("an exact view needs the mesh of every group")
        self._chain, self.counters = chain_of(tree), Counters()
        self._least = 0.5 * budget.clearance  # what a bounded view calls free, this one does too
        self._frames = np.zeros((self._chain.joints.shape[1], 12))
        self._frames[0, [0, 4, 8]] = 1.0
        self._joint, self._moving = np.array([group.joint for group in moving], np.int64), len(moving)
        self._surfaces = [surface_of(group) for group in groups]
        self._pairs = np.asarray(pairs, np.int64).reshape(-1, 2)
        self._first, self._second = (np.ascontiguousarray(column) for column in self._pairs.T)
        joints = np.concatenate([self._joint, np.zeros(len(fixed), np.int64)])
        self._carriers = last_shared_joints(self._chain, joints[self._first], joints[self._second]).tolist()
        kept = np.array([group.kept for group in groups])
        hand = np.array([group.hand for group in groups])
        same = (hand[self._first] == hand[self._second]) & (hand[self._first] > 0)
        self._kept = np.where(same, 0.0, kept[self._first] + kept[self._second])
        self._place(poses_of([*moving, *fixed]))
        poses = np.column_stack([self._world_R.reshape(-1, 9), self._world_t])
        self._bodies = [placed(surface, pose) for surface, pose in zip(self._surfaces, poses, strict=True)]
        self._placed: set[int] = set()  # moving groups whose fcl body is where the group is
        self._corners = np.zeros((len(groups), max((len(s.corners) for s in self._surfaces), default=1), 3))
        for corners, surface in zip(self._corners, self._surfaces, strict=True):
            corners[:] = surface.corners[0]  # padded with the first one
            corners[: len(surface.corners)] = surface.corners

    def _place(self, poses: Array) -> None:
        """Computes the poses of all groups in their joint's frame, and the boxes of their meshes there."""
        self._rotation, self._translation = poses[:, :9].reshape(-1, 3, 3), poses[:, 9:]
        vertices = [s.vertices @ p[:9].reshape(3, 3).T + p[9:] for s, p in zip(self._surfaces, poses, strict=True)]
        low = np.array([own.min(axis=0) for own in vertices]).reshape(-1, 3)
        high = np.array([own.max(axis=0) for own in vertices]).reshape(-1, 3)
        self._radii = np.array([np.linalg.norm(own, axis=1).max() for own in vertices[: self._moving]])
        self._centre, self._half = 0.5 * (low + high), 0.5 * (high - low) + BOX_SLACK
        self._low, self._high = low - BOX_SLACK, high + BOX_SLACK
        self._world_R, self._world_t = self._rotation.copy(), self._translation.copy()

    def configuration_hit(self, q: Array) -> int:
        """-1 if no pair collides at q (n,), else the index of the first pair that does.

        Raises:
            ValueError: q has the wrong size, or is not finite.
        """
        self.counters.configuration_checks += 1
        return self._counted(self._hit(self._configuration(q)))

    @property
    def kernel_checks(self) -> None:
        """There are no kernels for these checks."""

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n)."""
        return np.array([self.configuration_hit(q) for q in configurations], np.int64)

    def surfaces_touch(self, q: Array, pair: int) -> bool:
        """Whether the surfaces of the pair with this index share a point at q (n,); False if one body is inside the other.

        Raises:
            ValueError: as `configuration_hit`.
        """
        self._set(self._configuration(q))
        return bool(self._gaps(np.array([pair])) <= 0.0) and self._touch(pair)

    def segment_hit(self, start: Array, end: Array, deviation: Array | None = None) -> int:
        """-1 if all pairs are proven apart on the whole straight segment, else the index of a pair that is not.

        A pair is apart on an interval if its distance at the middle exceeds the relative travel of both bodies to
        either end [K 4.5], and what they keep and stray; otherwise the interval is halved, until a pair is nearer than
        `_least` beyond that.

        Raises:
            ValueError: as `CollisionView.segment_hit`.
        """
        first, last = self._configuration(start), self._configuration(end)
        self.counters.sweep_checks += 1
        paths, kept = self._relative_paths(first, last, deviation)
        kept += self._kept
        stretches = [(0.0, 1.0, np.arange(len(self._pairs)))]
        while stretches:
            low, high, pairs = stretches.pop()
            middle, reach = 0.5 * (low + high), 0.5 * (high - low) * paths
            self._set(first + middle * (last - first))
            near = pairs[self._gaps(pairs) <= reach[pairs] + kept[pairs]]
            inside = self._nested(near) if len(near) else FREE
            if inside >= 0:
                return self._counted(inside)
            left = np.array(
                [pair for pair in near.tolist() if self._distance(pair) <= reach[pair] + kept[pair]], np.int64
            )
            if len(left) and (reach[left] <= self._least).any():
                return self._counted(int(left[reach[left] <= self._least][0]))
            if len(left):
                stretches += [(middle, high, left), (low, middle, left)]
        return FREE

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n)."""
        return np.array([self.segment_hit(*row) for row in zip(starts, ends, deviations, strict=True)], np.int64)

    def segments_free_early(self, starts: Array, ends: Array, deviations: Array) -> Booleans:
        """Whether each row (N,) is free: meshes are not divided."""
        return np.asarray(self.segments_hit(starts, ends, deviations) < 0)

    def _configuration(self, q: Array) -> Array:
        row = np.ascontiguousarray(q, np.float64)
        if row.shape != self._chain.bound.shape or not np.isfinite(row).all():
            raise ValueError(f"a configuration has {len(self._chain.bound)} finite values")
        return row

    def _counted(self, found: int) -> int:
        self.counters.positive += found >= 0
        return found

    def _hit(self, q: Array) -> int:
        near = self._near(q)
        for number in near.tolist():
            if self._touch(number) or (self._kept[number] > 0.0 and self._distance(number) <= self._kept[number]):
                return int(number)
        return self._nested(near) if len(near) else FREE

    def _near(self, q: Array) -> Integers:
        """The indices of the pairs whose boxes meet at q, or are nearer than they keep, in order."""
        self._set(q)
        return np.flatnonzero(self._gaps(np.arange(len(self._pairs))) <= self._kept)

    def _set(self, q: Array) -> None:
        """Moves the boxes and poses of all groups to q."""
        joints, factors, placement, _ = self._chain
        forward_kinematics(q, joints[0], joints[1], joints[2], factors[0], factors[1], placement, self._frames)
        count, frames = self._moving, self._frames[self._joint]
        turned, moved = frames[:, :9].reshape(-1, 3, 3), frames[:, 9:]
        centre = np.einsum("gij,gj->gi", turned, self._centre[:count]) + moved
        half = np.einsum("gij,gj->gi", np.abs(turned), self._half[:count])
        self._low[:count], self._high[:count] = centre - half, centre + half
        np.matmul(turned, self._rotation[:count], out=self._world_R[:count])
        self._world_t[:count] = np.einsum("gij,gj->gi", turned, self._translation[:count]) + moved
        self._placed.clear()

    def _gaps(self, pairs: Integers) -> Array:
        """The distances of the pairs' boxes [m], 0 where they meet: lower bounds of the bodies' distances."""
        first, second = self._first[pairs], self._second[pairs]
        apart = np.maximum(self._low[first] - self._high[second], self._low[second] - self._high[first])
        distances: Array = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
        return distances

    def _bodies_of(self, number: int) -> Iterator[tuple[Surface, list[fcl.CollisionObject]]]:
        """The two bodies of a pair, their cores at their poses."""
        self.counters.pair_checks += 1
        for group in (int(self._first[number]), int(self._second[number])):
            if group < self._moving and group not in self._placed:
                self._placed.add(group)
                at = fcl.Transform(self._world_R[group], self._world_t[group])
                for core in self._bodies[group]:
                    core.setTransform(at)
            yield self._surfaces[group], self._bodies[group]

    def _distance(self, number: int) -> float:
        """The distance of the surfaces of a pair [m], not positive where they meet."""
        (first, ours), (second, theirs) = self._bodies_of(number)
        return distance(first, ours, second, theirs)

    def _touch(self, number: int) -> bool:
        """Whether the surfaces of a pair share a point."""
        (first, ours), (second, theirs) = self._bodies_of(number)
        return touch(first, ours, second, theirs)

    def _nested(self, near: Integers) -> int:
        """The first pair in which one body contains a component of the other, for pairs whose surfaces do not meet."""
        points = np.einsum("gij,gcj->gci", self._world_R, self._corners) + self._world_t[:, None]
        first, second = self._first[near], self._second[near]
        for outer, inner in ((first, second), (second, first)):
            within = (self._low[outer, None] <= points[inner]) & (points[inner] <= self._high[outer, None])
            for k in np.flatnonzero(within.all(axis=2).any(axis=1)).tolist():
                body = int(outer[k])
                local = (points[inner[k]] - self._world_t[body]) @ self._world_R[body]
                if surrounds(self._surfaces[body], local):
                    return int(near[k])
        return FREE

    def _relative_paths(self, start: Array, end: Array, deviation: Array | None) -> tuple[Array, Array]:
        """Upper bounds of how far points of each pair's bodies travel relative to each other, and stray [m]."""
        way = way_of(self._chain, np.zeros((1, self._chain.joints.shape[1], 12)))
        way.segment[:] = start, end, start
        if deviation is not None:
            way.strays[:] = usable_deviations(np.asarray(deviation)[None], len(way.strays))[0]
        turning(way, self._chain)

        @cache
        def path(group: int, frame: int) -> Array:
            if group >= self._moving:
                return np.zeros(2)
            joint, radius = int(self._joint[group]), float(self._radii[group])
            return np.array(motion(way, self._chain, joint, frame, radius)[2:])

        both = [
            path(first, frame) + path(second, frame)
            for (first, second), frame in zip(self._pairs.tolist(), self._carriers, strict=True)
        ]
        paths, strays = np.array(both).reshape(-1, 2).T.copy()
        return paths, strays
