"""The arrays of a collision view for kernels, made once from groups, pairs and a kinematic tree."""

from collections.abc import Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.boxes import place_groups
from kabo.geometry.collision.kernels.layout import (
    CACHE_LINE_PLACES,
    COUNTER_PLACES,
    GROUPS_PER_WORD,
    HEAD_PLACES,
    MARGIN,
    OFFSET,
    after,
    numbers_of,
    whole_numbers_of,
    words_for,
)
from kabo.geometry.collision.kernels.separation import rounding
from kabo.geometry.collision.kernels.tracks import COARSE_NODES, FRAME_SLOTS
from kabo.geometry.parts import FixedGroup, MovingGroup, poses_of, stacked
from kabo.scene import PRISMATIC, KinematicTree

ROUNDING_BOUND = 2e-10  # [m] of one evaluated gap; Budget.margin relies on it
SWEEP_POOL_BLOCKS = 1024  # vertex blocks kept during one sweep
PADDING_BOX_DISTANCE = 1e9  # [m] from the origin: boxes of padding groups lie there


class Chain(NamedTuple):
    """The kinematic tree as arrays for kernels."""

    joints: Integers  # (3, J) parent, kind, source
    factors: Array  # (2, J) ratio, shift
    placement: Array  # (J, 12)
    bound: Array  # (n,) greatest valid |q|


class Bodies(NamedTuple):
    """Groups (moving ones first) of convex parts, and the pairs to check, sorted by their first group."""

    moving: int  # how many groups move
    offset: float  # for `support`: a power of two of at least twice every |vertex|
    groups: Integers  # (3, G+1) joint (0 for fixed groups), first part, first pair
    sizes: Integers  # (B,)
    part_extents: Array  # (B, 6) centre and half extents in the joint's frame
    group_extents: Array  # (G, 6)
    pairs: Integers  # (2, P) second group, and the caller's number of the pair


class Tracks(NamedTuple):
    """Each group with each frame in which one of its pairs is swept (kabo.geometry.collision.kernels.tracks)."""

    lengths: Array  # (J,) of the placements' translations [m]
    radii: Array  # (G,) [m]
    diameters: Array  # (B,) [m]
    tracks: Integers  # (2, T) group, frame
    pair_tracks: Integers  # (2, P)
    slacks: Array  # (P,) rest of the budget for `spread` [m]


class Sweep(NamedTuple):
    """The scratch arrays that a sweep writes."""

    segment: Array  # (3, n) start, end, the node in work
    turned: Array  # (J,)
    motions: Array  # (T, 3) deviation, angle, path
    frames: Array  # (SLOTS, J, 12)
    frame_tags: Integers  # (SLOTS,)
    node_poses: Array  # (T * GRID, 12)
    node_boxes: Array  # (T * GRID, 6)
    node_marks: Integers  # (T * GRID,)
    whole_boxes: Array  # (T, 6)
    whole_marks: Integers  # (T,)
    interval_table: Integers  # (2, T * 2 * GRID) place in interval_boxes, mark
    interval_boxes: Array  # (.., 6)
    block_boxes: Array  # (B + SWEEP_POOL_BLOCKS, 6)
    pose: Array  # (1, 12)
    pool: Integers  # (3, 2 * SWEEP_POOL_BLOCKS) key, mark, block
    state: Integers  # (5,)
    stack: Integers  # (64, 2)
    ends: Integers  # (4,)
    united: Array  # (4, 6)


class Scratch(NamedTuple):
    """The scratch arrays of configuration and segment checks, because of which a view belongs to one thread."""

    blocks: Array  # (B + SWEEP_POOL_BLOCKS, 3, K): in the joint's frame; of sweeps
    axis: Array  # (3,)
    simplex: Array  # (4, 3)
    counters: Integers  # (8,) pairs, iterations, undecided, poses inside sweeps, checks, sweeps, positive


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
    """The argument `offset` of `support` for vertices at most `greatest` [m] from the origin.

    Raises:
        ValueError: a vertex is so far that rounding would exceed the budget's numeric share.
    """
    offset = 2.0 ** (np.ceil(np.log2(max(greatest, 1e-3))) + 1)
    if not rounding(offset) <= ROUNDING_BOUND:
        raise ValueError(f"the scene reaches {greatest:g} m from its origin: too far for the numeric tolerance")
    return float(offset)


def bodies_of(
    chain: Chain, moving: Sequence[MovingGroup], fixed: Sequence[FixedGroup], pairs: Integers
) -> tuple[Bodies, Array, Array]:
    """The bodies, their parts' blocks (B, 3, K) in the joint's frame, and the groups' radii (G,) about its origin [m].

    Raises:
        ValueError: vertices, poses or pairs are not usable.
    """
    groups_of: list[MovingGroup | FixedGroup] = [*moving, *fixed]
    packed = [group.enclosure.packed for group in groups_of]
    source, sizes, *_ = stacked(packed)
    groups, order = _groups(chain, moving, [len(p.sizes) for p in packed], pairs)
    blocks = np.empty(source.shape)
    part_extents, group_extents, radii = (
        np.empty((len(sizes), 6)),
        np.empty((len(packed), 6)),
        np.empty(len(packed)),
    )
    place_groups(source, sizes, groups[1], poses_of(moving, fixed), blocks, part_extents, group_extents, radii)
    greatest = float((reach(chain)[groups[0, :-1]] + radii).max(initial=0.0))
    numbered = np.array([pairs[order, 1], order])
    bodies = Bodies(len(moving), offset_for(greatest), groups, sizes, part_extents, group_extents, numbered)
    return bodies, blocks, radii


def _groups(
    chain: Chain, moving: Sequence[MovingGroup], part_counts: Sequence[int], pairs: Integers
) -> tuple[Integers, Integers]:
    """`Bodies.groups`, and the order that sorts the pairs by their first group."""
    count = len(part_counts)
    groups = np.zeros((3, count + 1), np.int64)
    groups[0, : len(moving)] = [g.joint for g in moving]
    if not (groups[0].min() >= 0 and groups[0].max() < chain.joints.shape[1]):
        raise ValueError("a group hangs on a joint that the tree does not have")
    np.cumsum(part_counts, out=groups[1, 1:])
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype != np.int64:
        raise ValueError(f"pairs are (P, 2) int64, not {pairs.shape} {pairs.dtype}")
    if len(pairs) and not (pairs.min() >= 0 and pairs[:, 0].max() < len(moving) and pairs[:, 1].max() < count):
        raise ValueError("a pair names a group that is not there")
    order = np.lexsort((pairs[:, 1], pairs[:, 0])).astype(np.int64)
    groups[2] = np.searchsorted(pairs[order, 0], np.arange(count + 1))
    return groups, order


def _in_python(kernel: Any) -> Any:
    """The Python function of a kernel: called once for each view, it is not worth compiling."""
    return getattr(kernel, "py_func", kernel)


def memory_of(margin: float, chain: Chain, bodies: Bodies, blocks: Array) -> tuple[Array, Scratch]:
    """All arrays of a configuration check in one flat array (`kernels.layout`), and the scratch arrays shared with sweeps.

    Args:
        margin: the value that an evaluated gap must exceed [m].
        blocks: the vertex blocks (B, 3, K) of the parts, in their joint's frame [m].
    """
    joints, groups = chain.joints.shape[1], len(bodies.group_extents)
    words = _in_python(words_for)(groups)
    world_T, allowed = np.zeros((joints, 12)), np.zeros((bodies.moving, words), np.int64)
    world_T[0, [0, 4, 8]] = 1.0
    rows = np.full((6, GROUPS_PER_WORD * words), PADDING_BOX_DISTANCE)
    # Fixed groups lie in the world already: their boxes are made once.
    centre, half = bodies.group_extents[:, :3].T, bodies.group_extents[:, 3:].T
    rows[:3, :groups], rows[3:, :groups] = centre - half, centre + half
    first = np.repeat(np.arange(groups), np.diff(bodies.groups[2]))
    np.bitwise_or.at(allowed, (first, bodies.pairs[0] // GROUPS_PER_WORD), 1 << bodies.pairs[0] % GROUPS_PER_WORD)
    listed, counters = (
        np.zeros(np.diff(bodies.groups[1]).max(initial=1), np.int64),
        np.zeros(COUNTER_PLACES, np.int64),
    )
    head = np.zeros(HEAD_PLACES, np.int64)
    whole = [head, counters, chain.joints, bodies.groups, bodies.sizes, bodies.pairs, allowed, listed]
    numbers = [*chain[1:], bodies.part_extents, bodies.group_extents, world_T, rows]
    numbers += [np.zeros(12), np.zeros(3), np.zeros((4, 3))]
    arrays = [*whole, *numbers, blocks]
    starts = list(accumulate((array.size for array in arrays), _in_python(after), initial=0))
    counts = joints, len(chain.bound), bodies.moving, groups, len(blocks), bodies.pairs.shape[1], len(listed)
    head[:MARGIN] = *counts, starts[len(whole)], starts[-2], SWEEP_POOL_BLOCKS, blocks.shape[2]
    head.view(np.float64)[[MARGIN, OFFSET]] = margin, bodies.offset
    memory = _laid_out(arrays, starts, room=SWEEP_POOL_BLOCKS * 3 * blocks.shape[2])
    *_, axis, simplex, blocks = _in_python(numbers_of)(memory)
    return memory, Scratch(blocks, axis, simplex, _in_python(whole_numbers_of)(memory)[0])


def _laid_out(arrays: Sequence[NDArray[Any]], starts: Sequence[int], room: int) -> Array:
    """One array, aligned to a cache line, with the given arrays at their starts, and with room for more numbers."""
    memory = np.empty(starts[-1] + room + CACHE_LINE_PLACES)
    begin = -memory.ctypes.data // memory.itemsize % CACHE_LINE_PLACES
    memory = memory[begin : begin + starts[-1] + room]
    for start, array in zip(starts, arrays, strict=False):
        memory[start : start + array.size].view(array.dtype)[:] = array.ravel()
    return memory


def tracks_of(chain: Chain, bodies: Bodies, radii: Array, diameters: Array, slack: Array) -> Tracks:
    """The tracks of all pairs: each is swept in the frame of the last joint that carries both groups.

    Args:
        slack: (G,) for each group, half of the part of epsilon left for spread, minus the group's deviation [m].
    """
    joint, first_pair = bodies.groups[0, :-1], bodies.groups[2]
    first = np.repeat(np.arange(len(joint)), np.diff(first_pair))
    second = bodies.pairs[0]
    frame, frames = last_shared_joints(chain, joint[first], joint[second]), chain.joints.shape[1]
    keys = np.concatenate([first, second]) * frames + np.concatenate([frame, frame])
    found, number = np.unique(keys, return_inverse=True)
    tracks = np.array([found // frames, found % frames], np.int64)
    lengths = np.linalg.norm(chain.placement[:, 9:], axis=1)
    pair_tracks = np.ascontiguousarray(number.reshape(2, -1), np.int64)
    return Tracks(lengths, radii, diameters, tracks, pair_tracks, slack[first] + slack[second])


def last_shared_joints(chain: Chain, first: Integers, second: Integers) -> Integers:
    """The last common ancestor (P,) of each pair of joints in the tree; 0 is the world."""
    carries = np.eye(chain.joints.shape[1], dtype=bool)  # carries[j, i]: joint i is j or before it
    for j in range(1, len(carries)):
        carries[j] |= carries[chain.joints[0, j]]
    shared = carries[first] & carries[second]
    last: Integers = shared.shape[1] - 1 - np.argmax(shared[:, ::-1], axis=1)  # parents come before children
    return last


def sweep_of(chain: Chain, bodies: Bodies, tracks: Tracks) -> Sweep:
    """Allocates the scratch arrays for sweeps; most pages are never written, and so use no memory."""
    count, parts, joints = tracks.tracks.shape[1], len(bodies.sizes), chain.joints.shape[1]
    frames = np.zeros((FRAME_SLOTS, joints, 12))
    frames[:, 0, [0, 4, 8]] = 1.0
    block_boxes = np.empty((parts + SWEEP_POOL_BLOCKS, 6))
    block_boxes[:parts, :3] = bodies.part_extents[:, :3] - bodies.part_extents[:, 3:]
    block_boxes[:parts, 3:] = bodies.part_extents[:, :3] + bodies.part_extents[:, 3:]
    most = int(np.diff(bodies.groups[1]).max(initial=1))
    return Sweep(
        segment=np.zeros((3, len(chain.bound))),
        turned=np.zeros(joints),
        motions=np.zeros((count, 3)),
        frames=frames,
        frame_tags=np.zeros(FRAME_SLOTS, np.int64),
        node_poses=np.empty((count * COARSE_NODES, 12)),
        node_boxes=np.empty((count * COARSE_NODES, 6)),
        node_marks=np.zeros(count * COARSE_NODES, np.int64),
        whole_boxes=np.empty((count, 6)),
        whole_marks=np.zeros(count, np.int64),
        interval_table=np.zeros((2, count * 2 * COARSE_NODES), np.int64),
        interval_boxes=np.empty((max(4096, 4 * most), 6)),
        block_boxes=block_boxes,
        pose=np.empty((1, 12)),
        pool=np.zeros((3, 2 * SWEEP_POOL_BLOCKS), np.int64),
        state=np.zeros(5, np.int64),
        stack=np.zeros((64, 2), np.int64),
        ends=np.zeros(4, np.int64),
        united=np.empty((4, 6)),
    )
