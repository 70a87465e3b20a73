"""Edges of a path: looked at in some configurations first, which is cheap, then proven free as a whole.

Most edges of a tree are blocked, and a single colliding configuration shows it: so proving all the others costs
little more than sampling them would [docs/decisions/001-kernels.md].

What the arrays cannot decide is asked of Python: the kernel returns ASK, and does the sample in work again when the
answer is in the journal.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.geometry.collision.kernels.configuration_check import first_hit
from kabo.geometry.collision.kernels.sweep import first_swept_hit
from kabo.kinematics.kernels.motion_bounds import first_row_not_kept
from kabo.ways.kernels.bundles import (
    ANSWERED,
    ASK,
    CONSTRAINT,
    FREE_COUNTS,
    HIT_COUNTS,
    KIND,
    LOOK,
    LOOKS,
    PROOF,
    RECENT,
    USED,
)


@lean_kernel  # (n,) f8 x 2 -> f8
def distance(a, b):
    """The distance of two configurations (L2 over the joints)."""
    total = 0.0
    for i in range(a.shape[0]):
        total += (a[i] - b[i]) * (a[i] - b[i])
    return np.sqrt(total)


@lean_kernel  # (n,) f8 x 2 -> bool
def equal(a, b):
    """Whether two configurations are the same."""
    same = True
    for i in range(a.shape[0]):
        same = same and a[i] == b[i]
    return same


@lean_kernel  # f8 -> f8
def rounded(value):
    """A joint value with nine decimals, as plans store it: what is proven is what is stored."""
    return np.rint(value * 1e9) / 1e9 + 0.0


@lean_kernel  # (n,) f8 x 2, f8, (n,) f8 -> writes q
def between(a, b, share, q):
    """Writes the rounded configuration at a share of the way from a to b."""
    for i in range(a.shape[0]):
        q[i] = a[i] if a[i] == b[i] else rounded(a[i] + share * (b[i] - a[i]))


@lean_kernel  # i8, (n,) f8 x 2, Journal -> i8
def asked(kind, a, b, journal):
    """The answer to the next question of the sample in work, or ASK, with the question in the journal."""
    state = journal.state
    place = state[USED]
    state[USED] += 1
    if place < state[ANSWERED]:
        return journal.answers[place]
    state[KIND] = kind
    for i in range(a.shape[0]):
        journal.question[0, i], journal.question[1, i] = a[i], b[i]
    return ASK


@lean_kernel  # (n,) f8 x 2, f8, Space, Journal -> i8
def look(a, b, spacing, space, journal):
    """FREE, the pair hit at one of some configurations of an edge, or ASK; a is known to be free.

    The end comes first, then the middle, the quarters …, until they lie no farther apart than `spacing`.
    """
    state, hit = journal.state, FREE
    if state[FREE_COUNTS] + state[HIT_COUNTS] > 0:
        pieces, count, q = np.ceil(distance(a, b) / spacing), 1, journal.points[3]
        hit = first_hit(b, space.memory)
        while hit == FREE and count < pieces:
            for i in range(count):
                share = (i + 0.5) / count
                for k in range(q.shape[0]):
                    q[k] = a[k] + share * (b[k] - a[k])
                hit = first_hit(q, space.memory)
                if hit != FREE:
                    break
            count *= 2
        if hit >= 0 and state[HIT_COUNTS] or hit == FREE and state[FREE_COUNTS]:
            return hit
    return asked(LOOK, a, b, journal) if state[LOOKS] else FREE


@lean_kernel  # (n,) f8 x 2, Space, Journal -> i8
def prove(a, b, space, journal):
    """FREE if the edge is proven free and within the constraint, else the pair that is hit, or ASK."""
    state, kept = journal.state, space.kept
    rows = kept.rows
    if rows.shape[0] > 0 and first_row_not_kept(rows, kept.tolerances, a, b, kept.tree, kept.pieces) >= 0:
        return state[CONSTRAINT]
    if state[FREE_COUNTS] + state[HIT_COUNTS] > 0:
        hit = first_swept_hit(
            a, b, space.margin, space.clearance, space.pairs, space.scene, space.sweep, space.search
        )
        if hit >= 0 and state[HIT_COUNTS] or hit == FREE and state[FREE_COUNTS]:
            return hit
    return asked(PROOF, a, b, journal)


@lean_kernel  # i8, Journal
def note(hit, journal):
    """Counts an edge that was rejected, by the pair."""
    state = journal.state
    journal.hits[hit] += 1
    if state[RECENT] < journal.recent.shape[0]:
        journal.recent[state[RECENT]] = hit
        state[RECENT] += 1


@lean_kernel  # (n,) f8 x 2, f8, bool, Space, Journal -> i8
def edge_hit(a, b, spacing, proves, space, journal):
    """FREE, the pair that is hit (which is counted), or ASK."""
    hit = look(a, b, spacing, space, journal)
    if hit == FREE and proves:
        hit = prove(a, b, space, journal)
    if hit >= 0:
        note(hit, journal)
    return hit
