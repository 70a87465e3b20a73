"""Applicable operators and successors of packed states; plain_states.py computes the same in plain Python.

`numbers` and `bits` are the tables of a task [kabo.finite_domain.array_tables]. States are rows of words.
"""

import numpy as np

from kabo.compilation import lean_kernel

# At the head of a task's numbers.
WORDS, OPERATORS, GROUPS, GOAL, GOAL_FIRST, GOAL_END, EFFECTS, GATE_OF, LOWEST_BIT = 0, 1, 2, 3, 4, 5, 6, 7, 8
LOWEST = np.uint64(0x03F79D71B4CB0A89)
FIRST_FACTOR, SECOND_FACTOR = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xD6E8FEB86659FD93)


@lean_kernel  # (T,) i4, (S, W) u8, i8, i8 -> i8
def content(numbers, states, row, at):
    """The value of a state's bits given by a word, shift and mask, which `numbers` has from index `at` on."""
    return np.int64(states[row, numbers[at]] >> np.uint64(numbers[at + 1])) & numbers[at + 2]


@lean_kernel  # (T,) i4, (S, W) u8, i8, i8, i8 -> bool
def passes(numbers, states, row, first, end):
    """Whether the state passes the tests that `numbers` has from index `first` up to, not including, `end`."""
    passing, at = True, first
    while passing and at < end:
        passing = numbers[numbers[at + 3] + content(numbers, states, row, at)] != 0
        at += 4
    return passing


@lean_kernel  # (T,) i4, (B,) u8, (S, W) u8, i8, (G,) u8, (O,) i4 -> i8
def applicable(numbers, bits, states, row, never, out):
    """Fills `out` with the applicable operators in the order of the task; returns how many there are.

    `never` has a bit for each operator that must not be used, 64 in a word.
    """
    count = 0
    gate_of, lowest_bit = numbers[GATE_OF], numbers[LOWEST_BIT]
    end = numbers[gate_of]
    for g in range(never.shape[0]):
        able = ~never[g]
        first, end = end, numbers[gate_of + g + 1]
        for at in range(first, end, 4):
            able &= bits[numbers[at + 3] + content(numbers, states, row, at)]
            if able == 0:
                break
        while able != 0:
            lowest = able & (~able + np.uint64(1))
            out[count] = 64 * g + numbers[lowest_bit + np.int64(lowest * LOWEST >> np.uint64(58))]
            count += 1
            able ^= lowest
    return count


@lean_kernel  # (B,) u8, i8, (R, W) u8, i8
def put(bits, at, results, r):
    """Clears bits of the state results[r], and then sets bits.

    From index `at` on, `bits` has the words of the bits to clear, and then those of the bits to set.
    """
    words = results.shape[1]
    if words == 1:  # loops are made for many words, and cost much for one
        results[r, 0] = (results[r, 0] & ~bits[at]) | bits[at + 1]
        return
    for w in range(words):
        results[r, w] = (results[r, w] & ~bits[at + w]) | bits[at + words + w]


@lean_kernel  # (T,) i4, (B,) u8, (S, W) u8, i8, i8, (R, W) u8, i8
def apply(numbers, bits, states, row, o, results, r):
    """Writes into results[r] the state after operator o, which must be applicable in states[row]."""
    words = states.shape[1]
    results[r, 0] = states[row, 0]
    for w in range(1, words):
        results[r, w] = states[row, w]
    put(bits, 2 * words * np.int64(o), results, r)
    effects = numbers[EFFECTS] + 4 * np.int64(o)
    for s in range(numbers[effects], numbers[effects + 1], 4):
        at = numbers[numbers[s + 3] + content(numbers, states, row, s)]
        if at >= 0:
            put(bits, at, results, r)
    for g in range(numbers[effects + 2], numbers[effects + 3], 3):
        if passes(numbers, states, row, numbers[g + 1], numbers[g + 2]):
            put(bits, numbers[g], results, r)


@lean_kernel  # (T,) i4, (B,) u8, (S, W) u8, i8 -> bool
def at_goal(numbers, bits, states, row):
    """Whether the state fulfils the goal."""
    words, goal = states.shape[1], numbers[GOAL]
    if states[row, 0] & bits[goal] != bits[goal + words]:
        return False
    for w in range(1, words):
        if states[row, w] & bits[goal + w] != bits[goal + words + w]:
            return False
    return passes(numbers, states, row, numbers[GOAL_FIRST], numbers[GOAL_END])


@lean_kernel  # (S, W) u8, i8 -> u8
def hashed(states, row):
    """A hash of the state; its high bits are distributed most evenly."""
    mixed = states[row, 0] * FIRST_FACTOR
    mixed ^= mixed >> np.uint64(32)
    for w in range(1, states.shape[1]):
        mixed = (mixed + states[row, w]) * SECOND_FACTOR
        mixed ^= mixed >> np.uint64(29)
    return mixed * SECOND_FACTOR
