"""Combines two motions with unknown relative timing into one path that visits every pair of their pieces.

What is proven along a whole piece of this path holds for every moment of the first motion combined with every
moment of the second.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.separation_proofs import Course
from kabo.plan import Segment
from kabo.planner.certify.motion_stretches import MotionStretch, at_once, joined
from kabo.scene import Robot


def from_time_on(
    stretch: MotionStretch, motion: Sequence[Segment], robots: Mapping[str, Robot], time: float
) -> tuple[Array, Array] | None:
    """The way points (W, n) of a stretch from `time` [s] to its end, and deviations (W - 1, n); None if it has ended.

    Args:
        stretch: a stretch of `motion`.
        motion: the segments of the node.
        robots: all robots of the scene.
        time: since the beginning of the node's motion.
    """
    times, waypoints, deviations = stretch.times, np.hstack(list(stretch.waypoints.values())), stretch.together
    if times[-1] <= time:
        return None
    if times[0] >= time:
        return waypoints, deviations
    later = times > time
    if stretch.in_time:
        start = {name: rows[0] for name, rows in stretch.waypoints.items()}
        under_way = [motion[i] for i in stretch.segments]
        rest = at_once(under_way, np.array([time, *times[later]]), robots, start)
        return np.hstack(list(rest[0].values())), np.hstack(list(rest[1].values()))
    piece = int(later.argmax()) - 1
    row = [_place(stretch, motion, robots[name], piece, time) for name in stretch.waypoints]
    return np.concatenate([np.concatenate(row)[None], waypoints[later]]), deviations[piece:].copy()


def _place(stretch: MotionStretch, motion: Sequence[Segment], robot: Robot, piece: int, time: float) -> Array:
    """Where the path of a robot is at a time [s]: for a trajectory that follows it, the nearest place on its piece."""
    rows, times = stretch.waypoints[robot.name], stretch.times
    segment = next(motion[i] for i in stretch.segments if motion[i].robot == robot.name)
    row = np.array([np.interp(time, times, column) for column in rows.T])
    if segment.trajectory is None:
        return row
    own = robot.columns(segment.joints)
    start, way = rows[piece, own], rows[piece + 1, own] - rows[piece, own]
    square = float(way @ way)
    share = float((segment.trajectory.at(time) - start) @ way) / square if square > 0.0 else 0.0
    row[own] = start + min(1.0, max(0.0, share)) * way
    return row


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
    deviations = None
    if first.deviations is not None and second.deviations is not None:
        numbers = np.array(rows)
        both = zip((first.deviations, second.deviations), numbers.T, strict=True)
        deviations = np.hstack([_along(off, own, cut) for off, own in both])
    moved = [body._replace(joint=body.joint + shift if body.joint else 0) for body in second.bodies]
    numbered = pairs + np.array([0, len(first.bodies), 0])
    return replace(
        first,
        tree=tree,
        waypoints=waypoints,
        bodies=[*first.bodies, *moved],
        pairs=numbered,
        at_any_times=True,
        deviations=deviations,
    )


def _along(deviations: Array, places: Integers, cut: int) -> Array:
    """The deviations (R - 1, n) of one motion between the R places on its cut pieces; zeros where it stays at one."""
    pieces = np.minimum(np.minimum(places[:-1], places[1:]) // cut, len(deviations) - 1)
    return np.where((places[1:] == places[:-1])[:, None], 0.0, deviations[pieces])


def _cut(waypoints: Array, parts: int) -> Array:
    """Way points with `parts` pieces in place of each."""
    shares = np.arange(parts)[:, None] / parts
    pieces = [a + shares * (b - a) for a, b in zip(waypoints, waypoints[1:], strict=False)]
    return np.concatenate([*pieces, waypoints[-1:]])
