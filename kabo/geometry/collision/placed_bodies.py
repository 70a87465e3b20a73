"""Bodies as arrays in the frames of their joints: the same for all views that ask about other pairs of them."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.boxes import place_groups
from kabo.geometry.collision.kernels.bundles import (
    AXIS,
    CHILD_COUNT,
    EXTENT_COLUMNS,
    FIRST_CHILD,
    PARTS,
    ROOTS_END,
    Extents,
    Hulls,
)
from kabo.geometry.collision.part_trees import children_within, is_flat
from kabo.geometry.parts import Enclosure, FixedGroup, MovingGroup, Packed, poses_of, stacked

MAX_PLACED = 8  # lists of bodies at their places: contacts are permitted and forbidden while nothing moves
MAX_STACKED = 32  # lists of enclosures whose stacked parts are kept: situations of a scene have the same bodies


class Placed(NamedTuple):
    """Bodies in the frames of their joints, whatever pairs of them are asked about."""

    parts: Integers  # (2, G + 1) rows PARTS and ROOTS_END of `Bodies.groups`
    packed: Packed
    extents: Extents
    cores: Array  # (B, 9)
    children: Integers  # (B, 2)
    radii: Array  # (G, 2)
    far: Array  # (G,) how far parts that are not roots may be outside them; that does not depend on which are known [m]
    room: Array  # (G,) what of the budget's share parts that are not known may need [m]
    kept: Array  # (2, G)


@lru_cache(maxsize=MAX_PLACED)
def placed_bodies(
    given: tuple[MovingGroup | FixedGroup, ...], enclosures: tuple[Enclosure, ...], geometry: float
) -> Placed:
    """Bodies with the enclosures that are known of them, in the frames of their joints."""
    source, own_cores = _stacked(enclosures)
    count, parts = len(enclosures), len(source.sizes)
    groups = np.zeros((4, count + 1), np.int64)
    np.cumsum([len(enclosure.parts) for enclosure in enclosures], out=groups[PARTS, 1:])
    groups[ROOTS_END, :-1] = groups[PARTS, :-1] + [len(enclosure.root_parts) for enclosure in enclosures]
    hulls = Hulls(np.empty(source.blocks.shape), np.empty(parts, np.int64), np.zeros((parts, 5)))
    extents = Extents(np.zeros((parts, EXTENT_COLUMNS)), np.zeros((count, EXTENT_COLUMNS)))
    poses, radii = poses_of(given), np.empty((count, 2))
    place_groups(Hulls(source.blocks, source.sizes, source.rounds), groups, poses, hulls, extents, radii)
    trees = [not is_flat(enclosure, geometry) for enclosure in enclosures]
    children = np.concatenate([np.empty((0, 2), np.int64), *(children_within(e, geometry) for e in enclosures)])
    owner = np.repeat(np.arange(count), np.diff(groups[PARTS]))
    children[:, FIRST_CHILD] += np.where(children[:, CHILD_COUNT] > 0, groups[PARTS, owner], 0)
    return Placed(
        groups[[PARTS, ROOTS_END]],
        Packed(hulls.blocks, hulls.sizes, source.diameters, hulls.rounds),
        extents,
        _placed_cores(own_cores, poses[owner]),
        children,
        radii,
        np.array(
            [e.deviation_of_roots if tree else 0.0 for e, tree in zip(enclosures, trees, strict=True)], np.float64
        ),
        np.where(trees, geometry, 0.0),
        np.array([[g.kept for g in given], [g.hand for g in given]], np.float64),
    )


@lru_cache(maxsize=MAX_STACKED)
def _stacked(enclosures: tuple[Enclosure, ...]) -> tuple[Packed, Array]:
    """The parts of several enclosures in their own frames, and their cores."""
    source = stacked([enclosure.packed for enclosure in enclosures])
    return source, cores_of(Hulls(source.blocks, source.sizes, source.rounds))


def _placed_cores(cores: Array, poses: Array) -> Array:
    """The cores (B, 9) of parts at poses (B, 12): means are moved, spreads are turned."""
    rotations = poses[:, :9].reshape(-1, 3, 3)
    means = (rotations @ cores[:, :3, None])[..., 0] + poses[:, 9:]
    spreads = rotations @ cores[:, [[3, 4, 5], [4, 6, 7], [5, 7, 8]]] @ rotations.transpose(0, 2, 1)
    return np.column_stack([means, spreads[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]])


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
