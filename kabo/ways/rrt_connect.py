"""RRT-Connect: two trees of proven edges, grown towards random configurations and towards each other.

[Kuffner, LaValle 2000]; under a constraint each step is projected onto it [Berenson et al. 2009, K 5.2.3].
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.kinematics.sampling import seeds
from kabo.streams import Key, stream_key
from kabo.ways.edges import STORED_DECIMALS, FreeConfigurations, FreeSegment, FreeSpace, Projection

MAX_EXTENSION = 1.0  # [rad, L2] of a tree by one step
RESTART_SAMPLES = 3000  # after so many samples both trees start anew, since run times have a heavy tail


@dataclass(frozen=True)
class NoPath:
    """The result if no path was found within the budget: the hits of each pair, and the number of samples drawn."""

    hits: Counter[int]
    samples: int


class _Tree:
    """Configurations with their parents, the root first; nearest neighbours by linear search, ties to the lowest index."""

    def __init__(self, root: Array) -> None:
        self.nodes = np.empty((64, len(root)))
        self.nodes[0] = root
        self.parents = [-1]

    def add(self, parent: int, way: list[Array]) -> int:
        """Appends a chain of way points to a node; returns the index of the last one."""
        for q in way:
            if len(self.parents) == len(self.nodes):
                self.nodes = np.concatenate([self.nodes, np.empty_like(self.nodes)])
            self.nodes[len(self.parents)] = q
            self.parents.append(parent)
            parent = len(self.parents) - 1
        return parent

    def nearest(self, q: Array) -> int:
        """The index of the node nearest to q."""
        away = self.nodes[: len(self.parents)] - q
        return int(np.argmin(np.einsum("ij,ij->i", away, away)))

    def way_to_root(self, node: int) -> list[Array]:
        """The configurations from a node to the root."""
        way = []
        while node >= 0:
            way.append(self.nodes[node].copy())
            node = self.parents[node]
        return way


def connect(
    start: ArrayLike,
    goal: ArrayLike,
    free_segment: FreeSegment,
    free_configurations: FreeConfigurations,
    lower: ArrayLike,
    upper: ArrayLike,
    key: Key,
    *,
    samples: int,
    projection: Projection | None = None,
    restart: int = RESTART_SAMPLES,
) -> Array | NoPath:
    """Way points (m, n) from start to goal, every segment between them proven free, or `NoPath`.

    The straight segment is tried first. The answer depends on the arguments only.

    Args:
        start, goal: configurations (n,) within the limits, which fulfil the constraint if there is one.
        free_segment: returns -1 if a straight segment is proven free and within the constraint, else the index of a
            pair that is hit.
        free_configurations: returns -1 or the index of a hit pair for each configuration (N, n); cheaper than a proof
            and called first.
        lower, upper: (n,) finite bounds of the samples.
        key: the key of the random numbers.
        samples: the greatest total number of samples.
        projection: moves a configuration onto the constraint that the path keeps; None if there is no constraint.
        restart: the number of samples after which new trees are started.

    Raises:
        ValueError: shapes do not fit, or a bound is not finite.
    """
    ends = np.array([start, goal], np.float64)
    low, high = np.array(lower, np.float64), np.array(upper, np.float64)
    if not low.shape == high.shape == ends[0].shape or not np.all(np.isfinite([*ends, low, high])):
        raise ValueError("start, goal and limits must be finite and of one shape")
    space = FreeSpace(free_segment, free_configurations, projection)
    for found in free_configurations(ends):
        if found >= 0:
            return NoPath(Counter({int(found): 1}), 0)
    if space.is_free(ends[0], ends[1]):
        return ends
    spent = 0
    while spent < samples:
        budget = min(restart, samples - spent)
        way, used = _grow(ends, space, low, high, stream_key(int(key), "trees", spent), budget)
        spent += used
        if way is not None:
            return np.array(way)
    return NoPath(space.hits, spent)


def _grow(
    ends: Array, space: FreeSpace, low: Array, high: Array, key: Key, budget: int
) -> tuple[list[Array] | None, int]:
    """The way points of a path, or None, and the number of samples drawn."""
    trees = _Tree(ends[0]), _Tree(ends[1])
    drawn = np.round(seeds(low, high, key, 0, budget), STORED_DECIMALS)
    for number in range(budget):
        first, second = (trees[0], trees[1]) if number % 2 == 0 else (trees[1], trees[0])
        near = first.nearest(drawn[number])
        way = space.extend(first.nodes[near], drawn[number], MAX_EXTENSION)
        if not way:
            continue
        node = first.add(near, way)
        met = _reach(second, space, way[-1])
        if met is not None:
            halves = (node, met) if first is trees[0] else (met, node)
            from_start = trees[0].way_to_root(halves[0])[::-1]
            return from_start + trees[1].way_to_root(halves[1])[1:], number + 1
    return None, budget


def _reach(tree: _Tree, space: FreeSpace, target: Array) -> int | None:
    """Grows a tree towards a configuration; returns the node that reached it, or None if an edge was blocked."""
    node = tree.nearest(target)
    while not np.array_equal(tree.nodes[node], target):
        way = space.extend(tree.nodes[node], target, MAX_EXTENSION)
        if not way:
            return None
        node = tree.add(node, way)
    return node
