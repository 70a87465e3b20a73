"""Pairs of facts that may be true together, as rows of bits [kabo.finite_domain.mutexes does the same in Python].

The array `numbers` refers to every part by the index at which the part begins. A list of facts is its length and
the facts; a list of conditions is its length and, for each condition, a list of facts; a group is its length and
pairs of conditions and facts. An operator is its conditions, its facts, the number of its groups, and the groups,
the first of which has the unconditional facts.
"""

import numpy as np

from kabo.compilation import lean_kernel

FACTS, VARIABLES, OFFSETS, VARIABLE, OPERATORS, FIRST = 0, 1, 2, 3, 4, 5
ONE, ALL = np.uint64(1), np.uint64(0xFFFFFFFFFFFFFFFF)


@lean_kernel  # (W,) u8, i8 -> bool
def _has(bits, f):
    """Whether bit f is set."""
    return bits[f >> 6] >> np.uint64(f & 63) & ONE != 0


@lean_kernel  # (T,) i4, (F, W) u8, i8, (W,) u8, (W,) u8 -> bool
def _with_all(numbers, rows, conditions, known, result):
    """Sets `result` to the known facts that may be true with all conditions; returns whether all conditions can hold."""
    words = result.shape[0]
    at, count = conditions + 1, numbers[conditions]
    if count == 1 and numbers[at] == 1:  # the most frequent case
        f = numbers[at + 1]
        if not _has(known, f):
            return False
        for w in range(words):
            result[w] = known[w] & rows[f, w]
        return _has(result, f)
    for w in range(words):
        result[w] = known[w]
    for _ in range(count):
        size = numbers[at]
        if size == 1:
            f = numbers[at + 1]
            for w in range(words):
                result[w] &= rows[f, w]
        else:
            for w in range(words):
                possible = np.uint64(0)
                for i in range(at + 1, at + 1 + size):
                    possible |= rows[numbers[i], w]
                result[w] &= possible
        at += 1 + size
    return _possible(numbers, conditions, result)


@lean_kernel  # (T,) i4, i8, (W,) u8 -> bool
def _possible(numbers, conditions, known):
    """Whether each condition has a fact among the known ones."""
    at = conditions + 1
    for _ in range(numbers[conditions]):
        found = False
        for i in range(at + 1, at + 1 + numbers[at]):
            if _has(known, numbers[i]):
                found = True
        if not found:
            return False
        at += 1 + numbers[at]
    return True


@lean_kernel  # (T,) i4, i8, (F,) i8, i8 -> bool
def _grew(numbers, conditions, grown, since):
    """Whether the row of some fact of these conditions has grown since then."""
    at = conditions + 1
    for _ in range(numbers[conditions]):
        for i in range(at + 1, at + 1 + numbers[at]):
            if grown[numbers[i]] > since:
                return True
        at += 1 + numbers[at]
    return since < 1


@lean_kernel  # (T,) i4, i8, (W,) u8
def _forget(numbers, made, after):
    """Clears in `after` all facts of the variables that the facts of `made` set."""
    for i in range(made + 1, made + 1 + numbers[made]):
        v = numbers[numbers[VARIABLE] + numbers[i]]
        first, last = numbers[numbers[OFFSETS] + v], numbers[numbers[OFFSETS] + v + 1] - 1
        low, high = ALL << np.uint64(first & 63), ALL >> np.uint64(63 - (last & 63))
        if first >> 6 == last >> 6:
            after[first >> 6] &= ~(low & high)
            continue
        after[first >> 6] &= ~low
        for w in range((first >> 6) + 1, last >> 6):
            after[w] = 0
        after[last >> 6] &= ~high


@lean_kernel  # (T,) i4, i8, (W,) u8
def _put(numbers, made, after):
    """Sets the facts of `made` in `after`."""
    for i in range(made + 1, made + 1 + numbers[made]):
        f = numbers[i]
        after[f >> 6] |= ONE << np.uint64(f & 63)


@lean_kernel  # (T,) i4, i8, (W,) u8, i8, (W,) u8
def _put_others(numbers, o, known, but, after):
    """Sets in `after` the facts that all groups of operator o but one may achieve when only known facts are possible."""
    for g in range(numbers[o + 2]):
        group = numbers[o + 3 + g]
        if g == but:
            continue
        for i in range(group + 1, group + 1 + 2 * numbers[group], 2):
            if _possible(numbers, numbers[i], known):
                _put(numbers, numbers[i + 1], after)


@lean_kernel  # (T,) i4, (F, W) u8, (F,) i8, i8, (W,) u8, (W,) u8, i8 -> i8
def _meet(numbers, rows, grown, made, after, reached, time):
    """Notes that each fact of `made` may be true together with all of `after`; returns the time, later if that was new.

    `reached` are the facts that can be true at all; the last entry of `grown` is the time when one was added last.
    """
    for i in range(made + 1, made + 1 + numbers[made]):
        f = numbers[i]
        for w in range(after.shape[0]):
            new = after[w] & ~rows[f, w]
            if new == 0:
                continue
            grown[f] = time + 1
            rows[f, w] |= new
            g = 64 * w
            while new != 0:
                if new & ONE != 0:
                    rows[g, f >> 6] |= ONE << np.uint64(f & 63)
                    grown[g] = time + 1
                new >>= ONE
                g += 1
        if grown[f] == time + 1:
            time += 1
            if not _has(reached, f):
                reached[f >> 6] |= ONE << np.uint64(f & 63)
                grown[numbers[FACTS]] = time
    return time


@lean_kernel  # (T,) i4, (F, W) u8, (F,) i8, i8, i8, i8, (4, W) u8, i8 -> i8
def _do(numbers, rows, grown, o, group, k, scratch, time):
    """Applies operator o with one group's effect under the conditions at k; scratch[1] are the facts possible before."""
    possible, kept, after = scratch[1], scratch[2], scratch[3]
    if not _with_all(numbers, rows, numbers[k], possible, kept) or not _possible(numbers, numbers[o], kept):
        return time
    for w in range(after.shape[0]):
        after[w] = kept[w]
    _forget(numbers, numbers[o + 1], after)
    _forget(numbers, numbers[k + 1], after)
    _put(numbers, numbers[o + 1], after)
    _put(numbers, numbers[k + 1], after)
    _put_others(numbers, o, kept, group, after)
    return _meet(numbers, rows, grown, numbers[k + 1], after, scratch[0], time)


@lean_kernel  # (T,) i4, i8, (F,) i8, i8 -> bool
def _effects_grew(numbers, o, grown, since):
    """Whether the row of some fact in the operator's effect conditions has grown since then."""
    for g in range(numbers[o + 2]):
        group = numbers[o + 3 + g]
        for k in range(group + 1, group + 1 + 2 * numbers[group], 2):
            if _grew(numbers, numbers[k], grown, since):
                return True
    return False


@lean_kernel  # (T,) i4, (F, W) u8, (F,) i8, (O,) i8, (4, W) u8, i8 -> i8
def grow(numbers, rows, grown, seen, scratch, time):
    """Applies operators until no row grows any more; returns the time, which counts growths.

    scratch[0] has a bit for each fact that can be true at all.
    """
    before = time - 1
    while before != time:
        before = time
        for i in range(numbers[OPERATORS]):
            o, since = numbers[numbers[FIRST] + i], seen[i]
            whole = _grew(numbers, numbers[o], grown, since)
            if numbers[numbers[o]] == 0:
                whole = grown[numbers[FACTS]] > since
            if not whole and not _effects_grew(numbers, o, grown, since):
                continue
            seen[i] = time
            if not _with_all(numbers, rows, numbers[o], scratch[0], scratch[1]):
                continue
            for g in range(numbers[o + 2]):
                group = numbers[o + 3 + g]
                for k in range(group + 1, group + 1 + 2 * numbers[group], 2):
                    if whole or _grew(numbers, numbers[k], grown, since):
                        time = _do(numbers, rows, grown, o, group, k, scratch, time)
    return time
