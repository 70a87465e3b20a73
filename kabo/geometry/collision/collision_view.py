"""Bounded collision predicates over one kinematic tree: a view validates its inputs once, then works on arrays.

"Free" is reported only if proven, otherwise a hit: a collision is never overlooked, but a gap narrower than the
budget's epsilon may be. A view keeps scratch space, so it belongs to one thread; its answers depend on its
arguments only. Views that are given the same `BodyMemories` use the arrays of the same bodies in turn.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.compilation import call_first
from kabo.geometry.budget import Budget
from kabo.geometry.collision.body_memories import BodyMemories
from kabo.geometry.collision.body_memory import Arrangement, BodyMemory
from kabo.geometry.collision.kernel_checks import KernelChecks
from kabo.geometry.collision.kernels.bundles import (
    CHECKS,
    FIRST_OPEN,
    FREE,
    PARTS,
    POSITIVE,
    SEARCHES,
    SWEEPS,
)
from kabo.geometry.collision.kernels.configuration_check import first_hit, first_hits
from kabo.geometry.collision.kernels.sweep import swept_hits
from kabo.geometry.collision.part_trees import refine
from kabo.geometry.collision.root_answers import RootAnswers, Touch
from kabo.geometry.collision.view_arrays import usable_deviations
from kabo.geometry.parts import FixedGroup, MovingGroup
from kabo.scene import KinematicTree


@dataclass
class Counters:
    """Counts of the checks that a view has made."""

    configuration_checks: int = 0
    sweep_checks: int = 0
    pair_checks: int = 0  # narrow-phase calls
    positive: int = 0  # checks that were not proven free

    @property
    def numbers(self) -> tuple[int, int, int, int]:
        """All counts, in this order, as they are now."""
        return self.configuration_checks, self.sweep_checks, self.pair_checks, self.positive


class CollisionChecker(Protocol):
    """The interface of collision checks: a `CollisionView` on convex parts, or an `ExactView` on the original meshes."""

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are free at configuration q (n,), else the index of the first pair that is not."""

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n)."""

    def segment_hit(self, start: Array, end: Array, deviation: Array | None = None) -> int:
        """-1 if all pairs are proven free on the whole straight segment, else the index of a pair that is not.

        `deviation` (n,): how far each value may be from the segment [rad or m]; None for zeros.
        """

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n)."""

    def segments_free_early(self, starts: Array, ends: Array, deviations: Array) -> Booleans:
        """Which rows (N,) are proven free without dividing any part; False where that would take finer parts, too."""

    @property
    def kernel_checks(self) -> KernelChecks | None:
        """What other kernels need to make these checks themselves; None if there are no kernels for them."""

    @property
    def counters(self) -> Counters:
        """The numbers of checks that were made so far."""


class CollisionView:
    """Finds a pair of bodies that may collide, at a configuration or along a straight joint-space segment."""

    def __init__(
        self,
        tree: KinematicTree,
        moving: Sequence[MovingGroup],
        fixed: Sequence[FixedGroup],
        pairs: Integers,
        budget: Budget,
        touch: Touch | None = None,
        memories: BodyMemories | None = None,
    ) -> None:
        """A view of the bodies as they are now.

        Args:
            tree: all joints; its prismatic joints need finite limits.
            moving: bodies on joints. fixed: bodies in the world. A pair keeps more than the budget's clearance where its
                bodies have something `kept`.
            pairs: (P, 2) index into moving, and index into moving and then fixed.
            budget: how epsilon is spent; no enclosure may deviate by more than `budget.geometry`.
            touch: whether the surfaces of the pair with an index meet at q (n,); asked where the roots of trees do not
                decide, before children are made.
            memories: shared by views that are used by the same thread; None: the view has its own.

        Raises:
            ValueError: arrays of wrong type, shape or values; an enclosure that breaks the budget.
        """
        self._tree, self._size, self._budget = tree, tree.size, budget
        self._moving, self._fixed, self._pairs = moving, fixed, np.asarray(pairs).reshape(-1, 2)
        self._groups: list[MovingGroup | FixedGroup] = [*moving, *fixed]
        self._memories = BodyMemories() if memories is None else memories
        coarse = self._memories.budget_of_roots(tuple([group.enclosure for group in self._groups]), budget)
        self._coarse = (
            None
            if coarse is None
            else CollisionView(tree, moving, fixed, self._pairs, coarse, None, self._memories)
        )
        self._roots = None if self._coarse is None else RootAnswers(self._coarse, touch)
        self._bodies, self._own = self._arranged()
        if self._coarse is None:  # else roots mostly decide
            self._put()

    def _arranged(self) -> tuple[BodyMemory, Arrangement]:
        """The memory of all parts that are known, and what is put into it."""
        bodies = self._memories.of(self._tree, self._moving, self._fixed, len(self._pairs), self._budget)
        return bodies, Arrangement(bodies, self._groups, self._pairs)

    def _put(self) -> Array:
        """The array of `first_hit`, with what the view asks about in place."""
        self._memory = self._bodies.put(self._own)
        return self._memory

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are proven free at q (n,) with the budget's clearance, else the index of the first that is not.

        Raises:
            ValueError: q has the wrong size, is not finite, or lies far outside a prismatic joint's limits.
        """
        if not self._own.direct:
            return self._hit(q)
        try:  # a check takes a microsecond, of which a look at the array would be a tenth
            found: int = first_hit(q, self._memory)
        except TypeError:  # another kind of array
            return self._hit(q)
        if found < FREE:
            raise self._refusal(q)
        return found

    def _hit(self, q: Array) -> int:
        """`configuration_hit` where parts may have to be divided, for whatever can be made a row."""
        row = np.ascontiguousarray(q, np.float64)
        row = row if row.flags.carray else row.copy()
        if row.ndim != 1:
            raise self._refusal(row)
        decided = None if self._roots is None else self._roots.configuration_hit(row)
        return self._by_parts(row) if decided is None else decided

    def _by_parts(self, row: Array) -> int:
        found = self._decided(lambda: call_first(first_hit, row, self._put()))
        self._own.direct = (
            not self._bodies.open and self._roots is None
        )  # whose answers do not depend on what is known
        if found < FREE:
            raise self._refusal(row)
        return found

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n).

        Raises:
            ValueError: as `configuration_hit`.
        """
        rows = np.ascontiguousarray(configurations, np.float64)
        if rows.ndim != 2 or rows.shape[1] != self._size:
            raise ValueError(f"configurations are (N, {self._size}), not {rows.shape}")
        answers = np.empty(len(rows), np.int64)
        if self._roots is not None:
            answers, left = self._roots.configurations_hit(rows)
            answers[left] = [self._by_parts(rows[i]) for i in left]
        elif self._bodies.open:
            answers[:] = [self.configuration_hit(row) for row in rows]
        elif first_hits(rows, answers, self._put()) < len(rows):
            raise self._refusal(rows[0])
        return answers

    def segment_hit(self, start: Array, end: Array, deviation: Array | None = None) -> int:
        """-1 if all pairs are proven free on the whole straight segment, else the index of the first that is not.

        Bodies that come no closer than the budget's epsilon are free, beyond what they keep; pairs that do not move
        relative to each other are checked as well.

        Args:
            start: the beginning of the segment (n,). end: its end (n,).
            deviation: how far each value may be from the segment (n,) [rad or m], at any place of it; None for zeros.

        Raises:
            ValueError: as `configuration_hit`; a deviation is negative or not finite.
        """
        first, last = np.ascontiguousarray(start, np.float64), np.ascontiguousarray(end, np.float64)
        if not first.ndim == last.ndim == 1:
            raise self._refusal(first if first.ndim != 1 else last)
        off = np.zeros(self._size) if deviation is None else np.asarray(deviation, np.float64)
        return int(self.segments_hit(first[None], last[None], off[None])[0])

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n).

        Raises:
            ValueError: as `segment_hit`.
        """
        first, last = np.ascontiguousarray(starts, np.float64), np.ascontiguousarray(ends, np.float64)
        off = usable_deviations(deviations, self._size)
        for rows in (first, last):
            if rows.shape != off.shape:
                raise self._refusal(rows[0] if rows.ndim == 2 and len(rows) == len(off) else rows)
        if self._roots is None:
            return self._swept(first, last, off)
        answers, left = self._roots.segments_hit(first, last, off)
        if left:
            answers[left] = self._swept(first[left], last[left], off[left])
        return answers

    def segments_free_early(self, starts: Array, ends: Array, deviations: Array) -> Booleans:
        """Which rows (N,) of three arrays (N, n) are proven free by the roots of trees alone, whatever has been divided.

        Raises:
            ValueError: as `segment_hit`.
        """
        view = self if self._coarse is None else self._coarse
        return np.asarray(view.segments_hit(starts, ends, deviations) < 0)

    def _swept(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The answers of the kernel, with all children that it needs."""
        answers, done = np.empty(len(starts), np.int64), 0
        while done < len(starts):
            step = 1 if self._bodies.open else len(starts)  # a row is asked again for each part that it divides
            rows = slice(done, done + step)
            given = starts[rows], ends[rows], deviations[rows], answers[rows]
            if self._decided(partial(self._swept_once, *given)) < FREE:
                raise self._refusal(ends[done])
            done += step
        return answers

    def _swept_once(self, starts: Array, ends: Array, deviations: Array, answers: Integers) -> int:
        """The last answer of the kernel, which is the first that it cannot decide; it uses the parts that are known."""
        decided = swept_hits(starts, ends, deviations, answers, *self._bodies.sweep_arguments(self._own))
        return int(answers[min(decided, len(answers) - 1)])

    def _decided(self, ask: Callable[[], int]) -> int:
        """The answer of a kernel, with all children that it needs.

        It asks again from the beginning, and counts the last time alone, as if they had been known.
        """
        before = self._own.counts.copy()
        while (found := ask()) <= FIRST_OPEN:
            part, starts = FIRST_OPEN - found, self._bodies.groups[PARTS]
            group = int(np.searchsorted(starts, part, side="right")) - 1
            refine(self._groups[group].enclosure, part - int(starts[group]))
            self._bodies, self._own = self._arranged()
            self._own.counts = before.copy()
        return found

    @property
    def kernel_checks(self) -> KernelChecks:
        """What other kernels need to make these checks themselves: of the roots, where parts may have to be divided.

        It is valid until another view that shares the memories is asked.
        """
        decided_by = self if self._coarse is None else self._coarse
        sweep = decided_by._bodies.sweep_arguments(decided_by._own)
        return KernelChecks(
            decided_by._put(),
            sweep,
            free_counts=True,
            hit_counts=self._coarse is None,
            configurations_hit=self.configurations_hit,
            segment_hit=self.segment_hit,
        )

    @property
    def counters(self) -> Counters:
        """The numbers of checks that were made so far, by roots alone and by all parts."""
        own = self._own.counts
        counts = own if self._coarse is None else own + self._coarse._own.counts
        found = counts.tolist()
        return Counters(found[CHECKS], found[SWEEPS], found[SEARCHES], found[POSITIVE])

    def _refusal(self, row: Array) -> ValueError:
        if row.ndim != 1:
            return ValueError(f"a configuration is one row, not {row.shape}")
        return ValueError(f"a configuration has {self._size} finite values within the limits of sliding joints")
