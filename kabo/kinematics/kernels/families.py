"""Families of poses that fulfil constraint rows, as charts: parameters in, a pose of one frame relative to another out.

What the equalities of a grasp, a placement or a mate leave free is nearly always a turn about a line, or any turn about
a point, followed by translations. So all their poses are written down without iterating, and parameters that are drawn
evenly give poses that lie evenly.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.compilation import kernel, lean_kernel
from kabo.kinematics.kernels.rows import (
    LOWER,
    TOLERANCE,
    UPPER,
    position_value,
    row_value,
)

FIXED, ONE_TURN, ANY_TURN = 0, 1, 2  # what the rows leave of the orientation
MOST_SHARES = 6  # numbers that choose a pose: aims, one or three of the turn, translations


class Family(NamedTuple):
    """All poses a_T_b of frame 1 in frame 0 that fulfil the equalities of rows: C connected sets of them."""

    starts: Array  # (C, 12) a pose of each set
    turn: int  # FIXED, ONE_TURN or ANY_TURN
    axes: Array  # (C, 6) direction of the turn and a point that it leaves where it is, at the start
    zeros: Array  # (C, 2) azimuth at the start [rad], and by how much the turn changes it (1 or -1)
    azimuths: Array  # (A, W) at most one row, which the turn aims at
    aimed: Array  # (P, W) rows of heights above planes of frame 0, which translations aim at
    gains: Array  # (P, 3) the translation that changes one of these heights by 1 m
    loose: Array  # (L, 3) unit vectors of the other translations
    checked: Array  # (O, W) rows with intervals that nothing aims at


@lean_kernel  # (12,) f8, (12,) f8 -> writes (12,) f8
def compose(a, b, product):
    """Writes the pose a·b."""
    for r in range(3):
        x, y, z = a[3 * r], a[3 * r + 1], a[3 * r + 2]
        for c in range(3):
            product[3 * r + c] = x * b[c] + y * b[3 + c] + z * b[6 + c]
        product[9 + r] = x * b[9] + y * b[10] + z * b[11] + a[9 + r]


@lean_kernel  # (12,) f8, (6,) f8, four f8 -> writes (12,) f8
def turn_about(start, axis, quaternion, pose):
    """Writes a pose turned by a unit quaternion (w, x, y, z) about the point of an axis."""
    w, x, y, z = quaternion
    turn = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    u, v, n = start[9] - axis[3], start[10] - axis[4], start[11] - axis[5]
    for r in range(3):
        a, b, d = turn[r]
        for c in range(3):
            pose[3 * r + c] = a * start[c] + b * start[3 + c] + d * start[6 + c]
        pose[9 + r] = axis[3 + r] + a * u + b * v + d * n


@lean_kernel  # Family, i8, (6,) f8, i8 -> four f8
def turn_of(family, component, shares, first):
    """The quaternion of the turn that shares in [0, 1), from index `first` on, choose: even over angles or rotations."""
    if family.turn == FIXED:
        return 1.0, 0.0, 0.0, 0.0
    if family.turn == ONE_TURN:
        angle = 2.0 * np.pi * shares[first]
        if family.azimuths.shape[0] > 0:
            low, high = family.azimuths[0, LOWER], family.azimuths[0, UPPER]
            angle = low + shares[first] * (high - low) - family.zeros[component, 0]
            angle *= family.zeros[component, 1]
        c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
        axis = family.axes[component]
        return c, s * axis[0], s * axis[1], s * axis[2]
    # [Shoemake 1992]: uniform over all rotations
    small, large = np.sqrt(1.0 - shares[first]), np.sqrt(shares[first])
    one, other = 2.0 * np.pi * shares[first + 1], 2.0 * np.pi * shares[first + 2]
    return small * np.sin(one), small * np.cos(one), large * np.sin(other), large * np.cos(other)


@lean_kernel  # Family, i8, (6,) f8, (3,) f8, f8, (2, 12) f8, (6,) f8 -> bool; writes frames[1]
def draw_pose(family, component, shares, centre, reach, frames, wrench):
    """Writes the pose that shares in [0, 1) choose; returns whether the checked rows hold and it is within reach.

    Shares are, in this order: of each aimed height, of the turn, of each loose translation, which covers `reach` [m]
    on both sides of `centre` (3,). `frames[0]` must be the identity.
    """
    aims = family.aimed.shape[0]
    pose = frames[1]
    turn_about(family.starts[component], family.axes[component], turn_of(family, component, shares, aims), pose)
    x, y, z = 0.0, 0.0, 0.0
    for k in range(aims):
        row = family.aimed[k]
        off = row[LOWER] + shares[k] * (row[UPPER] - row[LOWER]) - position_value(row, frames, wrench)
        x, y, z = x + off * family.gains[k, 0], y + off * family.gains[k, 1], z + off * family.gains[k, 2]
    pose[9], pose[10], pose[11] = pose[9] + x, pose[10] + y, pose[11] + z
    last = aims + (family.turn if family.turn < ANY_TURN else 3)
    for k in range(family.loose.shape[0]):
        way = (2.0 * shares[last + k] - 1.0) * reach
        for c in range(3):
            way += family.loose[k, c] * (centre[c] - pose[9 + c])
        for c in range(3):
            pose[9 + c] += way * family.loose[k, c]
    x, y, z = pose[9] - centre[0], pose[10] - centre[1], pose[11] - centre[2]
    return x * x + y * y + z * z <= reach * reach and rows_hold(family.checked, frames, wrench)


@lean_kernel  # (R, W) f8, (2, 12) f8, (6,) f8 -> bool
def rows_hold(rows, frames, wrench):
    """Whether every row holds, within its tolerance, at the poses of two frames."""
    for k in range(rows.shape[0]):
        row = rows[k]
        value = row_value(row, frames, wrench)
        if not row[LOWER] - row[TOLERANCE] <= value <= row[UPPER] + row[TOLERANCE]:
            return False
    return True


@kernel  # (R, W) f8, (N, 12) f8 -> (N, R) f8, (N, R, 6) f8
def rows_at(rows, poses):
    """The values of rows at poses of frame 1 in frame 0, and the wrench of each."""
    frames = np.zeros((2, 12))
    frames[0, 0], frames[0, 4], frames[0, 8] = 1.0, 1.0, 1.0
    values, wrenches = np.empty((poses.shape[0], rows.shape[0])), np.empty((poses.shape[0], rows.shape[0], 6))
    for i in range(poses.shape[0]):
        frames[1] = poses[i]
        for k in range(rows.shape[0]):
            values[i, k] = row_value(rows[k], frames, wrenches[i, k])
    return values, wrenches


@kernel  # Family, (N,) i8, (N, 6) f8, (3,) f8, f8 -> (N, 12) f8, (N,) bool
def poses_drawn(family, components, shares, centre, reach):
    """The pose that each row of shares chooses in a component, and whether it is one to try (see `draw_pose`)."""
    frames, wrench = np.zeros((2, 12)), np.empty(6)
    frames[0, 0], frames[0, 4], frames[0, 8] = 1.0, 1.0, 1.0
    poses, good = np.empty((shares.shape[0], 12)), np.empty(shares.shape[0], np.bool_)
    for i in range(shares.shape[0]):
        good[i] = draw_pose(family, components[i], shares[i], centre, reach, frames, wrench)
        poses[i] = frames[1]
    return poses, good
