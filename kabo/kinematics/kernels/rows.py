"""Constraint rows: scalar functions of the relative pose of two frames, their values, gradients and ranges.

A row is an array of numbers (columns below). Its value depends only on the pose of its first frame relative to its
second one, so one wrench (g, m) is its whole gradient: a relative motion with angular velocity w and velocity v
(of the point at the world's origin) changes it by m.w + g.v. A joint on the first frame's branch contributes its
screw with a plus, a joint on the second frame's branch with a minus, and common ancestors contribute nothing.

Seen from one of the frames a row is a function of one vector y; `holds_between` bounds it wherever y is near a chord.
"""

import numpy as np

from kabo.compilation import lean_kernel

# Columns. For ALIGNED the origin of the first holds its direction, and its direction a normal to that; for AZIMUTH
# the origin of the second holds the direction of angle zero.
KIND, FIRST, SECOND = 0, 1, 8  # each frame is followed by an origin (3) and a direction (3): 2 to 7, 9 to 14
LOWER, UPPER, SCALE, TOLERANCE, WIDTH = 15, 16, 17, 18, 19

PLANE = 0  # n2 . (p1 - p2)                      [m], signed
GAP = 1  # |n2 . (p1 - p2)|                    [m]
LINE = 2  # distance of p1 from the second line  [m]
POINT = 3  # |p1 - p2|                           [m]
DIRECTION = 4  # d1 . d2                             cosine
ANGLE = 5  # between d1 and d2                   [rad], 0 to pi
ALIGNED = 6  # 2 sin(angle / 2), component along a normal of d1; zero at the same sense only
AZIMUTH = 7  # of d1 about the second line         [rad], -pi to pi


@lean_kernel  # (J, 12) f8, i8, f8 x 3 -> f8 x 3
def turned(world_T, j, x, y, z):
    """The world direction of a direction (x, y, z) given in the frame of joint j."""
    return (
        world_T[j, 0] * x + world_T[j, 1] * y + world_T[j, 2] * z,
        world_T[j, 3] * x + world_T[j, 4] * y + world_T[j, 5] * z,
        world_T[j, 6] * x + world_T[j, 7] * y + world_T[j, 8] * z,
    )


@lean_kernel  # f8 x 6 -> f8 x 3
def crossed(ax, ay, az, bx, by, bz):
    """The cross product a x b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@lean_kernel  # f8 x 3 -> f8 x 3
def any_normal(x, y, z):
    """A unit vector normal to the unit vector (x, y, z)."""
    if abs(x) < 0.6:
        nx, ny, nz = 0.0, z, -y
    elif abs(y) < 0.6:
        nx, ny, nz = -z, 0.0, x
    else:
        nx, ny, nz = y, -x, 0.0
    norm = np.sqrt(nx * nx + ny * ny + nz * nz)
    return nx / norm, ny / norm, nz / norm


@lean_kernel  # (W,) f8, (J, 12) f8, (6,) f8 -> f8, writes wrench
def position_value(row, world_T, wrench):
    """The value of a row that concerns a point; writes its wrench: force g, then m = p1 x g about the origin."""
    kind, a, b = int(row[KIND]), int(row[FIRST]), int(row[SECOND])
    px, py, pz = turned(world_T, a, row[2], row[3], row[4])
    px, py, pz = px + world_T[a, 9], py + world_T[a, 10], pz + world_T[a, 11]
    ex, ey, ez = turned(world_T, b, row[9], row[10], row[11])
    ex, ey, ez = px - ex - world_T[b, 9], py - ey - world_T[b, 10], pz - ez - world_T[b, 11]
    gx, gy, gz = turned(world_T, b, row[12], row[13], row[14])
    along = gx * ex + gy * ey + gz * ez
    if kind in (PLANE, GAP):
        value = along
        if kind == GAP and along < 0.0:
            value, gx, gy, gz = -along, -gx, -gy, -gz
    else:
        if kind == LINE:
            ex, ey, ez = ex - along * gx, ey - along * gy, ez - along * gz
        value = np.sqrt(ex * ex + ey * ey + ez * ez)
        if value > 1e-9:
            gx, gy, gz = ex / value, ey / value, ez / value
        elif kind == LINE:  # on the line the gradient is undefined: any fixed direction leads away from it
            gx, gy, gz = any_normal(gx, gy, gz)
        else:
            gx, gy, gz = 1.0, 0.0, 0.0
    wrench[0], wrench[1], wrench[2] = gx, gy, gz
    wrench[3], wrench[4], wrench[5] = crossed(px, py, pz, gx, gy, gz)
    return value


@lean_kernel  # (W,) f8, (J, 12) f8, (6,) f8 -> f8, writes wrench
def direction_value(row, world_T, wrench):
    """The value of a row that concerns directions; writes its wrench, with zero force and moment m."""
    kind, a, b = int(row[KIND]), int(row[FIRST]), int(row[SECOND])
    dx, dy, dz = turned(world_T, a, row[5], row[6], row[7])
    ux, uy, uz = turned(world_T, b, row[12], row[13], row[14])
    mx, my, mz = crossed(dx, dy, dz, ux, uy, uz)
    value = dx * ux + dy * uy + dz * uz
    if kind == ANGLE:
        sine = np.sqrt(mx * mx + my * my + mz * mz)
        value = np.arctan2(sine, value)
        if sine > 1e-12:
            mx, my, mz = -mx / sine, -my / sine, -mz / sine
        else:
            mx, my, mz = any_normal(dx, dy, dz)
            if value > 1.0:
                mx, my, mz = -mx, -my, -mz
    elif kind == ALIGNED:
        sx, sy, sz = turned(world_T, a, row[2], row[3], row[4])
        cosine = sx * ux + sy * uy + sz * uz
        if 1.0 + cosine < 1e-9:  # upside down: as far as can be, and any turn is right
            value = 2.0
        else:
            weight = np.sqrt(2.0 / (1.0 + cosine))
            bend = -0.25 * value * weight * weight * weight
            nx, ny, nz = crossed(sx, sy, sz, ux, uy, uz)
            mx, my, mz = weight * mx + bend * nx, weight * my + bend * ny, weight * mz + bend * nz
            value *= weight
    elif kind == AZIMUTH:
        rx, ry, rz = turned(world_T, b, row[9], row[10], row[11])
        tx, ty, tz = crossed(ux, uy, uz, rx, ry, rz)
        px, py, pz = dx - value * ux, dy - value * uy, dz - value * uz
        square = max(px * px + py * py + pz * pz, 1e-12)
        value = np.arctan2(px * tx + py * ty + pz * tz, px * rx + py * ry + pz * rz)
        tx, ty, tz = crossed(ux, uy, uz, px, py, pz)
        mx, my, mz = crossed(dx, dy, dz, tx / square, ty / square, tz / square)
    wrench[0], wrench[1], wrench[2] = 0.0, 0.0, 0.0
    wrench[3], wrench[4], wrench[5] = mx, my, mz
    return value


@lean_kernel  # (W,) f8, (J, 12) f8, (6,) f8 -> f8, writes wrench
def row_value(row, world_T, wrench):
    """The value of any row; writes its wrench."""
    if row[KIND] < DIRECTION:
        return position_value(row, world_T, wrench)
    return direction_value(row, world_T, wrench)


@lean_kernel  # (R, W) f8, (J, 12) f8, (R,) f8, (R, 6) f8 -> writes values and wrenches
def evaluate(rows, world_T, values, wrenches):
    """Writes the value and the wrench of every row, at the given poses of the joints."""
    for i in range(rows.shape[0]):
        values[i] = row_value(rows[i], world_T, wrenches[i])


@lean_kernel  # (R, 6) f8, (R,) i8, i8, (R, J) f8, (J,) i8, (J,) i8, (J, 12) f8, (R, n) f8 -> writes jacobian
def differentiate(wrenches, chosen, count, signs, kind, source, world_T, jacobian):
    """Writes the derivative of the rows `chosen[:count]` by every value of q; `signs` holds the ratios of mimic joints."""
    for k in range(count):
        for j in range(jacobian.shape[1]):
            jacobian[k, j] = 0.0
    for j in range(1, kind.shape[0]):
        # The joint's screw: the velocity of the point at the world's origin, and the turn.
        vx, vy, vz = world_T[j, 2], world_T[j, 5], world_T[j, 8]
        wx, wy, wz = 0.0, 0.0, 0.0
        if kind[j] == 0:
            wx, wy, wz = vx, vy, vz
            vx, vy, vz = crossed(world_T[j, 9], world_T[j, 10], world_T[j, 11], wx, wy, wz)
        for k in range(count):
            i = chosen[k]
            if signs[i, j] != 0.0:
                force = vx * wrenches[i, 0] + vy * wrenches[i, 1] + vz * wrenches[i, 2]
                moment = wx * wrenches[i, 3] + wy * wrenches[i, 4] + wz * wrenches[i, 5]
                jacobian[k, source[j]] += signs[i, j] * (force + moment)


@lean_kernel  # (R, W) f8, (J,) i8, (J,) f8, (R, J) f8 -> writes signs
def find_signs(rows, parent, ratio, signs):
    """Writes the ratio, with sign, by which each joint moves a row's first frame relative to its second; 0 for none."""
    for i in range(rows.shape[0]):
        for k in range(parent.shape[0]):
            signs[i, k] = 0.0
        j = int(rows[i, FIRST])
        while j > 0:
            signs[i, j] += ratio[j]
            j = parent[j]
        j = int(rows[i, SECOND])
        while j > 0:
            signs[i, j] -= ratio[j]
            j = parent[j]


@lean_kernel  # (W,) f8, (J, 12) f8, (3,) f8 -> writes y
def relative(row, world_T, y):
    """Writes the vector that the row's value depends on, in the second frame (for ALIGNED, in the first frame)."""
    a, b = int(row[FIRST]), int(row[SECOND])
    if row[KIND] < DIRECTION:
        x0, x1, x2 = turned(world_T, a, row[2], row[3], row[4])
        x0 += world_T[a, 9] - world_T[b, 9]
        x1 += world_T[a, 10] - world_T[b, 10]
        x2 += world_T[a, 11] - world_T[b, 11]
    elif row[KIND] == ALIGNED:
        x0, x1, x2 = turned(world_T, b, row[12], row[13], row[14])
        b = a
    else:
        x0, x1, x2 = turned(world_T, a, row[5], row[6], row[7])
    for k in range(3):
        y[k] = world_T[b, k] * x0 + world_T[b, 3 + k] * x1 + world_T[b, 6 + k] * x2
        if row[KIND] < DIRECTION:
            y[k] -= row[9 + k]


@lean_kernel  # (3,) f8 x 2, f8 x 3 -> f8, f8
def along(y0, y1, u0, u1, u2):
    """The components of the vectors y0 and y1 along the direction (u0, u1, u2)."""
    return y0[0] * u0 + y0[1] * u1 + y0[2] * u2, y1[0] * u0 + y1[1] * u1 + y1[2] * u2


@lean_kernel  # (3,) f8 x 2, f8, f8, (W,) f8 -> f8, f8
def norm_range(y0, y1, s0, s1, row):
    """The least and the greatest norm on the chord y0 y1, without the components s0, s1 along the second direction."""
    square0, square1, mixed = 0.0, 0.0, 0.0
    for k in range(3):
        u = row[12 + k]
        a, b = y0[k] - s0 * u, y1[k] - s1 * u
        square0 += a * a
        square1 += b * b
        mixed += a * b
    length = square0 + square1 - 2.0 * mixed
    least = min(square0, square1)
    if length > 0.0 and 0.0 < square0 - mixed < length:
        least = square0 - (square0 - mixed) ** 2 / length
    return np.sqrt(max(least, 0.0)), np.sqrt(max(square0, square1))


@lean_kernel  # (W,) f8, (3,) f8 x 2, f8, f8 -> bool
def holds_between(row, y0, y1, deviation, tolerance):
    """Whether the row is proven to hold, within `tolerance`, for every y within `deviation` of the chord y0 y1."""
    kind, low, high = int(row[KIND]), row[LOWER] - tolerance, row[UPPER] + tolerance
    if kind == ALIGNED:
        a0, a1 = along(y0, y1, row[2], row[3], row[4])
        n0, n1 = along(y0, y1, row[5], row[6], row[7])
        cosine = min(a0, a1) - deviation
        if not cosine > 0.0:
            return False
        return (max(abs(n0), abs(n1)) + deviation) * np.sqrt(2.0 / (1.0 + cosine)) <= high
    s0, s1 = along(y0, y1, row[12], row[13], row[14])
    if kind == ANGLE:
        least, most = min(s0, s1) - deviation, max(s0, s1) + deviation
        return (high >= np.pi or least >= np.cos(high)) and (low <= 0.0 or most <= np.cos(low))
    if kind in (PLANE, DIRECTION):
        return low <= min(s0, s1) - deviation and max(s0, s1) + deviation <= high
    if kind == GAP:
        least = 0.0 if s0 * s1 <= 0.0 else min(abs(s0), abs(s1))
        return low <= max(least - deviation, 0.0) and max(abs(s0), abs(s1)) + deviation <= high
    if kind != LINE:
        s0, s1 = 0.0, 0.0
    least, most = norm_range(y0, y1, s0, s1, row)
    return low <= max(least - deviation, 0.0) and most + deviation <= high
