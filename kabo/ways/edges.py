"""Edges of a path: tested at some configurations first, which is cheap, then proven free as a whole.

Most edges of a tree are blocked, and a single colliding configuration shows it: so proving all the others costs
little more than sampling them would [docs/decisions/001-kernels.md].
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array, Integers

FreeSegment = Callable[[Array, Array], int]  # -1: proven free; else the number of the pair that is hit
FreeConfigurations = Callable[[Array], Integers]  # (N, n) -> (N,), each as above
Projection = Callable[[Array], Array | None]  # pulls a configuration onto a constraint

CHECK_SPACING = 0.4  # [rad, L2] between configurations that are checked before the proof
MAX_CONSTRAINED_STEP = 0.15  # [rad, L2] the longest edge under a constraint: a longer chord would leave it
STORED_DECIMALS = 9  # of joint values in plans: what is proven is what is stored


@dataclass(frozen=True)
class FreeSpace:
    """The free space of a path search, with a projection onto the constraint on the path, if there is one.

    `hits` counts the edges that were rejected, by the number of the collision pair that was hit.
    """

    free_segment: FreeSegment
    free_configurations: FreeConfigurations | None
    projection: Projection | None = None
    hits: Counter[int] = field(default_factory=Counter)

    def is_free(self, q0: Array, q1: Array) -> bool:
        """Whether the straight edge from q0 to q1 is proven free; q0 is known to be free."""
        hit = self.sampled_hit(q0, q1)
        if hit < 0:
            hit = self.free_segment(q0, q1)
        if hit >= 0:
            self.hits[int(hit)] += 1
        return hit < 0

    def sampled_hit(self, q0: Array, q1: Array) -> int:
        """The first pair hit at sampled configurations of the edge, or -1."""
        if self.free_configurations is None:
            return -1
        for level in dyadic_levels(int(np.ceil(np.linalg.norm(q1 - q0) / CHECK_SPACING))):
            found = self.free_configurations(q0 + level[:, None] * (q1 - q0))
            if np.any(found >= 0):
                return int(found[found >= 0][0])
        return -1

    def extend(self, start: Array, target: Array, reach: float) -> list[Array]:
        """The way points after `start` of a proven path towards the target, at most `reach` [rad] long; possibly none.

        Without a constraint the path is one straight edge. With one it consists of small steps, each projected
        onto the constraint, as long as they come nearer to the target.
        """
        if self.projection is None:
            end = stepped(start, target, reach)
            return [end] if not np.array_equal(end, start) and self.is_free(start, end) else []
        way: list[Array] = []
        here, left = start, reach
        while left > 0.0:
            there = self.projected_step(stepped(here, target, min(MAX_CONSTRAINED_STEP, left)), here, target)
            if there is None or not self.is_free(here, there):
                break
            way.append(there)
            left -= float(np.linalg.norm(there - here))
            here = there
            if np.array_equal(here, target):
                break
        return way

    def projected_step(self, q: Array, here: Array, target: Array) -> Array | None:
        """The projection of q onto the constraint; None if it fails, is too far away, or is no nearer to `target`."""
        if np.array_equal(q, target):
            return q
        found = self.projection(q) if self.projection else q
        if found is None:
            return None
        found = np.round(found, STORED_DECIMALS)
        nearer = np.linalg.norm(target - found) < np.linalg.norm(target - here) - 1e-3
        return found if nearer and np.linalg.norm(found - here) <= 2.0 * MAX_CONSTRAINED_STEP else None


def stepped(start: Array, target: Array, reach: float) -> Array:
    """The target if it lies within `reach` of the start, else the point at that distance towards it, rounded."""
    away = float(np.linalg.norm(target - start))
    if away <= reach:
        return target
    return np.round(start + (reach / away) * (target - start), STORED_DECIMALS)


def dyadic_levels(pieces: int) -> list[Array]:
    """Fractions of a segment in the order of checking: end, middle, quarters …, until they divide it into `pieces`.

    Each level is one array, for one call of the kernel.
    """
    levels, count = [np.ones(1)], 1
    while count < pieces:
        levels.append((np.arange(count) + 0.5) / count)
        count *= 2
    return levels
