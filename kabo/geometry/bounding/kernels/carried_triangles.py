"""Lists that assign every original triangle to nearby faces of the mesh during contraction.

A `carried` structure holds nodes in a linked list for each face (`heads[f]`, `following[n]`): node n states that a
part of original triangle `items[n]` lies within `bounds[n]` of the face. The parts of a triangle in all its nodes
make up the whole triangle. A node is stale, and ignored, once its `stamps[n]` differs from the triangle's `valid`
stamp. So at any time every original triangle is within the greatest bound of the contracted mesh. The changes that
a contraction would make are first written to a `draft`.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.bounding.kernels.star import set_moved
from kabo.geometry.bounding.kernels.triangle_bounds import (
    DEPTH_COLUMN,
    DISTANCE_COLUMNS,
    NEAREST_COLUMNS,
    cut,
    piece_to_triangle_squared,
    set_new_corner,
)
from kabo.geometry.triangles.kernels.octree import query
from kabo.geometry.triangles.kernels.triangle_tree import to_face_squared, to_triangle_squared

MAX_CUT_DEPTH = 50  # cuts of a piece after which a proof is given up


@lean_kernel
def start(carried, triangles):
    """Initialises the lists: face f gets one node, for original triangle `triangles[f]`; all other nodes are free."""
    heads, items, following, free = carried.heads, carried.items, carried.following, carried.free
    faces, nodes = heads.shape[0], items.shape[0]
    for f in range(faces):
        heads[f], items[f], following[f] = f, triangles[f], -1
        carried.stamps[f], carried.bounds[f], carried.valid[f], carried.marks[f] = 0, 0.0, 0, 0
    for n in range(faces, nodes):
        following[n] = n + 1 if n + 1 < nodes else -1
    free[0], free[1], free[2] = faces if faces < nodes else -1, nodes - faces, (nodes - faces) // 2


@lean_kernel
def set_candidates(net, star, trial, pieces):
    """Writes the new faces of the star to `star.triangles`, their face indices to `star.slots`; returns their number."""
    vertices, faces, listed, corners = net.vertices, net.faces, star.faces, star.corners
    triangles, slots, places = star.triangles, star.slots, star.places
    many = 0
    for i in range(trial.size):
        if corners[i] >= 0:
            set_moved(vertices, faces, listed[i], corners[i], trial.x, trial.y, trial.z, pieces)
            for k in range(3):
                for r in range(3):
                    triangles[many, k, r] = pieces[0, 3 * k + r]
            slots[many], places[i] = listed[i], many
            many += 1
    return many


@lean_kernel
def _nearest_new(net, star, i, many):
    """The new face nearest to face i of the star, and a bound of the distance of any point of face i from it."""
    vertices, faces, corners, triangles = net.vertices, net.faces, star.corners, star.triangles
    f, best, found = star.faces[i], np.inf, 0
    first, end = (0, many) if corners[i] < 0 else (star.places[i], star.places[i] + 1)
    for t in range(first, end):
        farthest = 0.0
        for k in range(3):
            if corners[i] < 0 or k == corners[i]:
                v = faces[f, k]
                x, y, z = vertices[v, 0], vertices[v, 1], vertices[v, 2]
                farthest = max(farthest, to_triangle_squared(x, y, z, triangles, t))
        if farthest < best:
            best, found = farthest, t
    return found, np.sqrt(best)


@lean_kernel
def draft_moves(net, carried, star, count, many, limit, draft):
    """Drafts a move of every node of the star to a new face where bounds keep the limit.

    Triangles that need a new proof are listed in `draft.again`. Returns the numbers of moves and of these
    triangles; (-1, 0) if the draft has no space for all moves.
    """
    heads, items, bounds, following = carried.heads, carried.items, carried.bounds, carried.following
    stamps, valid, marks = carried.stamps, carried.valid, carried.marks
    drafted, onto, reached, listed = draft.nodes, draft.faces, draft.bounds, draft.again
    moves, again, farthest, stamp = 0, 0, 0.0, carried.marks_used[0] + 1
    carried.marks_used[0] = stamp
    for i in range(count):
        target, shift = _nearest_new(net, star, i, many)
        face = star.slots[target]
        n = heads[star.faces[i]]
        while n >= 0:
            t = items[n]
            if stamps[n] == valid[t] and marks[t] != stamp:
                if bounds[n] + shift <= limit:
                    if moves == drafted.shape[0]:
                        return -1, 0
                    drafted[moves], onto[moves], reached[moves] = t, face, bounds[n] + shift
                    moves += 1
                else:
                    marks[t] = stamp
                    listed[again, 0], listed[again, 1] = t, target
                    if bounds[n] + shift > farthest:
                        farthest = bounds[n] + shift
                        listed[again, 0], listed[again, 1] = listed[0, 0], listed[0, 1]
                        listed[0, 0], listed[0, 1] = t, target
                    again += 1
            n = following[n]
    return moves, again


@lean_kernel
def _nearest_candidate(net, tree, star, many, x, y, z, hint, squared, work):
    """The squared distance of a point to the nearest candidate, its index, and the number of candidates.

    Candidates are the new faces; if all are farther than the limit, the nearest face outside the star is added.
    """
    triangles, slots, found = star.triangles, star.slots, work.found
    best, which = to_triangle_squared(x, y, z, triangles, hint), hint
    for g in range(many):
        distance = to_triangle_squared(x, y, z, triangles, g)
        if distance < best:
            best, which = distance, g
    if best <= squared:
        return best, which, many
    vertices, faces, face_marks, star_mark = net.vertices, net.faces, net.face_marks, net.clock[1]
    limit, face = np.sqrt(squared), star_mark
    count = query(tree, x - limit, y - limit, z - limit, x + limit, y + limit, z + limit, work.stack, found)
    for i in range(min(count, found.shape[0])):
        f = found[i]
        if face_marks[f] != star_mark:
            distance = to_face_squared(x, y, z, vertices, faces, f)
            if distance < best:
                best, which, face = distance, many, f
    if which < many or many == slots.shape[0]:
        return best, min(which, many - 1), many
    slots[many] = face
    for k in range(3):
        v = faces[face, k]
        for r in range(3):
            triangles[many, k, r] = vertices[v, r]
    return best, many, many + 1


@lean_kernel
def _add(draft, begun, moves, t, f, bound):
    """Drafts a part of triangle t on face f, or raises the bound of a part drafted there; returns the number of moves."""
    nodes, faces, bounds = draft.nodes, draft.faces, draft.bounds
    for m in range(begun, moves):
        if faces[m] == f:
            bounds[m] = max(bounds[m], bound)
            return moves
    if moves == nodes.shape[0]:
        return -1
    nodes[moves], faces[moves], bounds[moves] = t, f, bound
    return moves + 1


@lean_kernel
def draft_proof(net, source, star, many, m, limit, moves, draft, tree, work):
    """Drafts nodes for all parts of the m-th original triangle of `draft.again`, each on a face within the limit of it.

    `source` (T, 3, 3) are the original triangles, and `work.budget` says about how many distances may be computed.
    Returns the total number of drafted moves; -1 if the proof fails.
    """
    triangles, slots, squared, begun = star.triangles, star.slots, limit * limit, moves
    pieces, budget, t, near_to = work.pieces, work.budget, draft.again[m, 0], draft.again[m, 1]
    for k in range(3):
        for r in range(3):
            pieces[0, 3 * k + r] = source[t, k, r]
    bound = piece_to_triangle_squared(pieces, 0, triangles, near_to)
    if bound <= squared:
        return _add(draft, begun, moves, t, slots[near_to], np.sqrt(bound))
    for c in range(3):
        x, y, z = pieces[0, 3 * c], pieces[0, 3 * c + 1], pieces[0, 3 * c + 2]
        far, near_to, many = _nearest_candidate(net, tree, star, many, x, y, z, near_to, squared, work)
        if far > squared:
            return -1
        pieces[0, DISTANCE_COLUMNS + c], pieces[0, NEAREST_COLUMNS + c] = far, near_to
    pieces[0, DEPTH_COLUMN], top = 0.0, 1
    while budget[0] > 0:
        if top == 0:
            return moves
        top -= 1
        budget[0] -= many
        for c in range(3):
            g = int(pieces[top, NEAREST_COLUMNS + c])
            bound = piece_to_triangle_squared(pieces, top, triangles, g)
            if bound <= squared:
                moves = _add(draft, begun, moves, t, slots[g], np.sqrt(bound))
                break
        if bound <= squared:
            if moves < 0:
                return -1
            continue
        if pieces[top, DEPTH_COLUMN] >= MAX_CUT_DEPTH or top + 2 > pieces.shape[0]:
            return -1
        corner, x, y, z = cut(pieces, top, triangles, squared)
        hint = int(pieces[top, NEAREST_COLUMNS + corner])
        far, near_to, many = _nearest_candidate(net, tree, star, many, x, y, z, hint, squared, work)
        if far > squared:
            return -1
        set_new_corner(pieces, top, corner, far, near_to)
        top += 2
    return -1


@lean_kernel
def _release(carried, n):
    """Frees node n."""
    carried.following[n] = carried.free[0]
    carried.free[0] = n
    carried.free[1] += 1


@lean_kernel
def apply_draft(carried, star, count, draft):
    """Replaces the nodes of the star by the drafted ones, after the contraction.

    `draft.proven` holds three numbers: moves by bounds, all moves, and triangles with a new proof.
    """
    heads, items, bounds, following = carried.heads, carried.items, carried.bounds, carried.following
    stamps, valid, marks, free, stamp = (
        carried.stamps,
        carried.valid,
        carried.marks,
        carried.free,
        carried.marks_used[0],
    )
    for i in range(count):
        f = star.faces[i]
        n = heads[f]
        while n >= 0:
            rest = following[n]
            _release(carried, n)
            n = rest
        heads[f] = -1
    for m in range(draft.proven[2]):
        valid[draft.again[m, 0]] += 1
    for m in range(draft.proven[1]):
        t, f = draft.nodes[m], draft.faces[m]
        if m < draft.proven[0] and marks[t] == stamp:
            continue  # another part of the same triangle had to be proven anew, and all of it was
        n = free[0]
        free[0] = following[n]
        free[1] -= 1
        items[n], bounds[n], stamps[n] = t, draft.bounds[m], valid[t]
        following[n] = heads[f]
        heads[f] = n


@lean_kernel
def drop_stale(carried):
    """Frees all stale nodes if few nodes are free, and updates the threshold of free nodes for the next call."""
    if carried.free[1] >= carried.free[2]:
        return
    heads, items, following, stamps, valid = (
        carried.heads,
        carried.items,
        carried.following,
        carried.stamps,
        carried.valid,
    )
    for f in range(heads.shape[0]):
        n, kept = heads[f], -1
        while n >= 0:
            rest = following[n]
            if stamps[n] == valid[items[n]]:
                following[n] = kept
                kept = n
            else:
                _release(carried, n)
            n = rest
        heads[f] = kept
    carried.free[2] = carried.free[1] // 2
