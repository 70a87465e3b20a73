"""The layout of the arrays of a configuration check in one flat array, its memory.

Each array argument of a kernel costs 40 ns a call, and 1 us if its header is not in the cache; so `memory_of`
(kabo.geometry.collision.view_arrays) puts all of them into one array, integers first, and kernels take views of
it.
"""

import numpy as np

from kabo.compilation import leaf_kernel, lean_kernel, window
from kabo.geometry.collision.kernels.bundles import CORE_COLUMNS, COUNTER_PLACES, EXTENT_COLUMNS

# Places of whole numbers in the head: how many there are of what, and where numbers and blocks begin.
JOINTS, VALUES, MOVING, GROUPS, PARTS, PAIRS, LARGEST, NUMBERS, BLOCKS, ROOM, COLUMNS = range(11)
MARGIN, OFFSET = 11, 12  # places of numbers in the head
HEAD_PLACES = 16  # before the first array
CACHE_LINE_PLACES = 8  # arrays begin at multiples of it
GROUPS_PER_WORD = 32  # one integer holds a bit for each of so many groups


@lean_kernel  # i8, i8 -> i8
def after(start, count):
    """The index where the next array begins: the end of `count` elements from `start`, rounded up to a cache line."""
    return (start + count + CACHE_LINE_PLACES - 1) & -CACHE_LINE_PLACES


@lean_kernel  # i8, i8 -> i8
def words_for(groups):
    """The number of integers in a bit mask that has a bit for each of `groups` groups."""
    return (groups + GROUPS_PER_WORD - 1) // GROUPS_PER_WORD


@leaf_kernel
def numbers_of(memory):
    """The floating-point arrays in a memory: of `Chain`, `Outlines`, `Tree`, `Search` and `Hulls`, and what a check writes.

    factors (2, J), placement (J, 12), bound (n,), extents of parts (B, 8) and groups (G, 8), the latter flat too, cores
    (B, 9), diameters (B,), local (J * 24,), world_T (J, 12), frames (J * 12,), angles (3, J), rows (6, 32 W) f4 world
    boxes of groups, kept (2, G) of `Tracks`, pose (12,), axis (3,), simplex (4, 3),
    points (4, 3), rounds (B + room, 5), blocks (B + room, 3, K) of vertices: of all parts in their joint's frame, then
    those that sweeps place.
    """
    whole = memory.view(np.int64)
    joints, columns = whole[JOINTS], GROUPS_PER_WORD * words_for(whole[GROUPS])
    start, rows_of_hulls = whole[NUMBERS], whole[PARTS] + whole[ROOM]
    factors, start = window(memory, start, (2, joints)), after(start, 2 * joints)
    placement, start = window(memory, start, (joints, 12)), after(start, 12 * joints)
    bound, start = window(memory, start, (whole[VALUES],)), after(start, whole[VALUES])
    part_extents, start = (
        window(memory, start, (whole[PARTS], EXTENT_COLUMNS)),
        after(start, EXTENT_COLUMNS * whole[PARTS]),
    )
    boxes = window(memory, start, (EXTENT_COLUMNS * whole[GROUPS],))
    group_extents, start = (
        window(memory, start, (whole[GROUPS], EXTENT_COLUMNS)),
        after(start, EXTENT_COLUMNS * whole[GROUPS]),
    )
    cores, start = (
        window(memory, start, (whole[PARTS], CORE_COLUMNS)),
        after(start, CORE_COLUMNS * whole[PARTS]),
    )
    diameters, start = window(memory, start, (whole[PARTS],)), after(start, whole[PARTS])
    local, start = window(memory, start, (24 * joints,)), after(start, 24 * joints)
    world_T, start = window(memory, start, (joints, 12)), after(start, 12 * joints)
    frames, start = window(memory, start, (12 * joints,)), after(start, 12 * joints)
    angles, start = window(memory, start, (3, joints)), after(start, 3 * joints)
    rows, start = window(memory.view(np.float32), 2 * start, (6, columns)), after(start, 3 * columns)
    kept, start = window(memory, start, (2, whole[GROUPS])), after(start, 2 * whole[GROUPS])
    pose, start = window(memory, start, (12,)), after(start, 12)
    axis, start = window(memory, start, (3,)), after(start, 3)
    simplex, start = window(memory, start, (4, 3)), after(start, 12)
    points, start = window(memory, start, (4, 3)), after(start, 12)
    rounds = window(memory, start, (rows_of_hulls, 5))
    blocks = window(memory, whole[BLOCKS], (rows_of_hulls, 3, whole[COLUMNS]))
    return (
        factors, placement, bound, part_extents, group_extents, boxes, cores, diameters, local, world_T, frames, angles,
        rows, kept, pose, axis, simplex, points, rounds, blocks,
    )  # fmt: skip


@leaf_kernel
def whole_numbers_of(memory):
    """The integer arrays in a memory.

    counters (8,), joints (3, J), groups (4, G+1), sizes (B + room,), children (B, 2), stack (B + 1, 2), pairs (2, P),
    allowed (moving, W), and listed (greatest number of roots,).
    """
    whole = memory.view(np.int64)
    joints, groups, words = whole[JOINTS], whole[GROUPS] + 1, words_for(whole[GROUPS])
    rows_of_hulls = whole[PARTS] + whole[ROOM]
    counters, start = window(whole, HEAD_PLACES, (COUNTER_PLACES,)), after(HEAD_PLACES, COUNTER_PLACES)
    tree, start = window(whole, start, (3, joints)), after(start, 3 * joints)
    ranges, start = window(whole, start, (4, groups)), after(start, 4 * groups)
    sizes, start = window(whole, start, (rows_of_hulls,)), after(start, rows_of_hulls)
    children, start = window(whole, start, (whole[PARTS], 2)), after(start, 2 * whole[PARTS])
    stack, start = window(whole, start, (whole[PARTS] + 1, 2)), after(start, 2 * whole[PARTS] + 2)
    pairs, start = window(whole, start, (2, whole[PAIRS])), after(start, 2 * whole[PAIRS])
    allowed, start = window(whole, start, (whole[MOVING], words)), after(start, whole[MOVING] * words)
    listed = window(whole, start, (whole[LARGEST],))
    return counters, tree, ranges, sizes, children, stack, pairs, allowed, listed
