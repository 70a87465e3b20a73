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
