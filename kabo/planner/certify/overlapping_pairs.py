"""Combines two motions with unknown relative timing into one path that visits every pair of their pieces.

What is proven along a whole piece of this path holds for every moment of the first motion combined with every
moment of the second.
"""

from dataclasses import replace

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.separation_proofs import Course
from kabo.planner.certify.motion_stretches import joined


def from_time_on(waypoints: Array, times: Array, time: float) -> Array | None:
    """The way points (W, n) of a path from `time` [s] to its end; None if the path has ended by then."""
    if times[-1] <= time:
        return None
    if times[0] >= time:
        return waypoints
    later = times > time
    row = np.array([np.interp(time, times, column) for column in waypoints.T])
    return np.concatenate([row[None], waypoints[later]])


def every_pair_of_pieces(first: Course, second: Course, pairs: Integers, cut: int) -> Course:
    """The course that combines each piece of the first path with each piece of the second.

    For each piece of the first path, the second path is passed once, alternately forward and backward, while the
    first alternates between the two ends of its piece.

    Args:
        first, second: courses on separate kinematic trees; the body pairs within each course are ignored.
        pairs: rows (P, 3): the index of a body in the first course, of one in the second, and 0 for the world.
        cut: the number of equal parts into which each piece is divided.
    """
    (_, shift), tree = joined([first.tree, second.tree])
    mine, theirs = _cut(first.waypoints, cut), _cut(second.waypoints, cut)
    rows, here, there = [(0, 0)], 0, 0
    for piece in range(len(mine) - 1):
        step = 1 if there == 0 else -1
        for _ in range(len(theirs) - 1):
            here, there = 2 * piece + 1 - here, there + step
            rows.append((here, there))
        if here == piece:
            here += 1
            rows.append((here, there))
    waypoints = np.array([[*mine[i], *theirs[k]] for i, k in rows])
    moved = [body._replace(joint=body.joint + shift if body.joint else 0) for body in second.bodies]
    numbered = pairs + np.array([0, len(first.bodies), 0])
    return replace(
        first, tree=tree, waypoints=waypoints, bodies=[*first.bodies, *moved], pairs=numbered, at_any_times=True
    )


def _cut(waypoints: Array, parts: int) -> Array:
    """Way points with `parts` pieces in place of each."""
    shares = np.arange(parts)[:, None] / parts
    pieces = [a + shares * (b - a) for a, b in zip(waypoints, waypoints[1:], strict=False)]
    return np.concatenate([*pieces, waypoints[-1:]])
