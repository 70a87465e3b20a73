"""The arrays of a collision view for kernels, made once from groups, pairs and a kinematic tree."""

from collections.abc import Sequence
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import (
    COUNTER_PLACES,
    JOINT,
    PAIRS,
    PARTNER,
    PARTS,
    ROOTS_END,
    Bodies,
    Chain,
    Extents,
    Hulls,
    Nodes,
    Pool,
    Search,
    Sweep,
    Tracks,
    Tree,
    Way,
)
from kabo.geometry.collision.kernels.configuration_check import SHORT_SLACK
from kabo.geometry.collision.kernels.layout import (
    CACHE_LINE_PLACES,
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
from kabo.geometry.collision.part_trees import known
from kabo.geometry.collision.placed_bodies import placed_bodies
from kabo.geometry.parts import COLUMNS, FixedGroup, MovingGroup, Packed
from kabo.scene import PRISMATIC, KinematicTree

ROUNDING_BOUND = 2e-10  # [m] of one evaluated gap; Budget.margin relies on it
SWEEP_POOL_ROWS = 1024  # placed parts kept during one sweep; configuration checks use the last one
PADDING_BOX_DISTANCE = 1e9  # [m] from the origin: boxes of padding groups lie there


class Arrays(NamedTuple):
    """The arrays of a view's bodies, as they do not change."""

    bodies: Bodies
    packed: Packed  # in the joint's frame
    extents: Extents
    cores: Array  # (B, 9) of `Outlines`
    children: Integers  # (B, 2)
    offset: float  # for `support`: a power of two of at least twice every |vertex|
    radii: Array  # (G,) how far corners and discs of parts that decide are from the joint's origin [m]
    kept: Array  # (2, G) what each group keeps from others beyond the margin [m], and the number of its hand


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
    chain: Chain, moving: Sequence[MovingGroup], fixed: Sequence[FixedGroup], pairs: Integers, geometry: float
) -> Arrays:
    """The arrays of bodies whose parts decide if they deviate by at most `geometry` [m].

    Raises:
        ValueError: vertices, poses or pairs are not usable.
    """
    given_groups: tuple[MovingGroup | FixedGroup, ...] = (*moving, *fixed)
    enclosures = tuple(known(group.enclosure) for group in given_groups)
    placed = placed_bodies(given_groups, enclosures, geometry)
    groups, order = _groups(chain, moving, placed.parts, pairs)
    greatest = float((reach(chain)[groups[JOINT, :-1]] + placed.radii[:, 1] + placed.far).max(initial=0.0))
    return Arrays(
        Bodies(groups, np.array([pairs[order, 1], order]), _allowed(groups, pairs[order], len(moving))),
        placed.packed,
        placed.extents,
        placed.cores,
        placed.children,
        offset_for(greatest),
        placed.radii[:, 0] + placed.room,
        placed.kept,
    )


def _groups(
    chain: Chain, moving: Sequence[MovingGroup], parts: Integers, pairs: Integers
) -> tuple[Integers, Integers]:
    """`Bodies.groups`, and the order that sorts the pairs by their first group."""
    count = parts.shape[1] - 1
    groups = np.zeros((4, count + 1), np.int64)
    groups[[PARTS, ROOTS_END]] = parts
    groups[JOINT, : len(moving)] = [g.joint for g in moving]
    if not (groups[JOINT].min() >= 0 and groups[JOINT].max() < chain.joints.shape[1]):
        raise ValueError("a group hangs on a joint that the tree does not have")
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype != np.int64:
        raise ValueError(f"pairs are (P, 2) int64, not {pairs.shape} {pairs.dtype}")
    if len(pairs) and not (pairs.min() >= 0 and pairs[:, 0].max() < len(moving) and pairs[:, 1].max() < count):
        raise ValueError("a pair names a group that is not there")
    order = np.lexsort((pairs[:, 1], pairs[:, 0])).astype(np.int64)
    groups[PAIRS] = np.searchsorted(pairs[order, 0], np.arange(count + 1))
    return groups, order


def _allowed(groups: Integers, pairs: Integers, moving: int) -> Integers:
    """`Bodies.allowed`."""
    allowed = np.zeros((moving, _in_python(words_for)(groups.shape[1] - 1)), np.int64)
    np.bitwise_or.at(allowed, (pairs[:, 0], pairs[:, 1] // GROUPS_PER_WORD), 1 << pairs[:, 1] % GROUPS_PER_WORD)
    return allowed


def _in_python(kernel: Any) -> Any:
    """The Python function of a kernel: called once for each view, it is not worth compiling."""
    return getattr(kernel, "py_func", kernel)


def memory_of(margin: float, chain: Chain, made: Arrays) -> tuple[Array, Hulls, Tree, Search]:
    """All arrays of a configuration check in one flat array (`kernels.layout`), and those that sweeps share with it.

    Args:
        margin: the value that an evaluated gap must exceed [m].
        chain: the kinematic tree.
        made: the bodies.
    """
    joints, groups, parts = chain.joints.shape[1], len(made.extents.groups), len(made.packed.sizes)
    columns = made.packed.blocks.shape[2]
    world_T, frames = np.zeros((joints, 12)), np.zeros((joints, 12))
    world_T[0, [0, 4, 8]] = 1.0
    frames[0] = np.eye(3, 4).ravel()
    rows = np.full((6, GROUPS_PER_WORD * _in_python(words_for)(groups)), PADDING_BOX_DISTANCE, np.float32)
    # Fixed groups lie in the world already: their boxes are made once.
    centre, half = made.extents.groups[:, :3].T, made.extents.groups[:, 3:6].T
    kept = made.kept * [[1.0 + 2.0 * SHORT_SLACK], [1.0]]  # for rounding to 24 bits, too
    half = half + SHORT_SLACK * (np.abs(centre) + half) + kept[0]
    rows[:3, :groups], rows[3:, :groups] = centre - half, centre + half
    roots = made.bodies.groups[ROOTS_END] - made.bodies.groups[PARTS]
    listed = np.zeros(max(1, int(roots[:-1].max(initial=1))), np.int64)
    sizes, rounds = np.zeros(parts + SWEEP_POOL_ROWS, np.int64), np.zeros((parts + SWEEP_POOL_ROWS, 5))
    sizes[:parts], rounds[:parts] = made.packed.sizes, made.packed.rounds
    head = np.zeros(HEAD_PLACES, np.int64)
    whole = [head, np.zeros(COUNTER_PLACES, np.int64), chain.joints, made.bodies.groups, sizes, made.children]
    whole += [np.zeros((parts + 1, 2), np.int64), made.bodies.pairs, made.bodies.allowed, listed]
    numbers = [
        *chain[1:],
        *made.extents,
        made.cores,
        made.packed.diameters,
        local_frames(chain.placement),
        world_T,
        frames,
        np.zeros((3, joints)),
        rows.view(np.float64),  # two short numbers in the place of one
        kept,
        np.zeros(12),
        np.zeros(3),
    ]
    numbers += [np.zeros((4, 3)), np.zeros((4, 3)), rounds]
    arrays = [*whole, *numbers, made.packed.blocks]
    starts = list(accumulate((array.size for array in arrays), _in_python(after), initial=0))
    moving, pairs = len(made.bodies.allowed), made.bodies.pairs.shape[1]
    counts = joints, len(chain.bound), moving, groups, parts, pairs, len(listed)
    head[:MARGIN] = *counts, starts[len(whole)], starts[-2], SWEEP_POOL_ROWS, columns
    head.view(np.float64)[[MARGIN, OFFSET]] = margin, made.offset
    memory = _laid_out(arrays, starts, room=SWEEP_POOL_ROWS * 3 * columns)
    *_, diameters, _, _, _, _, _, _, _, axis, simplex, points, rounds, blocks = _in_python(numbers_of)(memory)
    counters, _, _, sizes, children, stack, *_ = _in_python(whole_numbers_of)(memory)
    search = Search(made.offset, axis, simplex, points, counters)
    return memory, Hulls(blocks, sizes, rounds), Tree(children, diameters, stack), search


def local_frames(placement: Array) -> Array:
    """The terms (J, 6, 4) of joints' frames in their parents', for `frames_of`: what stays, and what is turned or slides.

    Row k of a joint's frame is row k here times (cos, cos, 1, 1), plus row 3 + k times (sin, -sin, 0, slide).
    """
    rotation = placement[:, :9].reshape(-1, 3, 3)
    kept = np.concatenate([rotation, placement[:, 9:, None]], axis=2)
    moved = rotation[:, :, [1, 0, 2, 2]] * [1.0, 1.0, 0.0, 1.0]
    return np.concatenate([kept, moved], axis=1)


def _laid_out(arrays: Sequence[NDArray[Any]], starts: Sequence[int], room: int) -> Array:
    """One array, aligned to a cache line, with the given arrays at their starts, and with room for more numbers."""
    memory = np.empty(starts[-1] + room + CACHE_LINE_PLACES)
    begin = -memory.ctypes.data // memory.itemsize % CACHE_LINE_PLACES
    memory = memory[begin : begin + starts[-1] + room]
    for start, array in zip(starts, arrays, strict=False):
        memory[start : start + array.size].view(array.dtype)[:] = array.ravel()
    return memory


def tracks_of(chain: Chain, made: Arrays, slack: Array) -> Tracks:
    """The tracks of all pairs: each is swept in the frame of the last joint that carries both groups.

    Args:
        chain: the kinematic tree.
        made: the bodies.
        slack: (G,) for each group, half of the part of epsilon left for spread, minus the group's deviation [m].
    """
    joint, first_pair = made.bodies.groups[JOINT, :-1], made.bodies.groups[PAIRS]
    first = np.repeat(np.arange(len(joint)), np.diff(first_pair))
    second = made.bodies.pairs[PARTNER]
    frame, frames = last_shared_joints(chain, joint[first], joint[second]), chain.joints.shape[1]
    keys = np.concatenate([first, second]) * frames + np.concatenate([frame, frame])
    found, number = np.unique(keys, return_inverse=True)
    tracks = np.array([found // frames, found % frames], np.int64)
    pair_tracks = np.ascontiguousarray(number.reshape(2, -1), np.int64)
    return Tracks(tracks, pair_tracks, slack[first] + slack[second], made.radii, made.kept)


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


def sweep_of(chain: Chain, made: Arrays, tracks: Tracks) -> Sweep:
    """Allocates the scratch arrays for sweeps; most pages are never written, and so use no memory."""
    count, parts, joints = tracks.tracks.shape[1], len(made.packed.sizes), chain.joints.shape[1]
    boxes, extents = np.empty((parts + SWEEP_POOL_ROWS, 6)), made.extents.parts
    boxes[:parts, :3], boxes[:parts, 3:] = extents[:, :3] - extents[:, 3:6], extents[:, :3] + extents[:, 3:6]
    most = int((made.bodies.groups[ROOTS_END] - made.bodies.groups[PARTS])[:-1].max(initial=1))
    nodes = Nodes(
        poses=np.empty((count * COARSE_NODES, 12)),
        boxes=np.empty((count * COARSE_NODES, 6)),
        marks=np.zeros(count * COARSE_NODES, np.int64),
        whole_boxes=np.empty((count, 6)),
        whole_marks=np.zeros(count, np.int64),
    )
    pool = Pool(
        keys=np.zeros((3, 2 * SWEEP_POOL_ROWS), np.int64),
        boxes=boxes,
        interval_table=np.zeros((2, count * 2 * COARSE_NODES), np.int64),
        interval_boxes=np.empty((max(4096, 4 * most), 6)),
        state=np.zeros(5, np.int64),
        stack=np.zeros((parts + 64, 4), np.int64),
        ends=np.zeros(4, np.int64),
        pose=np.empty((1, 12)),
        united=np.empty((4, 6)),
    )
    return Sweep(tracks, way_of(chain, np.zeros((FRAME_SLOTS, joints, 12)), count), nodes, pool)


def search_for(offset: float) -> Search:
    """The scratch arrays of a search for separating axes."""
    return Search(offset, np.zeros(3), np.zeros((4, 3)), np.zeros((4, 3)), np.zeros(COUNTER_PLACES, np.int64))


def pool_of(rows: int, columns: int = COLUMNS) -> Hulls:
    """So many rows for parts that a kernel places."""
    return Hulls(np.empty((rows, 3, columns)), np.zeros(rows, np.int64), np.zeros((rows, 5)))
