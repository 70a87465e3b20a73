"""Forward kinematics of a tree given as flat arrays; a pose is 12 numbers, rotation row-major, then translation."""

import numpy as np

from kabo.compilation import lean_kernel


@lean_kernel  # (n,) f8, (J,) i8, (J,) i8, (J,) i8, (J,) f8, (J,) f8, (J, 12) f8 -> writes world_T (J, 12) f8
def forward_kinematics(q, parent, kind, source, ratio, shift, placement, world_T):
    """Writes the pose of every joint frame in the world; row 0 of `world_T` must be the identity."""
    for j in range(1, parent.shape[0]):
        p = parent[j]
        value = ratio[j] * q[source[j]] + shift[j]
        if kind[j] == 0:
            c, s, slide = np.cos(value), np.sin(value), 0.0
        else:
            c, s, slide = 1.0, 0.0, value
        for r in range(3):
            a, b, d = world_T[p, 3 * r], world_T[p, 3 * r + 1], world_T[p, 3 * r + 2]
            x = a * placement[j, 0] + b * placement[j, 3] + d * placement[j, 6]
            y = a * placement[j, 1] + b * placement[j, 4] + d * placement[j, 7]
            z = a * placement[j, 2] + b * placement[j, 5] + d * placement[j, 8]
            world_T[j, 3 * r] = x * c + y * s
            world_T[j, 3 * r + 1] = y * c - x * s
            world_T[j, 3 * r + 2] = z
            origin = a * placement[j, 9] + b * placement[j, 10] + d * placement[j, 11] + world_T[p, 9 + r]
            world_T[j, 9 + r] = origin + z * slide
