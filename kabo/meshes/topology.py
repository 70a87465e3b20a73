"""The connectivity of a mesh: which edges its faces share, and which faces are connected through them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kabo.meshes.mesh import Faces

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Edges:
    """The edges of a mesh; side 3f + k leads from corner k of face f to its next corner."""

    ends: Faces  # (E, 2) the lower vertex first
    of_side: Faces  # (3F,) the edge of each side
    forward: Mask  # (3F,) whether a side leads from the lower vertex to the higher
    count: Faces  # (E,) sides on each edge
    balance: Faces  # (E,) forward sides minus backward sides: 0 on a closed surface

    @property
    def border(self) -> Mask:
        """A mask (E,) of the edges that belong to one face only."""
        once: Mask = self.count == 1
        return once

    @property
    def crowded(self) -> Mask:
        """A mask (E,) of the edges that belong to three or more faces."""
        return self.count > 2

    @property
    def turned(self) -> Mask:
        """A mask (E,) of the edges between two faces of opposite orientation."""
        unequal: Mask = (self.count == 2) & (self.balance != 0)
        return unequal


def edges_of(faces: Faces) -> Edges:
    """The edges of faces (F, 3) with three different vertices each."""
    sides = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    forward = sides[:, 0] < sides[:, 1]
    low, high = sides.min(axis=1), sides.max(axis=1)
    size = int(high.max()) + 1 if len(high) else 1
    keys, of_side = np.unique(low * size + high, return_inverse=True)
    of_side = of_side.reshape(-1)
    ends = np.stack([keys // size, keys % size], axis=1)
    balance = np.bincount(of_side, np.where(forward, 1.0, -1.0), len(keys)).astype(np.int64)
    return Edges(ends, of_side, forward, np.bincount(of_side, minlength=len(keys)), balance)


def neighbours(edges: Edges, chosen: Mask) -> tuple[Faces, Faces]:
    """Pairs of consecutive sides that lie on the same edge, for the edges in the mask `chosen` (E,)."""
    order = np.argsort(edges.of_side, kind="stable")
    first, second = order[:-1], order[1:]
    same = (edges.of_side[first] == edges.of_side[second]) & chosen[edges.of_side[first]]
    return first[same], second[same]


def labels(size: int, first: Faces, second: Faces) -> Faces:
    """The component number (size,) of each node of a graph whose links are the pairs of `first` and `second`.

    Components are numbered in the order of their first nodes. Each root hooks onto the lowest one that a link of its tree
    leads to, which at least halves their number, until there are no such links [Shiloach, Vishkin 1982]: to load the
    function of scipy takes ten times as long as to go through all meshes of a robot so.
    """
    root = np.arange(size)
    while True:
        ends = root[first], root[second]
        low, high = np.minimum(*ends), np.maximum(*ends)
        apart = low != high
        if not apart.any():
            break
        np.minimum.at(root, high[apart], low[apart])
        while ((next_root := root[root]) != root).any():
            root = next_root
    return np.cumsum(root == np.arange(size))[root] - 1


def components(edges: Edges, count: int) -> Faces:
    """The number of the component, connected by shared edges, that each of `count` faces belongs to (F,)."""
    first, second = neighbours(edges, np.ones(len(edges.ends), dtype=bool))
    return labels(count, first // 3, second // 3)


def fans(faces: Faces, edges: Edges, first: Faces, second: Faces) -> Faces:
    """The number of the fan of each corner (3F,); a fan is faces around a vertex, connected by the pairs of sides."""
    here = [_corners(first, edges, low) for low in (True, False)]
    there = [_corners(second, edges, low) for low in (True, False)]
    return labels(faces.size, np.concatenate(here), np.concatenate(there))


def _corners(sides: Faces, edges: Edges, low: bool) -> Faces:
    """The corner (3f + k) at the lower or the higher end of each side."""
    starts = edges.forward[sides] == low
    following = 3 * (sides // 3) + (sides + 1) % 3
    return np.where(starts, sides, following)


def fans_around(faces: Faces, fan: Faces) -> Faces:
    """The number of fans (V,) around each vertex, given the fan (3F,) of each corner."""
    vertex = np.zeros(int(fan.max()) + 1 if len(fan) else 0, dtype=np.int64)
    vertex[fan] = faces.reshape(-1)
    return np.bincount(vertex)


def pinched(faces: Faces, edges: Edges) -> int:
    """The number of vertices that belong to several fans of faces, which share no edge there."""
    fan = fans(faces, edges, *neighbours(edges, np.ones(len(edges.ends), dtype=bool)))
    return int((fans_around(faces, fan) > 1).sum())


def repeating(faces: Faces) -> Mask:
    """A mask (F,) of the faces with the same three vertices as an earlier face, in the same cyclic order."""
    again = np.zeros(len(faces), dtype=bool)
    size = int(faces.max()) + 1 if len(faces) else 1
    if size < 1 << 21:  # then three indices fit into one number, which is sorted many times faster
        keys = (faces[:, 0] * size + faces[:, 1]) * size + faces[:, 2]
        if len(np.unique(keys)) == len(faces):
            return again
    _, first = np.unique(faces, axis=0, return_index=True)
    again[:] = True
    again[first] = False
    return again


def holes(edges: Edges) -> int:
    """The number of loops (or chains) that the border edges form."""
    border = edges.ends[edges.border]
    if not len(border):
        return 0
    _, index = np.unique(border, return_inverse=True)
    index = index.reshape(-1, 2)
    return int(labels(int(index.max()) + 1, index[:, 0], index[:, 1]).max()) + 1
