"""Collision on the original triangle meshes, through python-fcl: the exact alternative to a `CollisionView`.

The same questions on the same groups, for comparison and `--geometry exact`. Segments are sampled so densely that
no point of a body moves farther than 2 epsilon between samples: unlike a bounded sweep this proves nothing between.
"""

from collections.abc import Sequence

import fcl
import numpy as np
from numpy.typing import NDArray

from kabo.geometry.arrays import chain_of
from kabo.geometry.budget import Budget
from kabo.geometry.kernels.tracks import motion, turning
from kabo.geometry.parts import Array, FixedGroup, Mesh, MovingGroup, poses_of
from kabo.geometry.views import Counters
from kabo.scene import KinematicTree
from kabo.scene.kernels.poses import forward_kinematics


class ExactView:
    """Which pair of bodies touches, at a configuration or at samples of a segment; a view is for one thread."""

    def __init__(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: NDArray[np.int64],
        budget: Budget,
    ) -> None:
        """As `CollisionView`; every group needs its `mesh`.

        Raises:
            ValueError: a group without a mesh, or arrays of wrong values.
        """
        groups: list[MovingGroup | FixedGroup] = [*moving, *fixed]
        if any(group.mesh is None for group in groups):
            raise ValueError("an exact view needs the mesh of every group")
        self._chain, self._epsilon, self.counters = chain_of(tree), budget.epsilon, Counters()
        self._world_T = np.zeros((self._chain.joints.shape[1], 12))
        self._world_T[0, [0, 4, 8]] = 1.0
        self._joint = [group.joint for group in moving]
        self._poses = poses_of(moving, fixed)
        self._models = [_model(group.mesh) for group in groups if group.mesh]
        self._objects = [_object(m, p) for m, p in zip(self._models, self._poses, strict=True)]
        placed = [
            g.mesh[0] @ p[:9].reshape(3, 3).T + p[9:] for g, p in zip(moving, self._poses, strict=False) if g.mesh
        ]
        self._radii = np.array([np.linalg.norm(vertices, axis=1).max() for vertices in placed])
        self._pairs = np.asarray(pairs, np.int64).reshape(-1, 2)
        allowed = {(int(a), int(b)): number for number, (a, b) in reversed(list(enumerate(self._pairs)))}
        self._allowed = allowed | {(b, a): number for (a, b), number in allowed.items()}
        self._index = {id(model): index for index, model in enumerate(self._models)}
        self._moving, self._fixed = fcl.DynamicAABBTreeCollisionManager(), fcl.DynamicAABBTreeCollisionManager()
        self._moving.registerObjects(self._objects[: len(moving)])
        self._fixed.registerObjects(self._objects[len(moving) :])
        self._moving.setup()
        self._fixed.setup()

    def configuration_hit(self, q: Array) -> int:
        """-1 if no pair touches at q (n,), else the number of a pair that does.

        Raises:
            ValueError: q has another size, or is not finite.
        """
        self.counters.configuration_checks += 1
        return self._counted(self._hit(self._configuration(q)))

    def configurations_hit(self, configurations: Array) -> NDArray[np.int64]:
        """`configuration_hit` of every row (N, n)."""
        return np.array([self.configuration_hit(q) for q in configurations], np.int64)

    def segment_hit(self, start: Array, end: Array) -> int:
        """-1 if no pair touches at any sample of the straight segment, its ends included, else one that does.

        Raises:
            ValueError: as `configuration_hit`.
        """
        first, last = self._configuration(start), self._configuration(end)
        count = max(1, int(np.ceil(self._longest_path(first, last) / (2.0 * self._epsilon))))
        self.counters.sweep_checks += 1
        for i in range(count + 1):
            found = self._hit(first + i / count * (last - first))
            if found >= 0:
                return self._counted(found)
        return -1

    def _configuration(self, q: Array) -> Array:
        row = np.ascontiguousarray(q, np.float64)
        if row.shape != self._chain.bound.shape or not np.isfinite(row).all():
            raise ValueError(f"a configuration has {len(self._chain.bound)} finite values")
        return row

    def _counted(self, found: int) -> int:
        self.counters.positive += found >= 0
        return found

    def _hit(self, q: Array) -> int:
        joints, factors, placement, _ = self._chain
        forward_kinematics(q, joints[0], joints[1], joints[2], factors[0], factors[1], placement, self._world_T)
        for joint, pose, body in zip(self._joint, self._poses, self._objects, strict=False):
            world_R, group_R = self._world_T[joint, :9].reshape(3, 3), pose[:9].reshape(3, 3)
            body.setTransform(fcl.Transform(world_R @ group_R, world_R @ pose[9:] + self._world_T[joint, 9:]))
        self._moving.update()
        found = [-1]
        self._moving.collide(self._fixed, found, self._touches)
        if found[0] < 0:
            self._moving.collide(found, self._touches)
        return found[0]

    def _touches(self, first: fcl.CollisionObject, second: fcl.CollisionObject, found: list[int]) -> bool:
        """The broad phase's question; True ends it. Its objects are new wrappers: only contacts name the models."""
        result = fcl.CollisionResult()
        self.counters.pair_checks += 1
        if fcl.collide(first, second, fcl.CollisionRequest(), result) == 0:
            return False
        contact = result.contacts[0]
        found[0] = self._allowed.get((self._index[id(contact.o1)], self._index[id(contact.o2)]), -1)
        return found[0] >= 0

    def _longest_path(self, start: Array, end: Array) -> float:
        """A bound of how far any point of a moving body travels [m]."""
        joints, factors, placement, _ = self._chain
        segment, turned = np.array([start, end, start]), np.zeros(joints.shape[1])
        turning(segment, joints, factors, turned)
        lengths = np.linalg.norm(placement[:, 9:], axis=1)
        paths = [
            motion(segment, joints, factors, lengths, turned, joint, 0, radius)[2]
            for joint, radius in zip(self._joint, self._radii, strict=True)
        ]
        return max(paths, default=0.0)


def _model(mesh: Mesh) -> fcl.BVHModel:
    vertices, faces = mesh
    model = fcl.BVHModel()
    model.beginModel(len(vertices), len(faces))
    model.addSubModel(np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int64))
    model.endModel()
    return model


def _object(model: fcl.BVHModel, pose: Array) -> fcl.CollisionObject:
    return fcl.CollisionObject(model, fcl.Transform(pose[:9].reshape(3, 3), pose[9:]))
