"""Comparison of oriented boxes: boxes of parts and groups in their joint's frame, along the axes of both frames.

A pair of bodies is compared in the frame of the first: boxes that rotate with their bodies are tighter than boxes
along the world's axes, and only pairs that need it are transformed. The edges' nine cross products [Gottschalk
1996] would exclude a tenth more pairs, and cost more than a search for an axis.
"""

from kabo.compilation import joined_kernel


@joined_kernel  # (J, 12) f8, i8, i8 -> writes (12,) f8
def relative(world_T, first, second, pose):
    """Writes first_T_second, the pose of joint `second` in the frame of joint `first`."""
    for r in range(3):
        a, b, c = world_T[first, r], world_T[first, 3 + r], world_T[first, 6 + r]
        for k in range(3):
            pose[3 * r + k] = a * world_T[second, k] + b * world_T[second, 3 + k] + c * world_T[second, 6 + k]
        x, y = world_T[second, 9] - world_T[first, 9], world_T[second, 10] - world_T[first, 10]
        pose[9 + r] = a * x + b * y + c * (world_T[second, 11] - world_T[first, 11])


@joined_kernel  # (12,) f8 first_T_second, (S, 6) f8 centre and half extents, i8, (S, 6) f8, i8, f8 [m] -> bool
def faces_near(pose, first, a, second, b, margin):
    """Whether no axis of either box proves two oriented boxes farther apart than `margin`; True if a number is NaN."""
    x, y, z = second[b, 0], second[b, 1], second[b, 2]
    ex, ey, ez = second[b, 3], second[b, 4], second[b, 5]
    dx = pose[0] * x + pose[1] * y + pose[2] * z + pose[9] - first[a, 0]
    dy = pose[3] * x + pose[4] * y + pose[5] * z + pose[10] - first[a, 1]
    dz = pose[6] * x + pose[7] * y + pose[8] * z + pose[11] - first[a, 2]
    hx, hy, hz = first[a, 3], first[a, 4], first[a, 5]
    apart = abs(dx) - (abs(pose[0]) * ex + abs(pose[1]) * ey + abs(pose[2]) * ez) > hx + margin
    apart |= abs(dy) - (abs(pose[3]) * ex + abs(pose[4]) * ey + abs(pose[5]) * ez) > hy + margin
    apart |= abs(dz) - (abs(pose[6]) * ex + abs(pose[7]) * ey + abs(pose[8]) * ez) > hz + margin
    u = pose[0] * dx + pose[3] * dy + pose[6] * dz
    v = pose[1] * dx + pose[4] * dy + pose[7] * dz
    w = pose[2] * dx + pose[5] * dy + pose[8] * dz
    apart |= abs(u) - (abs(pose[0]) * hx + abs(pose[3]) * hy + abs(pose[6]) * hz) > ex + margin
    apart |= abs(v) - (abs(pose[1]) * hx + abs(pose[4]) * hy + abs(pose[7]) * hz) > ey + margin
    apart |= abs(w) - (abs(pose[2]) * hx + abs(pose[5]) * hy + abs(pose[8]) * hz) > ez + margin
    return not apart
