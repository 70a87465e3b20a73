"""What the roots of trees of parts decide alone: that bodies are apart, or that their surfaces meet.

To make the children of a part takes seconds, and they decide only what lies between: bodies nearer than their roots
can tell, which do not touch. Both answers here are those that children would give, so they are asked first.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.budget import Budget
from kabo.geometry.collision.part_trees import is_flat
from kabo.geometry.parts import Enclosure

Touch = Callable[[Array, int], bool]

WITNESSES = 5  # configurations of a segment at which surfaces are compared


def budget_of_roots(enclosures: Sequence[Enclosure], budget: Budget) -> Budget | None:
    """The budget in which the roots of some enclosures decide everything; None if they do in the given one."""
    deep = [each.deviation_of_roots for each in enclosures if not is_flat(each, budget.geometry)]
    return replace(budget, geometry=max(deep), shared=None) if deep else None


class Questions(Protocol):
    """The questions that are asked of roots: those of a `CollisionView`."""

    def configuration_hit(self, q: Array) -> int:
        """-1 if all pairs are free at q (n,), else the index of the first pair that is not."""

    def configurations_hit(self, configurations: Array) -> Integers:
        """The result of `configuration_hit` for every row (N, n)."""

    def segment_hit(self, start: Array, end: Array, deviation: Array | None = None) -> int:
        """-1 if all pairs are free on the whole straight segment, else the index of a pair that is not."""

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> Integers:
        """The result of `segment_hit` for every row of three arrays (N, n)."""


@dataclass(frozen=True)
class RootAnswers:
    """The same questions, answered where roots or the surfaces themselves decide.

    `touch` says whether the surfaces of the pair with an index meet at q (n,); None if that is not known.
    """

    roots: Questions
    touch: Touch | None

    def configuration_hit(self, q: Array) -> int | None:
        """-1 if all pairs are proven free at q (n,); the first pair that is not, if its surfaces meet; else None."""
        found = self.roots.configuration_hit(q)
        return found if found < 0 or self._meets(q, found) else None

    def configurations_hit(self, rows: Array) -> tuple[Integers, list[int]]:
        """The answers (N,) for rows (N, n), and the indices of those that are undecided."""
        answers = self.roots.configurations_hit(rows)
        hits = np.flatnonzero(answers >= 0).tolist()
        return answers, [i for i in hits if not self._meets(rows[i], int(answers[i]))]

    def segments_hit(self, starts: Array, ends: Array, deviations: Array) -> tuple[Integers, list[int]]:
        """For segments (N, n): -1 where all pairs are proven free, a pair whose surfaces meet; and what is undecided."""
        answers, left = self.roots.segments_hit(starts, ends, deviations), []
        for i in np.flatnonzero(answers >= 0).tolist():
            met = self._met(starts[i], ends[i])
            if met is None:
                left.append(i)
            else:
                answers[i] = met
        return answers, left

    def _met(self, start: Array, end: Array) -> int | None:
        """A pair whose surfaces meet somewhere on a segment; None if none is found."""
        for share in np.linspace(0.0, 1.0, WITNESSES).tolist():
            found = self.configuration_hit(start + share * (end - start))
            if found is not None and found >= 0:
                return found
        return None

    def _meets(self, q: Array, pair: int) -> bool:
        return self.touch is not None and self.touch(q, pair)
