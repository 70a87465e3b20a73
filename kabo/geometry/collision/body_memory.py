"""The flat memory of a list of bodies, which views that ask about them elsewhere, or about other pairs, use in turn.

Situations of a scene have the same bodies; one or two of them stand elsewhere, or may touch something. So the arrays of
all their parts are laid out once. A view puts in place what differs from the view before: poses, distances, pairs.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.kernels.bundles import (
    CHILD_COUNT,
    COUNTER_PLACES,
    EXTENT_COLUMNS,
    FIRST_CHILD,
    JOINT,
    OPEN,
    PAIRS,
    PARTS,
    ROOTS_END,
    Bodies,
    Extents,
    Hulls,
    Nodes,
    Pool,
    Scene,
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
from kabo.geometry.collision.kernels.sweep import KNOWN_AXES
from kabo.geometry.collision.kernels.tracks import COARSE_NODES, FRAME_SLOTS
from kabo.geometry.collision.part_trees import children_within, deviation_within, is_flat, known
from kabo.geometry.collision.placed_bodies import Sources, part_ranges, place, sources_of
from kabo.geometry.collision.view_arrays import (
    chain_of,
    last_shared_joints,
    local_frames,
    offset_for,
    reach,
    tracks_of,
    way_of,
)
from kabo.geometry.parts import FixedGroup, MovingGroup, poses_of
from kabo.scene import KinematicTree

SWEEP_POOL_ROWS = 1024  # placed parts kept during one sweep; configuration checks use the last one
MOST_BETWEEN = 4  # bodies that are put where they are already, as one call for several costs more than that
PADDING_BOX_DISTANCE = 1e9  # [m] from the origin: boxes of padding groups lie there

SweepArguments = tuple[Any, ...]


class Arrangement:
    """Where the bodies of a view are, and which pairs of them it asks about: what a view has of its own."""

    def __init__(self, memory: "BodyMemory", given: Sequence[MovingGroup | FixedGroup], pairs: Integers) -> None:
        """The arrangement of some bodies with pairs (P, 2).

        Raises:
            ValueError: poses or pairs are not usable.
        """
        self.poses = poses_of(given)
        self.kept = np.array([[g.kept for g in given], [g.hand for g in given]], np.float64)
        self.place = self.poses.tobytes(), self.kept.tobytes()
        self.bodies = memory.bodies_with(pairs)
        self.counts = np.zeros(COUNTER_PLACES, np.int64)
        self.sweep: SweepArguments | None = None  # made for the first sweep: many views are asked for none
        self.direct = False  # whether it is in place, and the kernel takes rows alone


class BodyMemory:
    """All arrays of configuration checks and sweeps of some bodies, with one arrangement in place at a time."""

    def __init__(
        self,
        tree: KinematicTree,
        given: Sequence[MovingGroup | FixedGroup],
        joints: Sequence[int],
        budget: Budget,
        most_pairs: int,
    ) -> None:
        """The memory of bodies, the first of which are on `joints`, with room for `most_pairs`.

        Raises:
            ValueError: the tree is not usable, or has no such joint.
        """
        self.tree, self.budget, self.moving = tree, budget, len(joints)
        self._chain, self._most_pairs = chain_of(tree), most_pairs
        self._enclosures = tuple(known(group.enclosure) for group in given)
        self.groups = part_ranges(self._enclosures)
        self.groups[JOINT, : len(joints)] = joints
        if not (self.groups[JOINT].min() >= 0 and self.groups[JOINT].max() < self._chain.joints.shape[1]):
            raise ValueError("a group hangs on a joint that the tree does not have")
        deviations = np.array([deviation_within(group.enclosure, budget.geometry) for group in given], np.float64)
        # The rest of epsilon for a sweep's spread: at least `budget.sweep`, more if the parts are tighter.
        self._slack = (budget.epsilon - budget.clearance - budget.numeric) / 2 - deviations
        self._poses, self._kept = np.full((len(given), 12), np.nan), np.zeros((2, len(given)))
        self._radii, self._spans, self._offset = np.empty((len(given), 2)), np.empty(len(given)), math.nan
        self._with_pairs: dict[tuple[object, ...], Bodies] = {}
        self._known_tracks: dict[int, Tracks] = {}  # by the identity of what `_with_pairs` keeps
        self._present: Arrangement | None = None
        self._place: tuple[bytes, bytes] | None = None  # of the bodies as they are in the array
        self._scratch: tuple[Way, Nodes, Pool] | None = None

    def put(self, own: Arrangement) -> Array:
        """The memory for kernels, in which an arrangement is in place.

        Raises:
            ValueError: a body is so far away that rounding would exceed the budget's numeric share.
        """
        if own is self._present:
            return self.array
        if self._present is not None:
            self._present.counts, self._present.direct = self._counters.copy(), False
            self._present = None
        array = self.array
        if own.place != self._place:  # many arrangements differ in their pairs alone
            self._place = None  # if they cannot be put there, this is tried again
            if self._move(own.poses, own.kept):
                self._offset = math.nan
                self._offset = offset_for(float((self._reach + self._radii[:, 1] + self._far).max(initial=0.0)))
                array[OFFSET] = self._offset
            self._place = own.place
        self._ranges[PAIRS] = own.bodies.groups[PAIRS]
        self._pairs[:, : own.bodies.pairs.shape[1]] = own.bodies.pairs
        self._allowed[:] = own.bodies.allowed
        self._counters[:] = own.counts
        own.counts, self._present = self._counters, own
        return array

    def sweep_arguments(self, own: Arrangement) -> SweepArguments:
        """The arguments of `first_swept_hit` behind both ends of a segment, with the arrangement in place."""
        self.put(own)
        if own.sweep is None:
            if self._scratch is None:
                self._scratch = self._new_scratch()
            search = Search(self._offset, *self._searching)
            sweep = Sweep(self._tracks(own.bodies), *self._scratch)
            own.sweep = self.budget.margin, self.budget.clearance, own.bodies.pairs, self._scene, sweep, search
        return own.sweep

    def bodies_with(self, pairs: Integers) -> Bodies:
        """The bodies with pairs (P, 2) of them; arrangements with the same pairs share it.

        Raises:
            ValueError: the pairs are not usable.
        """
        key = pairs.dtype, pairs.shape, pairs.tobytes()
        found = self._with_pairs.get(key)
        if found is None:
            groups, count = self.groups.copy(), self.groups.shape[1] - 1
            order = _order_of(pairs, self.moving, count)
            groups[PAIRS] = np.searchsorted(pairs[order, 0], np.arange(count + 1))
            allowed = _allowed(groups, pairs[order], self.moving)
            found = self._with_pairs[key] = Bodies(groups, np.array([pairs[order, 1], order]), allowed)
        return found

    def _tracks(self, bodies: Bodies) -> Tracks:
        """The tracks of the pairs of bodies; arrangements with the same pairs share them, too."""
        found = self._known_tracks.get(id(bodies))
        if found is None:
            found = tracks_of(self._shared_joints, bodies, self._slack, self._spans, self._kept)
            self._known_tracks[id(bodies)] = found
        return found

    def _move(self, poses: Array, kept: Array) -> bool:
        """Writes the parts of bodies that stand elsewhere, and the boxes of those that keep another distance, too.

        The result is whether some stand elsewhere, or how far bodies reach is not known yet.
        """
        other = (poses.view(np.int64) != self._poses.view(np.int64)).any(axis=1)
        for first, end in _runs(other):
            self._poses[first:end] = np.nan  # until they are placed
            place(self._source, poses, first, end, self._hulls, self._extents, self._radii, self._cores)
            self._spans[first:end] = self._radii[first:end, 0] + self._room[first:end]
            if self._scratch is not None:
                self._box_parts(self._scratch[2].boxes, *self.groups[PARTS, [first, end]].tolist())
            self._poses[first:end] = poses[first:end]
        keeps = (kept != self._kept).any(axis=0)
        if keeps.any():
            self._kept[:] = kept
            self._kept_rounded[:] = kept * [[1.0 + 2.0 * SHORT_SLACK], [1.0]]  # for rounding to 24 bits, too
        changed = (other | keeps).nonzero()[0]
        if len(changed):
            # Fixed groups lie in the world already: their boxes are made once. Those between stay as they are.
            first, end = changed[0], changed[-1] + 1
            centre, half = self._extents.groups[first:end, :3].T, self._extents.groups[first:end, 3:6].T
            half = half + SHORT_SLACK * (np.abs(centre) + half) + self._kept_rounded[0, first:end]
            self._rows[:3, first:end], self._rows[3:, first:end] = centre - half, centre + half
        return bool(other.any()) or math.isnan(self._offset)

    def _box_parts(self, boxes: Array, first: int, end: int) -> None:
        """Writes the boxes of parts in their joint's frame (B, 6), lower and upper."""
        extents = self._extents.parts[first:end]
        boxes[first:end, :3], boxes[first:end, 3:] = (
            extents[:, :3] - extents[:, 3:6],
            extents[:, :3] + extents[:, 3:6],
        )

    @cached_property
    def open(self) -> bool:
        """Whether there are parts that must be divided before they decide."""
        return bool((self._children[:, CHILD_COUNT] == OPEN).any())

    @cached_property
    def _shared_joints(self) -> Integers:
        """The last joint (J, J) that carries both of two joints."""
        joints = np.arange(self._chain.joints.shape[1])
        every = last_shared_joints(self._chain, joints.repeat(len(joints)), np.tile(joints, len(joints)))
        return every.reshape(len(joints), -1)

    @cached_property
    def _source(self) -> Sources:
        return sources_of(self._enclosures)

    @cached_property
    def _children(self) -> Integers:
        """The children (B, 2) of all parts, numbered among all."""
        own = (children_within(each, self.budget.geometry) for each in self._enclosures)
        children = np.concatenate([np.empty((0, 2), np.int64), *own])
        children[:, FIRST_CHILD] += np.where(
            children[:, CHILD_COUNT] > 0, self.groups[PARTS, self._source.owner], 0
        )
        return children

    @cached_property
    def array(self) -> Array:
        """The flat array (`kernels.layout`), made when the first arrangement is put in place."""
        geometry = self.budget.geometry
        deep = np.array([not is_flat(each, geometry) for each in self._enclosures], np.bool_)
        roots = np.array([each.deviation_of_roots for each in self._enclosures], np.float64)
        # What of the budget's share parts that are not roots may need, and how far they may be outside these [m].
        self._room = np.where(deep, geometry, 0.0)
        self._reach, self._far = reach(self._chain)[self.groups[JOINT, :-1]], np.where(deep, roots, 0.0)
        made = self._laid_out()
        self._note_windows(made)
        return made

    def _laid_out(self) -> Array:
        """The flat array with all that does not depend on where bodies are."""
        chain, packed = self._chain, self._source.packed
        joints, groups, parts = chain.joints.shape[1], self.groups.shape[1] - 1, len(packed.sizes)
        columns, words = packed.blocks.shape[2], _in_python(words_for)(groups)
        world_T, frames = np.zeros((joints, 12)), np.zeros((joints, 12))
        world_T[0, [0, 4, 8]] = 1.0
        frames[0] = np.eye(3, 4).ravel()
        rows = np.full((6, GROUPS_PER_WORD * words), PADDING_BOX_DISTANCE, np.float32)
        roots = self.groups[ROOTS_END] - self.groups[PARTS]
        listed = np.zeros(max(1, int(roots[:-1].max(initial=1))), np.int64)
        sizes, rounds = np.zeros(parts + SWEEP_POOL_ROWS, np.int64), np.zeros((parts + SWEEP_POOL_ROWS, 5))
        sizes[:parts] = packed.sizes
        head = np.zeros(HEAD_PLACES, np.int64)
        whole = [head, np.zeros(COUNTER_PLACES, np.int64), chain.joints, self.groups, sizes, self._children]
        whole += [np.zeros((parts + 1, 2), np.int64), np.zeros((2, self._most_pairs), np.int64)]
        whole += [np.zeros((self.moving, words), np.int64), listed]
        numbers = [
            *chain[1:],
            np.zeros((parts, EXTENT_COLUMNS)),
            np.zeros((groups, EXTENT_COLUMNS)),
            self._source.cores,
            packed.diameters,
            local_frames(chain.placement),
            world_T,
            frames,
            np.zeros((3, joints)),
            rows.view(np.float64),  # two short numbers in the place of one
            np.zeros((2, groups)),
            np.zeros(12),
            np.zeros(3),
        ]
        numbers += [np.zeros((4, 3)), np.zeros((4, 3)), rounds]
        arrays, blocks = [*whole, *numbers], packed.blocks.size
        starts = list(accumulate([*(a.size for a in arrays), blocks], _in_python(after), initial=0))
        counts = joints, len(chain.bound), self.moving, groups, parts, self._most_pairs, len(listed)
        head[:MARGIN] = *counts, starts[len(whole)], starts[-2], SWEEP_POOL_ROWS, columns
        head.view(np.float64)[MARGIN] = self.budget.margin
        return _laid_out(arrays, starts, room=SWEEP_POOL_ROWS * 3 * columns)

    def _note_windows(self, made: Array) -> None:
        """Notes the arrays in the memory that are written when another arrangement is put in place."""
        _, _, _, part_extents, group_extents, _, self._cores, diameters, *others = _in_python(numbers_of)(made)
        _, _, _, _, self._rows, self._kept_rounded, _, axis, simplex, points, rounds, blocks = others
        self._counters, _, self._ranges, sizes, children, stack, self._pairs, self._allowed, _ = _in_python(
            whole_numbers_of
        )(made)
        self._extents, self._hulls = Extents(part_extents, group_extents), Hulls(blocks, sizes, rounds)
        self._scene = Scene(
            self._chain, self._ranges, self._hulls, self._extents, Tree(children, diameters, stack)
        )
        self._searching = axis, simplex, points, self._counters

    def _new_scratch(self) -> tuple[Way, Nodes, Pool]:
        """The scratch arrays of sweeps for all tracks that there may be; most pages are never written, or used."""
        groups, parts, joints = (
            self.groups.shape[1] - 1,
            len(self._source.packed.sizes),
            self._chain.joints.shape[1],
        )
        count = min(2 * self._most_pairs, groups * joints)
        most = int((self.groups[ROOTS_END] - self.groups[PARTS])[:-1].max(initial=1))
        nodes = Nodes(
            poses=np.empty((count * COARSE_NODES, 12)),
            boxes=np.empty((count * COARSE_NODES, 6)),
            marks=np.zeros(count * COARSE_NODES, np.int64),
            whole_boxes=np.empty((count, 6)),
            whole_marks=np.zeros(count, np.int64),
        )
        pool = Pool(
            keys=np.zeros((3, 2 * SWEEP_POOL_ROWS), np.int64),
            boxes=np.empty((parts + SWEEP_POOL_ROWS, 6)),
            interval_table=np.zeros((2, count * 2 * COARSE_NODES), np.int64),
            interval_boxes=np.empty((max(4096, 4 * most), 6)),
            state=np.zeros(5, np.int64),
            stack=np.zeros((parts + 64, 4), np.int64),
            ends=np.zeros(4, np.int64),
            pose=np.empty((1, 12)),
            united=np.empty((4, 6)),
            known=np.zeros((KNOWN_AXES, 3)),
        )
        self._box_parts(pool.boxes, 0, parts)
        return way_of(self._chain, np.zeros((FRAME_SLOTS, joints, 12)), count), nodes, pool


def _runs(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The stretches of those chosen (G,), and of a few between them: the first of each, and the one after the last."""
    places = chosen.nonzero()[0].tolist()
    breaks = [i + 1 for i, (a, b) in enumerate(pairwise(places)) if b > a + 1 + MOST_BETWEEN]
    return [(places[a], places[b - 1] + 1) for a, b in pairwise([0, *breaks, len(places)]) if b > a]


def _order_of(pairs: Integers, moving: int, count: int) -> Integers:
    """The order that sorts pairs (P, 2) by their first group.

    Raises:
        ValueError: the pairs are not usable.
    """
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype != np.int64:
        raise ValueError(f"pairs are (P, 2) int64, not {pairs.shape} {pairs.dtype}")
    if len(pairs) and not (pairs.min() >= 0 and pairs[:, 0].max() < moving and pairs[:, 1].max() < count):
        raise ValueError("a pair names a group that is not there")
    return np.lexsort((pairs[:, 1], pairs[:, 0])).astype(np.int64)


def _allowed(groups: Integers, pairs: Integers, moving: int) -> Integers:
    """`Bodies.allowed`."""
    allowed = np.zeros((moving, _in_python(words_for)(groups.shape[1] - 1)), np.int64)
    np.bitwise_or.at(allowed, (pairs[:, 0], pairs[:, 1] // GROUPS_PER_WORD), 1 << pairs[:, 1] % GROUPS_PER_WORD)
    return allowed


def _in_python(kernel: Any) -> Any:
    """The Python function of a kernel: called once for each view, it is not worth compiling."""
    return getattr(kernel, "py_func", kernel)


def _laid_out(arrays: Sequence[NDArray[Any]], starts: Sequence[int], room: int) -> Array:
    """One array, aligned to a cache line, with the given arrays at their starts, and with room for more numbers."""
    memory = np.empty(starts[-1] + room + CACHE_LINE_PLACES)
    begin = -memory.ctypes.data // memory.itemsize % CACHE_LINE_PLACES
    memory = memory[begin : begin + starts[-1] + room]
    for start, array in zip(starts, arrays, strict=False):
        memory[start : start + array.size].view(array.dtype)[:] = array.ravel()
    return memory
