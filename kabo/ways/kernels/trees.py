"""Trees of configurations: nearest nodes, and extensions towards a configuration, along the constraint if there is one.

An extension that is blocked is tried again at half and at a quarter of its length.
"""

import numpy as np

from kabo.compilation import kernel
from kabo.geometry.collision.kernels.bundles import FREE
from kabo.kinematics.kernels.projection import project_seeds
from kabo.ways.kernels.bundles import COUNTS, FULL, PROJECTS
from kabo.ways.kernels.edges import between, distance, edge_hit, equal, prove, rounded

NEARER = 1e-3  # [rad, L2] that a step along a constraint must come nearer to its target
WHOLE = 0.75  # of an extension: who came less far was blocked
LEAST_SHARE = 0.2  # of an extension that is blocked: shorter ones are not tried


@kernel  # (C, n) f8, i8, (n,) f8 -> i8
def nearest(nodes, count, q):
    """The index of the node nearest to q; of equals the first."""
    best, least = 0, np.inf
    for i in range(count):
        away = 0.0
        for k in range(q.shape[0]):
            away += (nodes[i, k] - q[k]) * (nodes[i, k] - q[k])
        if away < least:
            best, least = i, away
    return best


@kernel  # i8, i8, bool, Grown, Journal -> i8
def add(tree, parent, proven, grown, journal):
    """Takes the configuration behind the last node as a new one; returns its index."""
    count = journal.state[COUNTS + tree]
    grown.parents[tree, count] = parent
    grown.proven[tree, count] = proven
    journal.state[COUNTS + tree] = count + 1
    return count


@kernel  # (n,) f8 x 2, f8, (n,) f8 -> writes q
def stepped(start, target, reach, q):
    """Writes the target if it lies within `reach` of the start, else the point at that distance towards it."""
    away = distance(start, target)
    if away <= reach:
        for i in range(q.shape[0]):
            q[i] = target[i]
    else:
        between(start, target, reach / away, q)


@kernel  # i8, i8, (n,) f8, f8, Effort, bool, Space, Grown, Journal -> i8
def extend(tree, node, target, reach, effort, proves, space, grown, journal):
    """The last new node of an extension from a node towards the target; the node itself if it is blocked; or an interrupt."""
    if journal.state[PROJECTS]:
        return _along(tree, node, target, reach, effort, space, grown, journal)
    share, away = 1.0, min(reach, distance(grown.nodes[tree, node], target))
    while share > LEAST_SHARE and away > 0.0:
        count = journal.state[COUNTS + tree]
        if count == grown.parents.shape[1]:
            return FULL
        here, there = grown.nodes[tree, node], grown.nodes[tree, count]
        stepped(here, target, share * away, there)
        if equal(here, there):
            return node
        hit = edge_hit(here, there, effort.spacing, proves, space, journal)
        if hit == FREE:
            return add(tree, node, proves, grown, journal)
        if hit < FREE:
            return hit
        share *= 0.5
    return node


@kernel  # i8, i8, (n,) f8, f8, Effort, Space, Grown, Journal -> i8
def _along(tree, node, target, reach, effort, space, grown, journal):
    """As `extend`, in small steps, each projected onto the constraint, while they come nearer to the target."""
    left = reach
    while left > 0.0:
        count = journal.state[COUNTS + tree]
        if count == grown.parents.shape[1]:
            return FULL
        here, there = grown.nodes[tree, node], grown.nodes[tree, count]
        stepped(here, target, min(effort.step, left), there)
        if not equal(there, target) and not _pulled(here, there, target, effort.step, space.kept, journal):
            break
        if equal(here, there):
            break
        hit = edge_hit(here, there, effort.spacing, True, space, journal)
        if hit < FREE:
            return hit
        if hit != FREE:
            break
        node = add(tree, node, True, grown, journal)
        left -= distance(here, there)
        if equal(there, target):
            break
    return node


@kernel  # (n,) f8 x 3, f8, Kept, Journal -> bool; writes q
def _pulled(here, q, target, step, kept, journal):
    """Projects q onto the constraint; returns whether it is near `here`, and nearer to the target."""
    found = journal.pulled[0]
    for i in range(q.shape[0]):
        found[i] = q[i]
    project_seeds(journal.pulled, journal.succeeded, kept.wanted, kept.tree, kept.active, kept.rule)
    if not journal.succeeded[0]:
        return False
    for i in range(q.shape[0]):
        q[i] = rounded(found[i])
    return distance(target, q) < distance(target, here) - NEARER and distance(q, here) <= 2.0 * step


@kernel  # i8, (n,) f8, Effort, bool, Space, Grown, Journal -> i8, bool
def reach(tree, target, effort, proves, space, grown, journal):
    """Grows a tree towards a configuration; returns the node nearest on the way, or an interrupt, and if it arrived."""
    node = nearest(grown.nodes[tree], journal.state[COUNTS + tree], target)
    while not equal(grown.nodes[tree, node], target):
        before = distance(grown.nodes[tree, node], target)
        further = extend(tree, node, target, effort.extension, effort, proves, space, grown, journal)
        if further < 0:
            return further, False
        if further == node:
            return node, False
        node = further
        short = distance(grown.nodes[tree, node], target) > max(before - WHOLE * effort.extension, 0.0)
        if short and not journal.state[PROJECTS]:  # it was blocked, and would be again
            return node, False
    return node, True


@kernel  # i8, i8, Space, Grown, Journal -> i8, i8
def prove_branch(tree, node, space, grown, journal):
    """FREE if every edge from a node to the root is proven; else the pair that is hit, or an interrupt, and the node there."""
    while node > 0:
        parent = grown.parents[tree, node]
        if not grown.proven[tree, node]:
            hit = prove(grown.nodes[tree, parent], grown.nodes[tree, node], space, journal)
            if hit != FREE:
                return hit, node
            grown.proven[tree, node] = 1
        node = parent
    return FREE, 0


@kernel  # i8, i8, Grown, Journal
def cut(tree, node, grown, journal):
    """Takes a node, and all that hangs on it, out of a tree; parents come before their children."""
    kept = node
    nodes, parents, proven, moved = grown.nodes[tree], grown.parents[tree], grown.proven[tree], grown.moved
    for i in range(node):
        moved[i] = i
    moved[node] = -1
    for i in range(node + 1, journal.state[COUNTS + tree]):
        if moved[parents[i]] < 0:
            moved[i] = -1
            continue
        moved[i] = kept
        for k in range(nodes.shape[1]):
            nodes[kept, k] = nodes[i, k]
        parents[kept], proven[kept] = moved[parents[i]], proven[i]
        kept += 1
    journal.state[COUNTS + tree] = kept
