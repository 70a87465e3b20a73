"""Where the links of a robot are: the origins of their frames, without their turns."""

import numpy as np

from kabo.compilation import kernel
from kabo.scene.kernels.poses import forward_kinematics


@kernel  # (N, n) f8, KinematicTree, (L,) i8, (L, 3) f8 [m] -> (N, L, 3) f8 [m]
def origins_of(Q, tree, joints, offsets):
    """The places (N, L, 3) in the world of points that are fixed to joints, at every configuration."""
    world_T = np.zeros((tree.parent.shape[0], 12))
    world_T[0, 0], world_T[0, 4], world_T[0, 8] = 1.0, 1.0, 1.0
    found = np.empty((Q.shape[0], joints.shape[0], 3))
    for i in range(Q.shape[0]):
        forward_kinematics(
            Q[i], tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T
        )
        for k in range(joints.shape[0]):
            j = joints[k]
            for r in range(3):
                turned = 0.0
                for c in range(3):
                    turned += world_T[j, 3 * r + c] * offsets[k, c]
                found[i, k, r] = turned + world_T[j, 9 + r]
    return found


@kernel  # (N, n) f8, (n,) f8, i8, KinematicTree, (L,) i8, (L, 3) f8 [m] -> (N,) f8 [m]
def farthest_origins(Q, actual, planned, tree, joints, offsets):
    """How far any of the points is at each configuration from where it is at `actual`.

    The values of `Q` from `planned` on do not count: those of `actual` are taken.
    """
    count = Q.shape[0]
    rows, found = np.empty((count + 1, Q.shape[1])), np.zeros(count)
    rows[:count, :planned] = Q[:, :planned]
    rows[:count, planned:] = actual[planned:]
    rows[count] = actual
    there = origins_of(rows, tree, joints, offsets)
    for i in range(count):
        for k in range(joints.shape[0]):
            square = 0.0
            for r in range(3):
                square += (there[i, k, r] - there[count, k, r]) ** 2
            found[i] = max(found[i], square)
        found[i] = np.sqrt(found[i])
    return found
