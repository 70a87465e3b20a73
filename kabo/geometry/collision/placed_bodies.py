"""Bodies as arrays in their own frames, and as they are written into the frames of their joints."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.boxes import place_cores, place_groups
from kabo.geometry.collision.kernels.bundles import (
    AXIS,
    PARTS,
    ROOTS_END,
    Extents,
    Hulls,
)
from kabo.geometry.parts import Enclosure, Packed, stacked

MAX_STACKED = 32  # lists of enclosures whose stacked parts are kept: situations of a scene have the same bodies


class Sources(NamedTuple):
    """Bodies in their own frames, wherever they are."""

    groups: Integers  # (4, G + 1) rows PARTS and ROOTS_END of `Bodies.groups`
    owner: Integers  # (B,) the group of each part
    packed: Packed
    cores: Array  # (B, 9)


@lru_cache(maxsize=MAX_STACKED)
def sources_of(enclosures: tuple[Enclosure, ...]) -> Sources:
    """The parts of several enclosures in their own frames, and their cores."""
    source = stacked([enclosure.packed for enclosure in enclosures])
    groups = part_ranges(enclosures)
    owner = np.repeat(np.arange(len(enclosures)), np.diff(groups[PARTS]))
    return Sources(groups, owner, source, cores_of(Hulls(source.blocks, source.sizes, source.rounds)))


def part_ranges(enclosures: tuple[Enclosure, ...]) -> Integers:
    """The rows PARTS and ROOTS_END of `Bodies.groups` (4, G + 1), with zeros in the others."""
    groups = np.zeros((4, len(enclosures) + 1), np.int64)
    np.cumsum([len(enclosure.parts) for enclosure in enclosures], out=groups[PARTS, 1:])
    groups[ROOTS_END, :-1] = groups[PARTS, :-1] + [len(enclosure.root_parts) for enclosure in enclosures]
    return groups


def place(
    source: Sources, poses: Array, first: int, end: int, hulls: Hulls, extents: Extents, radii: Array, cores: Array
) -> None:
    """Writes the groups from `first` to `end` - 1, at their poses (G, 12): parts, boxes, radii (G, 2), cores (B, 9)."""
    packed, some = source.packed, slice(first, end)
    groups = np.ascontiguousarray(source.groups[:, first : end + 1])
    own = Extents(extents.parts, extents.groups[some])
    place_groups(Hulls(packed.blocks, packed.sizes, packed.rounds), groups, poses[some], hulls, own, radii[some])
    place_cores(source.cores, source.owner, poses, int(groups[PARTS, 0]), int(groups[PARTS, -1]), cores)


def cores_of(hulls: Hulls) -> Array:
    """`Outlines.cores`: the mean of each part's corners, and their mean square about it, with ball and disc added."""
    blocks, (radius, disc, *_), normal = hulls.blocks, hulls.rounds.T, hulls.rounds[:, AXIS:]
    used = np.arange(blocks.shape[2]) < hulls.sizes[:, None]
    blocks = np.where(used[:, None], blocks, blocks[:, :, :1])
    weights = (blocks != blocks[:, :, :1]).any(axis=1).astype(np.float64)  # other columns repeat the first corner
    weights[:, 0] = 1.0
    weights /= weights.sum(axis=1, keepdims=True)
    mean = np.einsum("bk,brk->br", weights, blocks)
    about = blocks - mean[:, :, None]
    spread = np.einsum("bk,brk,bsk->brs", weights, about, about)
    spread += (radius**2 + disc**2)[:, None, None] * np.eye(3)
    spread -= (disc**2)[:, None, None] * normal[:, :, None] * normal[:, None, :]
    spread += 1e-3 * np.trace(spread, axis1=1, axis2=2)[:, None, None] * np.eye(3)  # flat parts
    return np.column_stack([mean, spread[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]])
