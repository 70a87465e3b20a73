"""The search for a way in one call: the straight edge, two trees, shortcuts.

RRT-Connect [Kuffner, LaValle 2000]: two trees grow towards random configurations and towards each other; under a
constraint each step is projected onto it [Berenson et al. 2009, K 5.2.3]. Edges of trees are looked at; those of a path
from tree to tree are proven when it is found, and what hangs on one that is not free is cut off.
"""

from kabo.compilation import kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.kinematics.kernels.streams import uniform
from kabo.ways.kernels.bundles import (
    ANSWERED,
    ASK,
    ATTEMPT,
    BLOCKED,
    COUNTS,
    FAILED,
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
from kabo.ways.kernels.edges import edge_hit, note, rounded
from kabo.ways.kernels.shortening import VAIN, measure, save, settle, shorten
from kabo.ways.kernels.trees import cut, extend, nearest, prove_branch, reach

NOT_MET = 0
MET = 1


@kernel  # Effort, Space, Grown, Journal -> i8
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


@kernel  # (n,) f8 x 2, u8, Effort, Space, Grown, Journal -> i8
def _sample(low, high, key, effort, space, grown, journal):
    """Grows both trees by one sample: MET with the path, NOT_MET, or an interrupt."""
    state, drawn = journal.state, journal.points[2]
    for k in range(drawn.shape[0]):
        drawn[k] = rounded(low[k] + uniform(key, state[SAMPLE], k) * (high[k] - low[k]))
    first, proves = state[SAMPLE] & 1, state[FAILED] >= effort.trusted
    second = 1 - first
    near = nearest(grown.nodes[first], state[COUNTS + first], drawn)
    node = extend(first, near, drawn, effort.extension, effort, proves, space, grown, journal)
    if node == near or node < 0:
        return NOT_MET if node == near else node
    met, arrived = reach(second, grown.nodes[first, node], effort, proves, space, grown, journal)
    if met < 0 or not arrived:
        return met if met < 0 else NOT_MET
    for tree, end in ((first, node), (second, met)):
        hit, broken = prove_branch(tree, end, space, grown, journal)
        if hit < FREE:
            return hit
        if hit != FREE:
            note(hit, journal)
            state[FAILED] += 1
            cut(tree, broken, grown, journal)
            return NOT_MET
    _join(node if first == 0 else met, met if first == 0 else node, grown, journal)
    return MET


@kernel  # i8, i8, Grown, Journal
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


@kernel  # (n,) f8 x 2, (T,) u8, Effort, Space, Grown, Journal -> i8
def _next(low, high, keys, effort, space, grown, journal):
    """One step of the phase that the search is in; its outcome, or an interrupt; moves on to the next phase."""
    state = journal.state
    if state[PHASE] == STRAIGHT:
        found = _straight(effort, space, grown, journal)
        if found >= 0:
            state[PHASE] = SHORTEN if found == FOUND else OVER if found == OVER else GROW
            if found == FOUND:
                save(grown, journal)
        return found
    if state[PHASE] == GROW:
        if state[SPENT] >= effort.samples:
            state[PHASE] = OVER
            return NOT_MET
        found = _sample(low, high, keys[state[RESTARTS]], effort, space, grown, journal)
        if found >= 0:
            state[SAMPLE] += 1
            state[SPENT] += 1
            if found == MET:
                state[PHASE] = SHORTEN
                save(grown, journal)
            elif state[SAMPLE] == effort.restart:
                state[SAMPLE] = 0
                state[RESTARTS] += 1
                state[COUNTS] = state[COUNTS + 1] = 1
                state[FAILED] = 0
        return found
    if state[PHASE] == SHORTEN:
        if state[PATH] < 3 or state[ATTEMPT] >= effort.attempts or state[IN_VAIN] >= effort.patience:
            state[PHASE] = SETTLE
            return FREE
        found = shorten(keys[keys.shape[0] - 1], effort, space, grown, journal)
        if found >= 0:
            state[ATTEMPT] += 1
            state[IN_VAIN] = state[IN_VAIN] + 1 if found == VAIN else 0
        return found
    found = settle(space, grown, journal)
    if found == FREE:
        state[PHASE] = OVER
        measure(grown, journal)
    return found


@kernel  # (n,) f8 x 2, (T + 1,) u8, Effort, Space, Grown, Journal -> i8
def run(low, high, keys, effort, space, grown, journal):
    """Searches on from where the journal is: FOUND, BLOCKED, or ASK, FULL, PAUSE.

    The ends are node 0 of either tree. `keys` are those of the trees from restart to restart, and last that of shortcuts.
    """
    state = journal.state
    for _ in range(effort.batch):
        if state[PHASE] == OVER:
            return FOUND if state[PATH] > 0 else BLOCKED
        state[USED] = state[RECENT] = 0
        before = state[COUNTS], state[COUNTS + 1]
        found = _next(low, high, keys, effort, space, grown, journal)
        if found <= ASK:
            state[COUNTS], state[COUNTS + 1] = before
            for i in range(state[RECENT]):
                journal.hits[journal.recent[i]] -= 1
            return found
        state[ANSWERED] = 0
    return PAUSE
