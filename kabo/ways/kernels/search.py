"""The search for a way in one call: the straight edge, two trees, shortcuts.

RRT-Connect [Kuffner, LaValle 2000]: two trees grow towards random configurations and towards each other; under a
constraint each step is projected onto it [Berenson et al. 2009, K 5.2.3]. The smaller tree gets the sample.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.kinematics.kernels.streams import mixed, uniform
from kabo.ways.kernels.bundles import (
    ANSWERED,
    ASK,
    ATTEMPT,
    BLOCKED,
    COUNTS,
    CUT,
    FOUND,
    GROW,
    OVER,
    PATH,
    PAUSE,
    PHASE,
    RECENT,
    RESTARTS,
    SAMPLE,
    SETTLE,
    SHORTEN,
    SPENT,
    STRAIGHT,
    USED,
)
from kabo.ways.kernels.bundles import VAIN as IN_VAIN
from kabo.ways.kernels.edges import edge_hit, rounded
from kabo.ways.kernels.shortening import VAIN, cut, measure, save, settle, shorten
from kabo.ways.kernels.trees import extend, nearest, reach

NOT_MET, MET = 0, 1


@lean_kernel  # u8, i8 -> u8
def of_restart(key, number):
    """The key of the samples after so many restarts."""
    return mixed(np.uint64(key) + np.uint64(number + 1) * np.uint64(0xD1B54A32D192ED03))


@lean_kernel  # Effort, Space, Grown, Journal -> i8
def _straight(effort, space, grown, journal):
    """FOUND with the straight path, NOT_MET, or OVER if an end is not free; or an interrupt."""
    ends = grown.nodes[0, 0], grown.nodes[1, 0]
    for q in ends:
        hit = edge_hit(q, q, effort.spacing, False, space, journal)
        if hit != FREE:
            return OVER if hit >= 0 else hit
    hit = edge_hit(ends[0], ends[1], effort.spacing, True, space, journal)
    if hit != FREE:
        return NOT_MET if hit >= 0 else hit
    for k in range(ends[0].shape[0]):
        grown.path[0, 0, k], grown.path[0, 1, k] = ends[0][k], ends[1][k]
    grown.flags[0, 0] = grown.flags[0, 1] = 1
    journal.state[PATH] = 2
    return FOUND


@lean_kernel  # (n,) f8 x 2, u8, i8, Effort, Grown, Journal -> writes points[2]
def _draw(low, high, key, tree, effort, grown, journal):
    """Draws a sample: mostly near a node of the tree, which leads out of pockets, now and then between the bounds."""
    state, drawn = journal.state, journal.points[2]
    n, number = drawn.shape[0], state[SAMPLE]
    local = number % effort.wide > 0
    node = int(uniform(key, number, n) * state[COUNTS + tree])
    for k in range(n):
        share = uniform(key, number, k)
        if not low[k] < high[k]:
            drawn[k] = low[k]
        elif local:
            aside = effort.near * (share + uniform(key, number, n + 1 + k) - 1.0)
            drawn[k] = rounded(min(max(grown.nodes[tree, node, k] + aside, low[k]), high[k]))
        else:
            drawn[k] = rounded(low[k] + share * (high[k] - low[k]))


@lean_kernel  # (n,) f8 x 2, u8, Effort, Space, Grown, Journal -> i8
def _sample(low, high, key, effort, space, grown, journal):
    """Grows both trees by one sample: MET with the path, NOT_MET, or an interrupt."""
    state, drawn = journal.state, journal.points[2]
    # The smaller tree is where it is narrow: it needs the samples.
    first = 0 if state[COUNTS] <= state[COUNTS + 1] else 1
    second = 1 - first
    _draw(low, high, key, first, effort, grown, journal)
    near = nearest(first, drawn, grown, journal)
    node = extend(first, near, drawn, effort.extension, effort, space, grown, journal)
    if node == near or node < 0:
        return NOT_MET if node == near else node
    met, arrived = reach(second, grown.nodes[first, node], effort, space, grown, journal)
    if met < 0 or not arrived:
        return met if met < 0 else NOT_MET
    _join(node if first == 0 else met, met if first == 0 else node, grown, journal)
    return MET


@lean_kernel  # i8, i8, Grown, Journal
def _join(first, second, grown, journal):
    """Writes the path from the root of tree 0 by a node of it, which is a node of tree 1 too, to the root of tree 1."""
    count, node = 0, first
    while node >= 0:
        count, node = count + 1, grown.parents[0, node]
    journal.state[PATH] = count
    node = first
    while node >= 0:
        count -= 1
        for k in range(grown.nodes.shape[2]):
            grown.path[0, count, k] = grown.nodes[0, node, k]
        node = grown.parents[0, node]
    node = grown.parents[1, second]
    while node >= 0:
        for k in range(grown.nodes.shape[2]):
            grown.path[0, journal.state[PATH], k] = grown.nodes[1, node, k]
        journal.state[PATH] += 1
        node = grown.parents[1, node]
    for i in range(journal.state[PATH]):
        grown.flags[0, i] = 1


@lean_kernel  # (n,) f8 x 2, u8, Effort, Space, Grown, Journal -> i8
def _next(low, high, key, effort, space, grown, journal):
    """One step of the phase that the search is in; its outcome, or an interrupt; moves on to the next phase."""
    state = journal.state
    if state[PHASE] == STRAIGHT:
        found = _straight(effort, space, grown, journal)
        if found >= 0:
            state[PHASE] = CUT if found == FOUND else OVER if found == OVER else GROW
            if found == FOUND:
                save(grown, journal)
        return found
    if state[PHASE] == GROW:
        if state[SPENT] >= effort.samples:
            state[PHASE] = OVER
            return NOT_MET
        found = _sample(low, high, of_restart(key, state[RESTARTS]), effort, space, grown, journal)
        if found >= 0:
            state[SAMPLE] += 1
            state[SPENT] += 1
            if found == MET:
                state[PHASE] = CUT
                save(grown, journal)
            elif state[SAMPLE] == effort.restart:
                state[SAMPLE] = 0
                state[RESTARTS] += 1
                state[COUNTS] = state[COUNTS + 1] = 1
        return found
    if state[PHASE] == CUT:
        found = cut(effort, space, grown, journal)
        if found == OVER:
            state[PHASE] = SHORTEN
        return found
    if state[PHASE] == SHORTEN:
        if state[PATH] < 3 or state[ATTEMPT] >= effort.attempts or state[IN_VAIN] >= effort.patience:
            state[PHASE] = SETTLE
            return FREE
        found = shorten(key, effort, space, grown, journal)
        if found >= 0:
            state[ATTEMPT] += 1
            state[IN_VAIN] = state[IN_VAIN] + 1 if found == VAIN else 0
        return found
    found = settle(space, grown, journal)
    if found == FREE:
        state[PHASE] = OVER
        measure(grown, journal)
    return found


@lean_kernel  # (n,) f8 x 2, u8, Effort, Space, Grown, Journal -> i8
def run(low, high, key, effort, space, grown, journal):
    """Searches on from where the journal is: FOUND, BLOCKED, or ASK, FULL, PAUSE.

    The ends are node 0 of either tree.
    """
    state = journal.state
    for _ in range(effort.batch):
        if state[PHASE] == OVER:
            return FOUND if state[PATH] > 0 else BLOCKED
        state[USED] = state[RECENT] = 0
        before = state[COUNTS], state[COUNTS + 1]
        found = _next(low, high, key, effort, space, grown, journal)
        if found <= ASK:
            state[COUNTS], state[COUNTS + 1] = before
            for i in range(state[RECENT]):
                journal.hits[journal.recent[i]] -= 1
            return found
        state[ANSWERED] = 0
    return PAUSE
