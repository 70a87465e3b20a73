"""Shortcuts: way points are left out, then pairs of points along a path connected directly [Geraerts, Overmars 2007].

Each shortcut is proven free. What is left of a cut edge is a piece of a proven one; it is proven by itself in the end, as
plans store it.
"""

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.kinematics.kernels.streams import uniform
from kabo.ways.kernels.bundles import AHEAD, ATTEMPT, CORNER, COUNTS, FULL, OVER, PATH, PROJECTS, SAFE
from kabo.ways.kernels.edges import between, distance, edge_hit, equal, prove
from kabo.ways.kernels.trees import extend

LEAST_GAIN = 1e-3  # [rad, L2] that a shortcut must save: less is not worth its proof
VAIN, SHORTER = 0, 1


@lean_kernel  # Grown, Journal -> f8
def measure(grown, journal):
    """Writes the length of the path up to each way point; returns the whole length."""
    lengths, path = grown.lengths, grown.path[0]
    lengths[0] = 0.0
    for i in range(1, journal.state[PATH]):
        lengths[i] = lengths[i - 1] + distance(path[i - 1], path[i])
    return lengths[journal.state[PATH] - 1]


@lean_kernel  # f8, (n,) f8, Grown, Journal -> i8; writes q
def point_at(at, q, grown, journal):
    """Writes the rounded point at a length along the path; returns the index of its edge."""
    lengths, path, i = grown.lengths, grown.path[0], 0
    while i < journal.state[PATH] - 2 and lengths[i + 1] <= at:
        i += 1
    piece = lengths[i + 1] - lengths[i]
    share = min(max((at - lengths[i]) / piece, 0.0), 1.0) if piece > 0.0 else 0.0
    for k in range(q.shape[0]):
        q[k] = path[i, k] if share < 1.0 else path[i + 1, k]
    if 0.0 < share < 1.0:
        between(path[i], path[i + 1], share, q)
    return i


@lean_kernel  # (n,) f8, i8, i8, Grown -> i8
def _put(q, flag, count, grown):
    """Appends a way point to the scratch copy unless it repeats the last one; returns the new count."""
    if count > 0 and equal(grown.path[1, count - 1], q):
        return count
    for k in range(q.shape[0]):
        grown.path[1, count, k] = q[k]
    grown.flags[1, count] = flag
    return count + 1


@lean_kernel  # u8, Effort, Space, Grown, Journal -> i8
def shorten(key, effort, space, grown, journal):
    """One attempt: VAIN, SHORTER, or an interrupt."""
    whole = measure(grown, journal)
    first = uniform(key, journal.state[ATTEMPT], 0)
    second = uniform(key, journal.state[ATTEMPT], 1)
    first, second = min(first, second), max(first, second)
    a, b = journal.points[0], journal.points[1]
    i = point_at(first * whole, a, grown, journal)
    j = point_at(second * whole, b, grown, journal)
    if i == j or whole == 0.0 or (second - first) * whole - distance(a, b) < LEAST_GAIN:
        return VAIN
    hit = edge_hit(a, b, effort.spacing, True, space, journal)
    detour = 1
    if hit >= 0 and journal.state[PROJECTS]:
        hit, detour = _bent(a, b, effort, space, grown, journal)
    if hit < FREE:
        return hit
    if hit != FREE:
        return VAIN
    return _spliced(i, j, detour, whole, grown, journal)


@lean_kernel  # (n,) f8 x 2, Effort, Space, Grown, Journal -> i8, i8
def _bent(a, b, effort, space, grown, journal):
    """Whether b is reached from a along the constraint: FREE or 0, or an interrupt; tree 0 then holds the way."""
    for k in range(a.shape[0]):
        grown.nodes[0, 0, k] = a[k]
    journal.state[COUNTS] = 1
    node = extend(0, 0, b, 2.0 * distance(a, b), effort, space, grown, journal)
    if node < 0:
        return node, 0
    return FREE if node > 0 and equal(grown.nodes[0, node], b) else 0, node


@lean_kernel  # i8, i8, i8, f8, Grown, Journal -> i8
def _spliced(i, j, detour, whole, grown, journal):
    """Replaces the path between two points (edges i and j) by the straight edge, or by the way in tree 0."""
    path, flags, a, b = grown.path[0], grown.flags[0], journal.points[0], journal.points[1]
    last = journal.state[PATH]
    if last + detour + 4 > grown.path.shape[1]:
        return FULL
    count = 0
    for k in range(i + 1):
        count = _put(path[k], flags[k], count, grown)
    count = _put(a, flags[i + 1] if equal(a, path[i + 1]) else 0, count, grown)
    for k in range(1, detour):
        count = _put(grown.nodes[0, k], 1, count, grown)
    count = _put(b, 1, count, grown)
    for k in range(j + 1, last):
        flag = flags[k] if k > j + 1 or equal(b, path[j]) else 0
        count = _put(path[k], flag, count, grown)
    length = 0.0
    for k in range(1, count):
        length += distance(grown.path[1, k - 1], grown.path[1, k])
    if not length < whole:
        return VAIN
    for k in range(count):
        flags[k] = grown.flags[1, k]
        for c in range(a.shape[0]):
            path[k, c] = grown.path[1, k, c]
    journal.state[PATH] = count
    return SHORTER


@lean_kernel  # Effort, Space, Grown, Journal -> i8
def cut(effort, space, grown, journal):
    """One attempt to leave out way points: VAIN, SHORTER, OVER after the last one, or an interrupt.

    From each way point the edge to the last one is tried, then that to the one half as far ahead, and so on.
    """
    state, path = journal.state, grown.path[0]
    i, ahead, last = state[CORNER], state[AHEAD], state[PATH] - 1
    if state[PROJECTS] or effort.attempts == 0 or i + 2 > last:
        return OVER
    if ahead == 0:
        state[AHEAD] = last - i
        return VAIN
    measure(grown, journal)
    if grown.lengths[i + ahead] - grown.lengths[i] - distance(path[i], path[i + ahead]) < LEAST_GAIN:
        state[CORNER], state[AHEAD] = i + 1, 0  # nor would a shorter one gain more
        return VAIN
    hit = edge_hit(path[i], path[i + ahead], effort.spacing, True, space, journal)
    if hit < FREE:
        return hit
    if hit != FREE:
        state[AHEAD] = ahead // 2
        return VAIN
    _leave_out(i + 1, i + ahead, grown, journal)
    state[CORNER], state[AHEAD] = i + 1, 0
    return SHORTER


@lean_kernel  # i8, i8, Grown, Journal
def _leave_out(first, end, grown, journal):
    """Removes the way points from `first` to before `end`; the edge that takes their place is proven."""
    path, flags, gap = grown.path[0], grown.flags[0], end - first
    for i in range(end, journal.state[PATH]):
        flags[i - gap] = flags[i]
        for k in range(path.shape[1]):
            path[i - gap, k] = path[i, k]
    flags[first] = 1
    journal.state[PATH] -= gap


@lean_kernel  # Grown, Journal
def save(grown, journal):
    """Keeps the path as the last one that is proven whole."""
    journal.state[SAFE] = journal.state[PATH]
    for i in range(journal.state[PATH]):
        for k in range(grown.path.shape[2]):
            grown.path[2, i, k] = grown.path[0, i, k]


@lean_kernel  # Space, Grown, Journal -> i8
def settle(space, grown, journal):
    """Proves what is left of cut edges; if one is not proven, the path is again what it was. FREE, or an interrupt."""
    path, flags, state = grown.path[0], grown.flags[0], journal.state
    for i in range(1, state[PATH]):
        if flags[i]:
            continue
        hit = prove(path[i - 1], path[i], space, journal)
        if hit < FREE:
            return hit
        if hit != FREE:
            state[PATH] = state[SAFE]
            for k in range(state[SAFE]):
                for c in range(path.shape[1]):
                    path[k, c] = grown.path[2, k, c]
            return FREE
    return FREE
