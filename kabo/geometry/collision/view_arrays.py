"""The arrays of kinematic trees, of tracks and of ways, as the kernels of several predicates take them."""

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import (
    COUNTER_PLACES,
    JOINT,
    PAIRS,
    PARTNER,
    Bodies,
    Chain,
    Hulls,
    Search,
    Tracks,
    Way,
)
from kabo.geometry.collision.kernels.separation import rounding
from kabo.geometry.parts import COLUMNS
from kabo.scene import PRISMATIC, KinematicTree

ROUNDING_BOUND = 2e-10  # [m] of one evaluated gap; Budget.margin relies on it


def chain_of(tree: KinematicTree) -> Chain:
    """The arrays of a tree, with the bound on |q| up to which `reach` is valid.

    Raises:
        ValueError: a prismatic joint without finite limits (no bound of rounding errors could be given).
    """
    bound = np.full(tree.size, 1e6)
    for joint in np.flatnonzero(np.asarray(tree.kind) == PRISMATIC):
        if joint > 0 and tree.ratio[joint] != 0.0:
            index = int(tree.source[joint])
            bound[index] = max(abs(float(tree.lower[index])), abs(float(tree.upper[index]))) + 0.1
    if not np.isfinite(bound).all():
        raise ValueError(f"joint value {int(np.argmin(np.isfinite(bound)))} slides without finite limits")
    joints = np.array([tree.parent, tree.kind, tree.source], np.int64)
    factors, placement = np.array([tree.ratio, tree.shift], np.float64), np.array(tree.placement, np.float64)
    if not (np.isfinite(factors).all() and np.isfinite(placement).all()):
        raise ValueError("the kinematic tree has a value that is not finite")
    return Chain(joints, factors, placement, bound)


def reach(chain: Chain) -> Array:
    """An upper bound (J,) of the distance of each joint frame's origin from the world's [m]."""
    parent, kind, source = chain.joints
    steps: Array = np.linalg.norm(chain.placement[:, 9:], axis=1)
    for joint in range(1, len(steps)):
        if kind[joint] == PRISMATIC:
            steps[joint] += abs(chain.factors[0, joint]) * chain.bound[source[joint]] + abs(
                chain.factors[1, joint]
            )
        steps[joint] += steps[parent[joint]] if parent[joint] else 0.0
    steps[0] = 0.0
    return steps


def offset_for(greatest: float) -> float:
    """The argument `offset` of `farthest` for vertices at most `greatest` [m] from the origin.

    Raises:
        ValueError: a vertex is so far that rounding would exceed the budget's numeric share.
    """
    offset = 2.0 ** (np.ceil(np.log2(max(greatest, 1e-3))) + 1)
    if not rounding(offset) <= ROUNDING_BOUND:
        raise ValueError(f"the scene reaches {greatest:g} m from its origin: too far for the numeric tolerance")
    return float(offset)


def local_frames(placement: Array) -> Array:
    """The terms (J, 6, 4) of joints' frames in their parents', for `frames_of`: what stays, and what is turned or slides.

    Row k of a joint's frame is row k here times (cos, cos, 1, 1), plus row 3 + k times (sin, -sin, 0, slide).
    """
    rotation = placement[:, :9].reshape(-1, 3, 3)
    kept = np.concatenate([rotation, placement[:, 9:, None]], axis=2)
    moved = rotation[:, :, [1, 0, 2, 2]] * [1.0, 1.0, 0.0, 1.0]
    return np.concatenate([kept, moved], axis=1)


def tracks_of(shared: Integers, bodies: Bodies, slack: Array, radii: Array, kept: Array) -> Tracks:
    """The tracks of all pairs: each is swept in the frame of the last joint that carries both groups.

    Args:
        shared: (J, J) the last joint that carries both of two joints.
        bodies: the groups and pairs.
        slack: (G,) for each group, half of the part of epsilon left for spread, minus the group's deviation [m].
        radii, kept: (G,) and (2, G), as in `Tracks`.
    """
    joint, first_pair = bodies.groups[JOINT, :-1], bodies.groups[PAIRS]
    first = np.repeat(np.arange(len(joint)), np.diff(first_pair))
    second = bodies.pairs[PARTNER]
    frame, frames = shared[joint[first], joint[second]], len(shared)
    keys = np.concatenate([first, second]) * frames + np.concatenate([frame, frame])
    found, number = np.unique(keys, return_inverse=True)
    tracks = np.array([found // frames, found % frames], np.int64)
    pair_tracks = np.ascontiguousarray(number.reshape(2, -1), np.int64)
    return Tracks(tracks, pair_tracks, slack[first] + slack[second], radii, kept)


def last_shared_joints(chain: Chain, first: Integers, second: Integers) -> Integers:
    """The last common ancestor (P,) of each pair of joints in the tree; 0 is the world."""
    carries = np.eye(chain.joints.shape[1], dtype=bool)  # carries[j, i]: joint i is j or before it
    for j in range(1, len(carries)):
        carries[j] |= carries[chain.joints[0, j]]
    shared = carries[first] & carries[second]
    last: Integers = shared.shape[1] - 1 - np.argmax(shared[:, ::-1], axis=1)  # parents come before children
    return last


def usable_deviations(deviations: Array, size: int) -> Array:
    """How far each of `size` values may be from each of N segments, as an array (N, size).

    Raises:
        ValueError: another shape, or a value that is negative or not finite.
    """
    found = np.ascontiguousarray(deviations, np.float64)
    if found.shape[-1:] != (size,) or found.ndim != 2 or not ((found >= 0.0) & (found < np.inf)).all():
        raise ValueError(f"deviations are {size} finite values of at least 0, not {deviations}")
    return found


def way_of(chain: Chain, frames: Array, tracks: int = 0) -> Way:
    """A way without a segment yet, whose frames (N, J, 12) at nodes are given; every first one becomes the world's."""
    frames[:, 0, [0, 4, 8]] = 1.0
    lengths = np.linalg.norm(chain.placement[:, 9:], axis=1)
    segment, turned, motions = np.zeros((3, len(chain.bound))), np.zeros(len(lengths)), np.zeros((tracks, 4))
    strays, tags = np.zeros(len(chain.bound)), np.zeros(len(frames), np.int64)
    return Way(segment, turned, lengths, motions, strays, frames, tags)


def search_for(offset: float) -> Search:
    """The scratch arrays of a search for separating axes."""
    return Search(offset, np.zeros(3), np.zeros((4, 3)), np.zeros((4, 3)), np.zeros(COUNTER_PLACES, np.int64))


def pool_of(rows: int, columns: int = COLUMNS) -> Hulls:
    """So many rows for parts that a kernel places."""
    return Hulls(np.empty((rows, 3, columns)), np.zeros(rows, np.int64), np.zeros((rows, 5)))
