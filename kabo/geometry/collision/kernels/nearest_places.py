"""Where along a path two bodies are nearest to each other, and at which points of their parts.

Boxes of parts bound distances from below, so few pairs of parts are measured, and few places are looked at.
"""

from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.simplex import nearest
from kabo.geometry.collision.kernels.tight_parts import LOSS
from kabo.geometry.collision.kernels.witness_axes import END, HIGH, LOW, START, gap_along, greatest_gap
from kabo.scene.kernels.poses import forward_kinematics

ALIKE = 0.97  # of a distance: those between are as good as the least one
AXES = 4096  # rows of `Between.axes`
AXES_PER_PART = 251  # rows between those of a part and the next one, with the same other part


class Between(NamedTuple):
    """Room for where a body is in the frame of another one, and the way between two of their parts.

    `axes` are along which parts were found apart last, each in the frame of the first body. Pairs of parts may share a row:
    whatever it holds can only save a search.
    """

    turn: Array  # (3, 3)
    at: Array  # (3,)
    apart: Array  # (3,)
    axes: Array  # (AXES, 3); zeros where there is none


class Lists(NamedTuple):
    """The parts of two bodies, as rows of `Hulls`."""

    numbers: Integers  # (2, N)
    counts: Integers  # (2,) how many of each


@lean_kernel
def relative(poses, k, turn, at):
    """Writes the pose of the second body in the first one's frame."""
    for r in range(3):
        at[r] = 0.0
        for i in range(3):
            at[r] += poses[0, k, 3 * i + r] * (poses[1, k, 9 + i] - poses[0, k, 9 + i])
        for c in range(3):
            turn[r, c] = (
                poses[0, k, r] * poses[1, k, c]
                + poses[0, k, 3 + r] * poses[1, k, 3 + c]
                + poses[0, k, 6 + r] * poses[1, k, 6 + c]
            )


@lean_kernel
def box_gap(boxes, a, b, turn, at, apart, enough):
    """The greatest gap of the boxes of two parts along an axis of either, or one of at least `enough`.

    In the first case the way between their middles is written.
    """
    gap = -np.inf
    for r in range(3):
        x, half = at[r] - boxes[a, r], boxes[a, 3 + r]
        for c in range(3):
            x += turn[r, c] * boxes[b, c]
            half += abs(turn[r, c]) * boxes[b, 3 + c]
        apart[r] = x
        gap = max(gap, abs(x) - half)
        if gap >= enough:
            return gap
    for c in range(3):
        x, half = 0.0, boxes[b, 3 + c]
        for r in range(3):
            x += turn[r, c] * apart[r]
            half += abs(turn[r, c]) * boxes[a, 3 + r]
        gap = max(gap, abs(x) - half)
    return gap


@lean_kernel
def gap_of_parts(hulls, a, b, poses, k, best, ends, search, between):
    """The gap of two parts at a pose, or some gap above `best`; `between.apart` is about the way from one to the other.

    The axis along which they were apart before is looked at first. Where even what a search may lose of the gap along it is
    to spare, a search would say no less than `best` either: so answers do not depend on what was known.
    """
    ends[0, LOW], ends[0, HIGH], ends[1, LOW], ends[1, HIGH] = a, a + 1, b, b + 1
    axis, known = search.axis, between.axes[(AXES_PER_PART * a + b) % AXES]
    if known[0] != 0.0 or known[1] != 0.0 or known[2] != 0.0:
        x = poses[0, k, 0] * known[0] + poses[0, k, 1] * known[1] + poses[0, k, 2] * known[2]
        y = poses[0, k, 3] * known[0] + poses[0, k, 4] * known[1] + poses[0, k, 5] * known[2]
        z = poses[0, k, 6] * known[0] + poses[0, k, 7] * known[1] + poses[0, k, 8] * known[2]
        gap = (1.0 - LOSS) * gap_along(hulls, ends, poses, x, y, z, search)
        if gap > best and gap > 0.0:
            return gap
    for r in range(3):
        axis[r] = 0.0
        for c in range(3):
            axis[r] -= poses[0, k, 3 * r + c] * between.apart[c]
    gap = greatest_gap(hulls, ends, poses, best, 0.0, LOSS, search)
    for c in range(3):
        known[c] = poses[0, k, c] * axis[0] + poses[0, k, 3 + c] * axis[1] + poses[0, k, 6 + c] * axis[2]
    return gap


@lean_kernel
def _least_at(hulls, boxes, parts, poses, k, limit, ends, search, between, chosen):
    """The distance of the two parts that are nearest at a pose [m], and these; the chosen ones are tried first.

    The distance is `limit` if no parts are nearer than that.
    """
    turn, first, second = between.turn, chosen[1], chosen[2]
    relative(poses, k, turn, between.at)
    for e in range(2):
        ends[e, START], ends[e, END] = k, k
    box_gap(boxes, first, second, turn, between.at, between.apart, np.inf)
    best = min(limit, gap_of_parts(hulls, first, second, poses, k, limit, ends, search, between))
    whole = boxes.shape[0] - 1
    for i in range(parts.counts[0]):
        a = parts.numbers[0, i]
        if box_gap(boxes, a, whole, turn, between.at, between.apart, best) >= best:
            continue
        for j in range(parts.counts[1]):
            b = parts.numbers[1, j]
            if box_gap(boxes, a, b, turn, between.at, between.apart, best) < best:
                gap = gap_of_parts(hulls, a, b, poses, k, best, ends, search, between)
                if gap < best:
                    best, first, second = gap, a, b
    return best, first, second


@lean_kernel
def _whole_boxes(boxes, parts):
    """Writes the boxes of both whole bodies into the last two rows, that of the second one into the last."""
    for e in range(2):
        whole = boxes.shape[0] - 2 + e
        for r in range(3):
            low, high = np.inf, -np.inf
            for j in range(parts.counts[e]):
                b = parts.numbers[e, j]
                low, high = min(low, boxes[b, r] - boxes[b, 3 + r]), max(high, boxes[b, r] + boxes[b, 3 + r])
            boxes[whole, r], boxes[whole, 3 + r] = 0.5 * (low + high), 0.5 * (high - low)


@lean_kernel
def least_along(hulls, boxes, parts, poses, lower, nearest_parts, ends, search, between, chosen):
    """Finds where two bodies are nearest, to a share `ALIKE`: writes the pose and the parts; returns the distance [m].

    `lower` (K,) are lower bounds of the distance at each pose, -inf at first, and `nearest_parts` (K, 2) the parts that are
    so far apart, -1 if that is not known; both are written where poses are looked at. The last two rows of `boxes`
    are room.
    """
    _whole_boxes(boxes, parts)
    whole = boxes.shape[0] - 1
    for k in range(lower.shape[0]):
        if lower[k] == -np.inf:
            relative(poses, k, between.turn, between.at)
            lower[k] = box_gap(boxes, whole - 1, whole, between.turn, between.at, between.apart, np.inf)
    while True:
        k, known = 0, -1
        for other in range(lower.shape[0]):
            if lower[other] < lower[k]:
                k = other
            if nearest_parts[other, 0] >= 0 and (known < 0 or lower[other] < lower[known]):
                known = other
        limit = np.inf if known < 0 else lower[known]
        if known >= 0 and not lower[k] < min(limit, ALIKE * limit):
            chosen[0], chosen[1], chosen[2] = known, nearest_parts[known, 0], nearest_parts[known, 1]
            return limit
        found, a, b = _least_at(hulls, boxes, parts, poses, k, limit, ends, search, between, chosen)
        lower[k] = found
        if found < limit:
            nearest_parts[k, 0], nearest_parts[k, 1] = a, b
            chosen[1], chosen[2] = a, b


@lean_kernel
def nearest_points(hulls, poses, chosen, ends, search, found, rows):
    """Writes the points (2, 3) of two parts that are nearest to each other, each in its body's frame.

    `rows` (2, 3, N) is room for the supporting points of the search.
    """
    k, simplex, points = chosen[0], search.simplex, search.points
    for e in range(2):
        ends[e, LOW], ends[e, HIGH] = chosen[1 + e], chosen[1 + e] + 1
        ends[e, START], ends[e, END] = k, k
    x, y, z = 0.0, 0.0, 1.0
    size, count, best = 0, 0, -np.inf
    while count < rows.shape[2]:
        norm = np.sqrt(x * x + y * y + z * z)
        if not norm > 1e-10:
            break
        gap = gap_along(hulls, ends, poses, x / norm, y / norm, z / norm, search)
        best = max(best, gap)
        if size > 0 and norm - best <= 0.2 * LOSS * norm:
            break
        for r in range(3):
            rows[0, r, count], rows[1, r, count] = points[0, r], points[1, r]
            simplex[size, r] = points[0, r] - points[1, r]
        count += 1
        size, x, y, z = nearest(simplex, size + 1)
        if size == 4:
            break
    weights = _weights(simplex, min(size, 3), x, y, z)
    for e in range(2):
        for r in range(3):
            points[2 + e, r] = 0.0
    for s in range(min(size, 3)):
        at, least = 0, np.inf
        for c in range(count):
            away = 0.0
            for r in range(3):
                away += abs(rows[0, r, c] - rows[1, r, c] - simplex[s, r])
            if away < least:
                at, least = c, away
        for e in range(2):
            for r in range(3):
                points[2 + e, r] += weights[s] * rows[e, r, at]
    for e in range(2):
        for c in range(3):
            own = 0.0
            for r in range(3):
                own += poses[e, k, 3 * r + c] * (points[2 + e, r] - poses[e, k, 9 + r])
            found[e, c] = own


@lean_kernel
def _weights(simplex, size, x, y, z):
    """The weights with which one, two or three corners of a simplex make a point that lies among them."""
    if size < 2:
        return 1.0, 0.0, 0.0
    ux, uy, uz = simplex[1, 0] - simplex[0, 0], simplex[1, 1] - simplex[0, 1], simplex[1, 2] - simplex[0, 2]
    px, py, pz = x - simplex[0, 0], y - simplex[0, 1], z - simplex[0, 2]
    uu, up = ux * ux + uy * uy + uz * uz, ux * px + uy * py + uz * pz
    if size < 3:
        second = min(1.0, max(0.0, up / uu)) if uu > 0.0 else 0.0
        return 1.0 - second, second, 0.0
    vx, vy, vz = simplex[2, 0] - simplex[0, 0], simplex[2, 1] - simplex[0, 1], simplex[2, 2] - simplex[0, 2]
    vv, uv, vp = vx * vx + vy * vy + vz * vz, ux * vx + uy * vy + uz * vz, vx * px + vy * py + vz * pz
    whole = uu * vv - uv * uv
    if not whole > 0.0:
        return 1.0, 0.0, 0.0
    second, third = (vv * up - uv * vp) / whole, (uu * vp - uv * up) / whole
    return 1.0 - second - third, second, third


@lean_kernel
def poses_at(waypoints, places, chain, segment, frames):
    """Writes the poses (K, J, 12) of all joints at places (K,) of a path: way point, and share of its piece."""
    joints, factors = chain.joints, chain.factors
    last = waypoints.shape[0] - 1
    for k in range(places.shape[0]):
        piece = min(int(places[k]), last)
        share = places[k] - piece
        for i in range(waypoints.shape[1]):
            segment[i] = waypoints[piece, i]
            if share > 0.0:
                segment[i] += share * (waypoints[piece + 1, i] - waypoints[piece, i])
        forward_kinematics(
            segment, joints[0], joints[1], joints[2], factors[0], factors[1], chain.placement, frames[k]
        )


@lean_kernel
def body_poses(frames, joint, joint_T, poses):
    """Writes the poses (K, 12) of a body on a joint, given those of all joints (K, J, 12)."""
    for k in range(frames.shape[0]):
        for r in range(3):
            a, b, c = frames[k, joint, 3 * r], frames[k, joint, 3 * r + 1], frames[k, joint, 3 * r + 2]
            for i in range(3):
                poses[k, 3 * r + i] = a * joint_T[i] + b * joint_T[3 + i] + c * joint_T[6 + i]
            poses[k, 9 + r] = a * joint_T[9] + b * joint_T[10] + c * joint_T[11] + frames[k, joint, 9 + r]
