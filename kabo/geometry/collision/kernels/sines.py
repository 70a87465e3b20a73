"""Forward kinematics with all sines and cosines in one vectorised pass: the library computes them one by one."""

import numpy as np

from kabo.compilation import all_four, four, fused, joined_kernel, lean_kernel, put_four, times
from kabo.scene.kernels.poses import forward_kinematics

# Coefficients of Sun's fdlibm (__kernel_sin, __kernel_cos), right to the last place on |x| <= pi / 4.
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11
# pi / 2 in three parts with 33 bits each, whose products with numbers below 2^20 are exact.
HALF_PI_1, HALF_PI_2, HALF_PI_3 = 1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624871116645580e-21
QUADRANTS = 0.63661977236758134308  # 2 / pi
NEAREST = 6755399441055744.0  # 1.5 * 2^52: a sum with it is rounded to an integer
GREATEST_ANGLE = 1e5  # beyond it the angle in its quadrant loses places
REVOLUTE = 0  # a joint's kind


@lean_kernel  # (N,) f8 -> writes (N,) f8, (N,) f8
def sines_and_cosines(angles, sines, cosines):
    """Writes the sine and cosine of every angle of at most `GREATEST_ANGLE` [rad], wrong by less than 2^-52."""
    for i in range(angles.shape[0]):
        x = angles[i]
        turns = (x * QUADRANTS + NEAREST) - NEAREST
        r = ((x - turns * HALF_PI_1) - turns * HALF_PI_2) - turns * HALF_PI_3
        z = r * r
        s = r + r * z * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))))
        c = 1.0 - 0.5 * z + z * z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))))
        quadrant = np.int64(turns) & 3
        odd = (quadrant & 1) == 1
        sine, cosine = (c if odd else s), (s if odd else c)
        sines[i] = -sine if quadrant >= 2 else sine
        cosines[i] = -cosine if (quadrant == 1) | (quadrant == 2) else cosine


@joined_kernel  # (3, J) i8, (3, J) f8, (J * 24,) f8 -> writes (J * 12,) f8
def _compose(joints, angles, local, frames):
    """Writes the frames of all joints but the world's; parents come first."""
    for j in range(1, joints.shape[1]):
        s, c, slide = angles[1, j], angles[2, j], 0.0
        if joints[1, j] != REVOLUTE:
            s, c, slide = 0.0, 1.0, angles[0, j]
        kept, moved = (c, c, 1.0, 1.0), (s, -s, 0.0, slide)
        x = fused(four(local, 24 * j), kept, times(four(local, 24 * j + 12), moved))
        y = fused(four(local, 24 * j + 4), kept, times(four(local, 24 * j + 16), moved))
        z = fused(four(local, 24 * j + 8), kept, times(four(local, 24 * j + 20), moved))
        parent = 12 * joints[0, j]
        for r in range(3):
            at = parent + 4 * r
            origin = (0.0, 0.0, 0.0, frames[at + 3])
            row = fused(all_four(frames[at]), x, fused(all_four(frames[at + 1]), y, origin))
            put_four(frames, 12 * j + 4 * r, fused(all_four(frames[at + 2]), z, row))


@lean_kernel  # (J, 12) f8 -> writes (J * 12,) f8
def _interleave(world_T, frames):
    for j in range(world_T.shape[0]):
        for r in range(3):
            for k in range(3):
                frames[12 * j + 4 * r + k] = world_T[j, 3 * r + k]
            frames[12 * j + 4 * r + 3] = world_T[j, 9 + r]


@lean_kernel  # (n,) f8, Chain, (J * 24,) f8 -> writes (3, J) f8, (J, 12) f8, (J * 12,) f8
def frames_of(q, chain, local, angles, world_T, frames):
    """Writes the frames of all joints, each as three rows of a rotation's row and the origin's coordinate.

    They are those of `forward_kinematics` to the last place or two. `local`: see `local_frames`; `angles` are for joint
    values, their sines and cosines; `world_T` is used where the angles are too large to be reduced.
    """
    greatest, joints, factors = 0.0, chain.joints, chain.factors
    for j in range(1, joints.shape[1]):
        angles[0, j] = factors[0, j] * q[joints[2, j]] + factors[1, j]
        greatest = max(greatest, abs(angles[0, j]))
    if not greatest < GREATEST_ANGLE:
        forward_kinematics(q, joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, world_T)
        _interleave(world_T, frames)
        return
    sines_and_cosines(angles[0], angles[1], angles[2])
    _compose(joints, angles, local, frames)
