"""By how much the floor of a robot's base is too small for a target: the least growth of all its edges that was found.

Base and arm are projected together onto the constraints, with the base free to leave its floor; what is found nearest to
the floor is then pulled towards it. The result is an upper bound.
"""

from typing import TYPE_CHECKING

import numpy as np

from kabo.arrays import Array
from kabo.kinematics import project, sample
from kabo.scene import BASE_VALUES, Drive
from kabo.streams import stream_key

if TYPE_CHECKING:
    from kabo.geometry_server.candidates import Stream

RANGES = (0.1, 0.3, 1.0, 3.0, 9.0)  # [m] by which the base may leave its floor, tried in this order
SAMPLES, KEPT = 256, 24  # in each range, and how many of these are pulled
PULLS, LEAST_GAIN = 60, 1e-4  # attempts, and what one must gain [m]


def floor_growth(stream: "Stream", drive: Drive) -> tuple[float, Array] | None:
    """By how much all edges of the floor would have to move outwards [m], and the base (3,) then; None: not found."""
    tree, robot = stream.robot.tree, stream.robot
    planned = np.arange(tree.size) < robot.planned
    base = np.concatenate([np.zeros(robot.planned), stream.hand])
    low, high = drive.box()
    for number, span in enumerate(RANGES):
        lower, upper = tree.lower.copy(), tree.upper.copy()
        lower[:2], upper[:2] = low - span, high + span
        key = stream_key("floor", int(stream.key))
        Q, valid = sample(tree, stream.rows, key, number * SAMPLES, SAMPLES, lower, upper, planned, base=base)
        if not valid.any():
            continue
        Q = Q[valid]
        Q = Q[np.argsort(drive.outside(Q[:, :BASE_VALUES]), kind="stable")[:KEPT]]
        Q = _pulled(stream, drive, Q, (lower, upper))
        out = drive.outside(Q[:, :BASE_VALUES])
        best = int(np.argmin(out))
        return max(0.0, float(out[best])), Q[best, :BASE_VALUES].copy()
    return None


def _pulled(stream: "Stream", drive: Drive, Q: Array, limits: tuple[Array, Array]) -> Array:
    """Configurations (N, n) pulled towards the floor, as far as the rows can be fulfilled."""
    tree, robot = stream.robot.tree, stream.robot
    step = np.full(len(Q), 0.5)
    middle = 0.5 * np.add(*drive.box())
    for number in range(PULLS):
        seeds = Q.copy()
        if number % 3 < 2:
            seeds[:, :2] += step[:, None] * (middle - Q[:, :2]) * 0.3
        else:  # a turn may need less room
            seeds[:, 2] += step * 0.4 * (-1.0) ** (number // 3)
        moving = robot.arm if number % 2 else np.arange(tree.size) < robot.planned
        found, valid = project(tree, stream.rows, seeds, *limits, moving, hold_limits=True)
        before, after = drive.outside(Q[:, :BASE_VALUES]), drive.outside(found[:, :BASE_VALUES])
        better = valid & (after < before - LEAST_GAIN)
        Q[better] = found[better]
        step = np.where(better, np.minimum(1.5 * step, 1.0), 0.7 * step)
        step = np.maximum(step, 1e-3)
    return Q
