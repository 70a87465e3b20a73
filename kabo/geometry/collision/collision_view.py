"""Bounded collision predicates over one kinematic tree: a view validates its inputs once, then works on arrays.

"Free" is reported only if proven, otherwise a hit: a collision is never overlooked, but a gap narrower than the
budget's epsilon may be. A view keeps scratch space, so it belongs to one thread; its answers depend on its
arguments only.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.kernels.configuration_check import first_hit, first_hits
from kabo.geometry.collision.kernels.sweep import first_swept_hit
from kabo.geometry.collision.view_arrays import bodies_of, chain_of, memory_of, sweep_of, tracks_of
from kabo.geometry.parts import FixedGroup, MovingGroup
from kabo.scene import KinematicTree

FREE = -1  # the answer "proven free" of the kernels and of every view
UNUSABLE = -2  # the answer of kernels for an invalid configuration


@dataclass
class Counters:
    """Counts of the checks that a view has made."""

    configuration_checks: int = 0
    sweep_checks: int = 0
    pair_checks: int = 0  # narrow-phase calls
    positive: int = 0  # checks that were not proven free


class CollisionChecker(Protocol):
    """The interface of collision checks: a `CollisionView` on convex parts, or an `ExactView` on the original meshes."""

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are free at configuration q (n,), else the index of the first pair that is not."""

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n)."""

    def segment_hit(self, start: Array, end: Array) -> int:
        """-1 if all pairs are proven free on the whole straight segment, else the index of a pair that is not."""

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
    ) -> None:
        """A view of the bodies as they are now.

        Args:
            tree: all joints; its prismatic joints need finite limits.
            moving: bodies on joints. fixed: bodies in the world.
            pairs: (P, 2) index into moving, and index into moving and then fixed.
            budget: how epsilon is spent; no enclosure may deviate by more than `budget.geometry`.

        Raises:
            ValueError: arrays of wrong type, shape or values; an enclosure that breaks the budget.
        """
        groups: list[MovingGroup | FixedGroup] = [*moving, *fixed]
        deviations = np.array([group.enclosure.deviation for group in groups], np.float64)
        if not (deviations <= budget.geometry).all():
            raise ValueError(
                f"an enclosure deviates by {deviations.max():g} m, the budget allows {budget.geometry:g} m"
            )
        chain = chain_of(tree)
        bodies, blocks, radii = bodies_of(chain, moving, fixed, np.asarray(pairs).reshape(-1, 2))
        diameters = np.concatenate([np.empty(0), *(group.enclosure.packed.diameters for group in groups)])
        # The rest of epsilon for a sweep's spread: at least `budget.sweep`, more if the parts are tighter.
        slack = (budget.epsilon - budget.clearance - budget.numeric) / 2 - deviations
        tracks = tracks_of(chain, bodies, radii, diameters, slack)
        self._memory, scratch = memory_of(budget.margin, chain, bodies, blocks)
        self._size, self._counts = tree.size, scratch.counters
        self._sweep = (
            *(budget.margin, budget.clearance, *chain, *bodies[1:], *scratch),
            *(*tracks, *sweep_of(chain, bodies, tracks)),
        )

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are proven free at q (n,) with the budget's clearance, else the index of the first that is not.

        Raises:
            ValueError: q has the wrong size, is not finite, or lies far outside a prismatic joint's limits.
        """
        row = np.ascontiguousarray(q, np.float64)
        found = first_hit(row, self._memory) if row.ndim == 1 else UNUSABLE
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
        first_hits(rows, answers, self._memory)
        if answers.min(initial=FREE) < FREE:
            raise self._refusal(rows[0])
        return answers

    def segment_hit(self, start: Array, end: Array) -> int:
        """-1 if all pairs are proven free on the whole straight segment, else the index of the first that is not.

        Bodies that come no closer than the budget's epsilon are free; pairs that do not move relative to each other
        are checked as well.

        Raises:
            ValueError: as `configuration_hit`.
        """
        first, last = np.ascontiguousarray(start, np.float64), np.ascontiguousarray(end, np.float64)
        found = first_swept_hit(first, last, *self._sweep) if first.ndim == last.ndim == 1 else UNUSABLE
        if found < FREE:
            raise self._refusal(first if first.ndim != 1 else last)
        return found

    @property
    def counters(self) -> Counters:
        """The numbers of checks that were made so far."""
        pairs, _, _, _, checks, sweeps, positive, _ = self._counts.tolist()
        return Counters(checks, sweeps, pairs, positive)

    def _refusal(self, row: Array) -> ValueError:
        if row.ndim != 1:
            return ValueError(f"a configuration is one row, not {row.shape}")
        return ValueError(f"a configuration has {self._size} finite values within the limits of sliding joints")
