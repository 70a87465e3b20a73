"""Joins several kinematic trees into one, whose joint vector holds the values of all robots [K Eq. 5.1].

Projection, sampling and proofs work on one tree, whichever robots its joints belong to. A free body is represented
by a tree of six joints.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kabo.kinematics.constraints import FrameFeature
from kabo.scene.tree import PRISMATIC, REVOLUTE, KinematicTree

FREE_BODY_RANGE = 10.0  # [m] from the world's origin, along each axis


@dataclass(frozen=True)
class JoinedTree:
    """One tree made of several in the same world, and the indices of each part in it."""

    tree: KinematicTree
    joints: tuple[int, ...]  # joint j > 0 of part k is joint j + joints[k]; joint 0 stays the world
    values: tuple[slice, ...]  # of the configuration of part k in that of the whole

    def joint(self, part: int, joint: int) -> int:
        """The index in the joined tree of joint `joint` of part `part`."""
        return joint + self.joints[part] if joint > 0 else 0

    def feature(self, part: int, feature: FrameFeature) -> FrameFeature:
        """A feature on a joint of part `part`, as a feature on the joined tree."""
        return replace(feature, joint=self.joint(part, feature.joint))


def joined(trees: Sequence[KinematicTree]) -> JoinedTree:
    """One tree with the joints of several, in their order; configurations are concatenated.

    Raises:
        ValueError: there is no tree.
    """
    if not trees:
        raise ValueError("no trees to join")
    sizes = [len(tree.parent) - 1 for tree in trees]
    joints = [sum(sizes[:k]) for k in range(len(trees))]
    ends = np.cumsum([tree.size for tree in trees]).tolist()
    values = tuple(slice(end - tree.size, end) for end, tree in zip(ends, trees, strict=True))
    parents, sources = [trees[0].parent[:1]], [trees[0].source[:1]]
    for tree, first, place in zip(trees, joints, values, strict=True):
        parents.append(np.where(tree.parent[1:] > 0, tree.parent[1:] + first, 0))
        sources.append(tree.source[1:] + place.start)
    whole = KinematicTree(
        np.concatenate(parents).astype(np.int64),
        *(np.concatenate(parts) for parts in ([trees[0].kind[:1], *(t.kind[1:] for t in trees)], sources)),
        *(
            np.concatenate([getattr(trees[0], name)[:1], *(getattr(tree, name)[1:] for tree in trees)])
            for name in ("ratio", "shift", "placement")
        ),
        *(np.concatenate([getattr(tree, name) for tree in trees]) for name in ("lower", "upper", "velocity")),
    )
    return JoinedTree(whole, tuple(joints), values)


def free_body() -> KinematicTree:
    """The tree of a body that may be anywhere: prismatic joints along x, y, z, then revolute ones about x, y, z."""
    axes = [np.eye(3)[:, [1, 2, 0]], np.eye(3)[:, [2, 0, 1]], np.eye(3)]  # rotations that take z to x, to y, to z
    placement = np.zeros((7, 12))
    placement[0, [0, 4, 8]] = 1.0
    before = np.eye(3)
    for j, turn in enumerate([*axes, *axes], 1):
        placement[j, :9] = (before.T @ turn).ravel()
        before = turn
    count = np.arange(7)
    span = np.array([FREE_BODY_RANGE, FREE_BODY_RANGE, FREE_BODY_RANGE, np.pi, np.pi, np.pi])
    kind = np.array([REVOLUTE, *[PRISMATIC] * 3, *[REVOLUTE] * 3], dtype=np.int64)
    source, ratio = np.maximum(count - 1, 0), (count > 0).astype(np.float64)
    return KinematicTree(
        np.maximum(count - 1, 0), kind, source, ratio, np.zeros(7), placement, -span, span, np.ones(6)
    )


FREE_BODY = free_body()
