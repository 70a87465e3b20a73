"""Trees of configurations: nearest nodes, and extensions towards a configuration, along the constraint if there is one.

An extension that is blocked is tried again at half of its length, down to a least one.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.kinematics.kernels.projection import pulled
from kabo.ways.kernels.bundles import COUNTS, FULL, PROJECTS
from kabo.ways.kernels.edges import between, distance, edge_hit, equal, rounded

NEARER = 1e-3  # [rad, L2] that a step along a constraint must come nearer to its target
WHOLE = 0.75  # of an extension: who came less far was blocked


@lean_kernel  # i8, (n,) f8, Grown, Journal -> i8
def nearest(tree, q, grown, journal):
    """The index of the node nearest to q; of equals the first."""
    count, away, columns = journal.state[COUNTS + tree], grown.away, grown.columns[tree]
    for i in range(count):
        away[i] = 0.0
    for k in range(q.shape[0]):
        column, value = columns[k], q[k]
        for i in range(count):
            away[i] += (column[i] - value) * (column[i] - value)
    best, least = 0, np.inf
    for i in range(count):
        if away[i] < least:
            best, least = i, away[i]
    return best


@lean_kernel  # i8, i8, Grown, Journal -> i8
def add(tree, parent, grown, journal):
    """Takes the configuration behind the last node as a new one; returns its index."""
    count = journal.state[COUNTS + tree]
    grown.parents[tree, count] = parent
    for k in range(grown.nodes.shape[2]):
        grown.columns[tree, k, count] = grown.nodes[tree, count, k]
    journal.state[COUNTS + tree] = count + 1
    return count


@lean_kernel  # (n,) f8 x 2, f8, (n,) f8 -> writes q
def stepped(start, target, reach, q):
    """Writes the target if it lies within `reach` of the start, else the point at that distance towards it."""
    away = distance(start, target)
    if away <= reach:
        for i in range(q.shape[0]):
            q[i] = target[i]
    else:
        between(start, target, reach / away, q)


@lean_kernel  # i8, i8, (n,) f8, f8, Effort, Space, Grown, Journal -> i8
def extend(tree, node, target, reach, effort, space, grown, journal):
    """The last new node of an extension from a node towards the target, the node itself if blocked, or an interrupt."""
    if journal.state[PROJECTS]:
        return _along(tree, node, target, reach, effort, space, grown, journal)
    share, away = 1.0, min(reach, distance(grown.nodes[tree, node], target))
    while share * away > effort.least or share == 1.0 and away > 0.0:
        count = journal.state[COUNTS + tree]
        if count == grown.parents.shape[1]:
            return FULL
        here, there = grown.nodes[tree, node], grown.nodes[tree, count]
        stepped(here, target, share * away, there)
        if equal(here, there):
            return node
        hit = edge_hit(here, there, effort.spacing, True, space, journal)
        if hit == FREE:
            return add(tree, node, grown, journal)
        if hit < FREE:
            return hit
        share *= 0.5
    return node


@lean_kernel  # i8, i8, (n,) f8, f8, Effort, Space, Grown, Journal -> i8
def _along(tree, node, target, reach, effort, space, grown, journal):
    """As `extend`, in small steps, each projected onto the constraint, while they come nearer to the target."""
    left = reach
    while left > 0.0:
        count = journal.state[COUNTS + tree]
        if count == grown.parents.shape[1]:
            return FULL
        here, there = grown.nodes[tree, node], grown.nodes[tree, count]
        stepped(here, target, min(effort.step, left), there)
        if not equal(there, target) and not _pulled(here, there, target, effort.step, space.kept):
            break
        if equal(here, there):
            break
        hit = edge_hit(here, there, effort.spacing, True, space, journal)
        if hit < FREE:
            return hit
        if hit != FREE:
            break
        node = add(tree, node, grown, journal)
        left -= distance(here, there)
        if equal(there, target):
            break
    return node


@lean_kernel  # (n,) f8 x 3, f8, Kept -> bool; writes q
def _pulled(here, q, target, step, kept):
    """Projects q onto the constraint; returns whether it is near `here`, and nearer to the target."""
    if not pulled(q, kept.pull, kept.iterations, kept.policy):
        return False
    for i in range(q.shape[0]):
        q[i] = rounded(q[i])
    return distance(target, q) < distance(target, here) - NEARER and distance(q, here) <= 2.0 * step


@lean_kernel  # i8, (n,) f8, Effort, Space, Grown, Journal -> i8, bool
def reach(tree, target, effort, space, grown, journal):
    """Grows a tree towards a configuration; returns the node nearest on the way, or an interrupt, and if it arrived."""
    node = nearest(tree, target, grown, journal)
    while not equal(grown.nodes[tree, node], target):
        before = distance(grown.nodes[tree, node], target)
        further = extend(tree, node, target, effort.extension, effort, space, grown, journal)
        if further < 0:
            return further, False
        if further == node:
            return node, False
        node = further
        short = distance(grown.nodes[tree, node], target) > max(before - WHOLE * effort.extension, 0.0)
        if short and not journal.state[PROJECTS]:  # it was blocked, and would be again
            return node, False
    return node, True
