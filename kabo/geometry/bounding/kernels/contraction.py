"""Bounding mesh by edge contraction [K Algorithm 2]: cheapest edges first, each only if all conditions are proven.

Conditions are: the mesh stays a manifold, no face flips, the new point lies behind no face of the star (exactly),
no new crossing appears, every new face is within the limit of the original, and every original triangle carried by
the star is within the limit of the new faces. The cost decides the order only.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.bounding.kernels import heap
from kabo.geometry.bounding.kernels.bundles import Trial
from kabo.geometry.bounding.kernels.carried_triangles import (
    apply_draft,
    draft_moves,
    draft_proof,
    drop_stale,
    set_candidates,
)
from kabo.geometry.bounding.kernels.star import (
    contract,
    contraction_point,
    gather_star,
    keeps_facing,
    keeps_orientation,
    keeps_sides,
    keeps_topology,
    set_moved,
)
from kabo.geometry.bounding.kernels.star_crossings import keeps_apart
from kabo.geometry.bounding.kernels.triangle_bounds import triangle_bound
from kabo.geometry.triangles.kernels.octree import insert, remove
from kabo.geometry.triangles.kernels.triangle_tree import nearest_triangle, to_face_squared

# What the proofs of one contraction may take; what cannot be proven with it is not done.
MIN_PIECE_BUDGET, PIECES_PER_FACE = 4000, 20
MIN_DISTANCE_BUDGET, DISTANCES_PER_PART = 200_000, 200

# Counters: what was done, and what refused the rest.
DONE, SOLVED, TOPOLOGY, FACING, SIDES, TOO_FAR, UNCOVERED, CROSSING, POPPED, PASSES, POSTPONED = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
    10,
)


@lean_kernel
def enter_face(net, tree, f):
    """Inserts face f with its bounding box into the octree."""
    v, a, b, c = net.vertices, net.faces[f, 0], net.faces[f, 1], net.faces[f, 2]
    low_x, high_x = min(v[a, 0], v[b, 0], v[c, 0]), max(v[a, 0], v[b, 0], v[c, 0])
    low_y, high_y = min(v[a, 1], v[b, 1], v[c, 1]), max(v[a, 1], v[b, 1], v[c, 1])
    low_z, high_z = min(v[a, 2], v[b, 2], v[c, 2]), max(v[a, 2], v[b, 2], v[c, 2])
    insert(tree, f, low_x, low_y, low_z, high_x, high_y, high_z)


@lean_kernel
def faces_near_original(net, original, star, trial, limit, work):
    """Whether every new face is proven within the limit of the original; writes the bounds to star.errors."""
    vertices, faces, bounds, hints, pieces = net.vertices, net.faces, net.errors, net.hints, work.pieces
    listed, corners, errors, squared, budget = star.faces, star.corners, star.errors, limit * limit, work.budget
    count, x, y, z = trial.size, trial.x, trial.y, trial.z
    budget[0] = MIN_PIECE_BUDGET + PIECES_PER_FACE * count
    reached, _ = nearest_triangle(original, x, y, z, hints[listed[0]], squared, work.stack)
    if reached > squared:
        return False
    farthest, worst = limit, -1
    for i in range(count):
        if corners[i] >= 0:
            # The new face has two corners in common with the old one; the third is this far from it.
            f = listed[i]
            errors[i] = bounds[f] + np.sqrt(to_face_squared(x, y, z, vertices, faces, f))
            if errors[i] > farthest:
                farthest, worst = errors[i], i
    # What has moved farthest is looked at first: if anything refuses, it does.
    for i in range(-1 if worst >= 0 else count, count):
        n = worst if i < 0 else i
        f, k = listed[n], corners[n]
        if k >= 0 and errors[n] > limit:
            set_moved(vertices, faces, f, k, x, y, z, pieces)
            reached, hints[f] = triangle_bound(pieces, squared, original, hints[f], work.stack, budget)
            if reached == np.inf:
                return False
            errors[n] = np.sqrt(reached)
    return True


@lean_kernel
def original_near_faces(net, star, trial, limit, evidence):
    """Whether every original triangle of the star is proven within the limit of the new faces; drafts their places."""
    carried, draft, octree, work = evidence.carried, evidence.draft, evidence.octree, evidence.work
    source, proven = evidence.original.triangles, draft.proven
    many = set_candidates(net, star, trial, work.pieces)
    moves, again = draft_moves(net, carried, star, trial.size, many, limit, draft)
    proven[0], proven[2] = moves, again
    work.budget[0] = MIN_DISTANCE_BUDGET + DISTANCES_PER_PART * (moves + again)
    for m in range(again):  # the part that has come farthest is the first of the list
        moves = draft_proof(net, source, star, many, m, limit, moves, draft, octree, work)
        if moves < 0:
            return False
    proven[1] = moves
    return 0 <= moves <= carried.free[1]


@lean_kernel
def _proven_near(net, star, trial, evidence, limit, counters):
    """Whether both directions of distance of a contraction are proven.

    Stars of hundreds of faces may exceed the budget of proofs; their vertex then waits until its star has half the
    faces.
    """
    waits, work, a, b, count = net.waits, evidence.work, trial.a, trial.b, trial.size
    if count > min(waits[a], waits[b]):
        counters[POSTPONED] += 1
        return False
    if not faces_near_original(net, evidence.original, star, trial, limit, work):
        counters[TOO_FAR] += 1
    elif not original_near_faces(net, star, trial, limit, evidence):
        counters[UNCOVERED] += 1
    else:
        return True
    if work.budget[0] <= 0:
        waits[a], waits[b] = min(waits[a], count // 2), min(waits[b], count // 2)
    return False


@lean_kernel
def _admissible(net, star, trial, evidence, settings, counters):
    """Whether all conditions of a contraction are proven."""
    if not keeps_topology(net, trial):
        counters[TOPOLOGY] += 1
        return False
    if not keeps_facing(net, star, trial, settings):
        counters[FACING] += 1
        return False
    vertices, spare = net.vertices, net.vertices.shape[0] - 1
    vertices[spare, 0], vertices[spare, 1], vertices[spare, 2] = trial.x, trial.y, trial.z
    if not keeps_sides(net, star, trial, evidence.work.exact):
        counters[SIDES] += 1
        return False
    if not keeps_orientation(net, star, trial):
        counters[SIDES] += 1
        return False
    net.clock[1] += 1
    for i in range(trial.size):
        net.face_marks[star.faces[i]] = net.clock[1]
    if not settings.certify:
        return True
    if not _proven_near(net, star, trial, evidence, settings.limit, counters):
        return False
    if not keeps_apart(net, star, trial, evidence.octree, evidence.work):
        counters[CROSSING] += 1
        return False
    return True


@lean_kernel
def _replace(net, star, trial, evidence, settings):
    """Executes a contraction in all data structures."""
    octree, carried, count = evidence.octree, evidence.carried, trial.size
    if settings.certify:
        for i in range(count):
            remove(octree, star.faces[i])
            net.errors[star.faces[i]] = star.errors[i]
    contract(net, star, trial, settings)
    if settings.certify:
        for i in range(count):
            if star.corners[i] >= 0:
                enter_face(net, octree, star.faces[i])
        apply_draft(carried, star, count, evidence.draft)
        drop_stale(carried)


@lean_kernel
def _offer(net, a, b, star, queue, size, stamp, settings, counters):
    """Puts an edge into the queue, if there is a valid point for it; returns the queue's size."""
    if net.locked[a] or net.locked[b]:
        return size
    if a > b:
        a, b = b, a
    count = gather_star(net, a, b, star)
    cost, _, _, _ = contraction_point(net, a, b, star, count, settings)
    counters[SOLVED] += 1
    if count > 0 and cost <= settings.dearest and size < queue.costs.shape[0]:
        return heap.push(queue.costs, queue.edges, size, cost, a, b, stamp)
    return size


@lean_kernel
def _offer_around(net, a, star, queue, size, settings, counters):
    """Puts all edges at vertex a into the queue; returns the queue's size."""
    net.clock[0] += 2
    stamp, net.marks[a] = net.clock[0], net.clock[0]
    c, ring = net.first[a], 0
    while c >= 0:
        net.changed[net.faces[c // 3, (c + 1) % 3]] = net.changed[net.faces[c // 3, (c + 2) % 3]] = counters[DONE]
        for k in range(3):
            w = net.faces[c // 3, k]
            if net.marks[w] != stamp:
                net.marks[w] = stamp
                star.ring[ring] = w
                ring += 1
        c = net.following[c]
    for r in range(ring):
        size = _offer(net, a, star.ring[r], star, queue, size, counters[DONE], settings, counters)
    return size


@lean_kernel
def drop_outdated(net, queue, size):
    """Rebuilds the queue from its entries that are still valid; returns the new size."""
    kept = 0
    for i in range(size):
        cost, a, b, stamp = queue.costs[i], queue.edges[i, 0], queue.edges[i, 1], queue.edges[i, 2]
        if not net.dead[a] and not net.dead[b] and stamp >= max(net.moved[a], net.moved[b]):
            kept = heap.push(queue.costs, queue.edges, kept, cost, a, b, stamp)
    return kept


@lean_kernel
def _offer_again(net, star, queue, settings, counters):
    """Queues refused edges around which the mesh has changed since; returns the queue's size."""
    size, kept, refused = 0, 0, queue.refused
    for i in range(net.clock[2]):
        a, b, stamp = refused[i, 0], refused[i, 1], refused[i, 2]
        if net.dead[a] or net.dead[b] or refused[i, 3] < max(net.moved[a], net.moved[b]):
            continue
        if max(net.changed[a], net.changed[b]) > stamp:
            size = _offer(net, a, b, star, queue, size, counters[DONE], settings, counters)
        else:
            for k in range(4):
                refused[kept, k] = refused[i, k]
            kept += 1
    net.clock[2] = kept
    return size


@lean_kernel
def _offer_all(net, star, queue, settings, counters):
    """Puts all edges into the queue; returns the queue's size."""
    size = 0
    for f in range(net.faces.shape[0]):
        if net.faces[f, 0] >= 0:
            for k in range(3):
                a, b = net.faces[f, k], net.faces[f, (k + 1) % 3]
                if a < b:
                    size = _offer(net, a, b, star, queue, size, counters[DONE], settings, counters)
    return size


@lean_kernel
def contract_all(net, star, queue, evidence, settings, counters):
    """Contracts edges, cheapest first, until none can be contracted, or `settings.vertices` are left."""
    net.clock[2], refused = 0, queue.refused
    size = _offer_all(net, star, queue, settings, counters)
    alive, before = settings.alive - counters[DONE], -1
    while alive > settings.vertices:
        if size == 0:
            if counters[DONE] == before:
                break
            before = counters[DONE]
            counters[PASSES] += 1
            size = _offer_again(net, star, queue, settings, counters)
            continue
        cost, a, b, stamp = queue.costs[0], queue.edges[0, 0], queue.edges[0, 1], queue.edges[0, 2]
        size = heap.pop(queue.costs, queue.edges, size)
        counters[POPPED] += 1
        if net.dead[a] or net.dead[b] or stamp < max(net.moved[a], net.moved[b]):
            continue
        count = gather_star(net, a, b, star)
        today, x, y, z = contraction_point(net, a, b, star, count, settings)
        counters[SOLVED] += 1
        if today > settings.dearest or today == np.inf:
            continue
        if today > cost * settings.patience and size > 0 and today > queue.costs[0]:
            size = heap.push(queue.costs, queue.edges, size, today, a, b, stamp)
            continue
        trial = Trial(a, b, count, x, y, z)
        if not _admissible(net, star, trial, evidence, settings, counters):
            if net.clock[2] < refused.shape[0]:
                refused[net.clock[2], 0], refused[net.clock[2], 1] = a, b
                refused[net.clock[2], 2], refused[net.clock[2], 3] = counters[DONE], stamp
                net.clock[2] += 1
            continue
        _replace(net, star, trial, evidence, settings)
        counters[DONE] += 1
        alive -= 1
        net.moved[a] = counters[DONE]
        if size + 3 * count > queue.costs.shape[0]:
            size = drop_outdated(net, queue, size)
        size = _offer_around(net, a, star, queue, size, settings, counters)


@lean_kernel
def enter_all(net, tree):
    """Inserts all faces with their bounding boxes into the octree."""
    for f in range(net.faces.shape[0]):
        enter_face(net, tree, f)
