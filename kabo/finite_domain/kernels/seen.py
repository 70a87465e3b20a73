"""The set of states seen so far: a hash table with open addressing, about one access to main memory per look-up.

A state of one word may be stored in the table itself; otherwise the table stores half of the state's hash and the
index of its row. The place of a state is given by the first bits of its hash, so enlarging a table in order also
fills the new table in order.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.finite_domain.kernels.successors import hashed

EMPTY = np.uint64(0xFFFFFFFFFFFFFFFF)
ROW = np.uint64(0xFFFFFFFF)


@lean_kernel  # u8, i8 -> i8
def place(mixed, size):
    """The place of a state with the hash `mixed` in a table of `size` places; `size` must be a power of two."""
    return np.int64((mixed >> np.uint64(32)) * np.uint64(size) >> np.uint64(32))


@lean_kernel  # (P,) u8, (S, W) u8, (R, W) u8, i8, u8, i8 -> i8
def find_row(table, states, candidates, r, mixed, new):
    """The row of candidate r among the states; -1 if it is new, and the table then records it as row `new`."""
    last, i, tag = table.shape[0] - 1, place(mixed, table.shape[0]), mixed & ROW
    while table[i] != EMPTY:
        if table[i] >> np.uint64(32) == tag:
            row = np.int64(table[i] & ROW)
            w = 0
            while w < states.shape[1] and states[row, w] == candidates[r, w]:
                w += 1
            if w == states.shape[1]:
                return row
        i = (i + 1) & last
    table[i] = tag << np.uint64(32) | np.uint64(new)
    return -1


@lean_kernel  # (P,) u8, (S, W) u8, (R, W) u8, i8, u8, i8 -> i8
def find(table, states, candidates, r, mixed, new):
    """The row of candidate r among the states; -1 if it is new, and the table then records it.

    States of one word are stored in the table itself, without their rows: for known ones the result is 0.
    """
    if states.shape[1] > 1:
        return find_row(table, states, candidates, r, mixed, new)
    last, i, word = table.shape[0] - 1, place(mixed, table.shape[0]), candidates[r, 0]
    while table[i] != EMPTY:
        if table[i] == word:
            return 0
        i = (i + 1) & last
    table[i] = word
    return -1


@lean_kernel  # (P,) u8, (Q,) u8, (S, W) u8, (1, W) u8, bool
def move_table(old, larger, states, one, by_row):
    """Enters all states of the table `old` into a larger, empty one.

    `by_row` says that the old table was filled by `find_row`, so that it holds rows even for states of one word.
    """
    last = larger.shape[0] - 1
    for j in range(old.shape[0]):
        if old[j] != EMPTY:
            if states.shape[1] == 1 and not by_row:
                one[0, 0] = old[j]
                mixed = hashed(one, 0)
            else:
                mixed = hashed(states, np.int64(old[j] & ROW))
            i = place(mixed, larger.shape[0])
            while larger[i] != EMPTY:
                i = (i + 1) & last
            larger[i] = old[j]
