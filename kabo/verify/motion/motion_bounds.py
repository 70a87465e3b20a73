"""Bounds of the relative motion of two bodies, tighter than the sum over joints, for pairs that nearly touch.

Between two way points the velocity of a point differs from that of its chord by no more than four times the bound of its
deviation from the chord [K Eq. 4.19]; the points of a body move no farther than the corners of the box around it.
"""

import numpy as np

from kabo.arrays import Array
from kabo.verify.motion.chord_bounds import deviations
from kabo.verify.motion.contacts.strokes import box_corners
from kabo.verify.motion.sweep import Intervals, Pair, Path, SweptBody


def closer(pair: Pair, intervals: Intervals) -> tuple[Pair, Intervals]:
    """The pair with tighter motion bounds, and the same intervals of the path measured by these bounds."""
    lengths = np.diff(pair.ends)
    bounds = np.minimum(lengths, _lengths(pair.path, pair.first) + _lengths(pair.path, pair.second))
    made = Pair(pair.path, pair.first, pair.second, np.zeros(pair.path.steps.shape[1]))
    made.ends, made.strays = np.concatenate([[0.0], np.cumsum(bounds)]), pair.strays
    return made, [(_place(pair, made, start), _place(pair, made, end)) for start, end in intervals]


def _place(pair: Pair, made: Pair, s: float) -> float:
    piece, share = pair.place(s)
    return float(made.ends[piece] + share * (made.ends[piece + 1] - made.ends[piece]))


def _lengths(path: Path, thing: SweptBody) -> Array:
    """The most that any point of a body moves on each piece of a path (K,) [m]."""
    mount = thing.mount
    if mount is None:
        return np.zeros(len(path.steps))
    turn, place = mount.joint_T_body[:3, :3], mount.joint_T_body[:3, 3]
    corners = box_corners(thing.surface.lower, thing.surface.upper) @ turn.T + place
    bends, _ = deviations(path, mount, 0, float(np.linalg.norm(corners, axis=1).max()))
    rows = [path.poses(0, 0.0), *(path.poses(piece, 1.0) for piece in range(len(path.steps)))]
    poses = np.array([row[mount.robot][mount.joint] for row in rows])
    places = np.einsum("mrc,pc->mpr", poses[:, :3, :3], corners) + poses[:, None, :3, 3]
    chords = np.linalg.norm(np.diff(places, axis=0), axis=2).max(axis=1)
    return np.asarray(chords + 4.0 * bends)
