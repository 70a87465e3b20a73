"""Proven distances of triangles from a mesh, by branch and bound.

The distance to one triangle t is a convex function, so over any other triangle it is greatest at a corner. A triangle
lies within d of a mesh if it can be cut into pieces, each with all three corners within d of one triangle of the mesh.
Pieces are cut where the nearest triangle changes, so that few are needed.

A piece is a row: three corners, the squared distance of each to its nearest triangle, that triangle, and the depth.
"""

import numpy as np

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.triangle_tree import nearest_triangle, to_triangle_squared

PIECE_COLUMNS = 16  # columns of a piece
DISTANCE_COLUMNS, NEAREST_COLUMNS, DEPTH_COLUMN = 9, 12, 15  # first columns of each kind
MAX_CUT_DEPTH = 50  # cuts of a piece after which a proof is given up
MAX_BISECTIONS = 48  # to find where two triangles are near enough, or equally near


@lean_kernel  # (S, 16) f8, i8, (T, 3, 3) f8, i8 -> f8
def piece_to_triangle_squared(pieces, n, triangles, t):
    """The greatest squared distance of any point of piece n to triangle t."""
    return max(
        to_triangle_squared(pieces[n, 0], pieces[n, 1], pieces[n, 2], triangles, t),
        to_triangle_squared(pieces[n, 3], pieces[n, 4], pieces[n, 5], triangles, t),
        to_triangle_squared(pieces[n, 6], pieces[n, 7], pieces[n, 8], triangles, t),
    )


@lean_kernel  # (S, 16) f8, i8, (T, 3, 3) f8, f8 -> f8
def piece_bound(pieces, n, triangles, enough):
    """The least squared bound for piece n from the triangles nearest to its corners; stops at a bound <= `enough`."""
    best = np.inf
    for c in range(3):
        t = int(pieces[n, NEAREST_COLUMNS + c])
        if c > 0 and t == int(pieces[n, NEAREST_COLUMNS + c - 1]):
            continue
        best = min(best, piece_to_triangle_squared(pieces, n, triangles, t))
        if best <= enough:
            break
    return best


@lean_kernel  # (S, 16) f8, i8, (T, 3, 3) f8 -> i8, f8 x 3
def cut(pieces, n, triangles, enough):
    """Cuts piece n in two across its longest edge whose ends have different nearest triangles.

    The cut is at a point whose squared distances to both triangles are at most `enough`, else where both distances
    are about equal; at every fifth depth, at the middle of the longest edge.

    The halves are written to rows n and n + 1. Returns the index c of the new corner in row n, and its position;
    in row n + 1 it is corner (c + 2) % 3. The caller computes its distance and nearest triangle.
    """
    level = int(pieces[n, DEPTH_COLUMN])
    middle = level % 5 == 4  # now and then in the middle, so that pieces shrink whatever happens
    longest, at = -1.0, 0
    for c in range(3):
        d = (c + 1) % 3
        x = pieces[n, 3 * d] - pieces[n, 3 * c]
        y, z = pieces[n, 3 * d + 1] - pieces[n, 3 * c + 1], pieces[n, 3 * d + 2] - pieces[n, 3 * c + 2]
        squared = x * x + y * y + z * z
        if (middle or pieces[n, NEAREST_COLUMNS + c] != pieces[n, NEAREST_COLUMNS + d]) and squared > longest:
            longest, at = squared, c
    i, j = 3 * at, 3 * ((at + 1) % 3)
    low, high = 0.0, 1.0
    s, t = int(pieces[n, NEAREST_COLUMNS + at]), int(pieces[n, NEAREST_COLUMNS + (at + 1) % 3])
    part = 0.5
    if not middle and s != t:
        for _ in range(MAX_BISECTIONS):
            x = pieces[n, i] + part * (pieces[n, j] - pieces[n, i])
            y = pieces[n, i + 1] + part * (pieces[n, j + 1] - pieces[n, i + 1])
            z = pieces[n, i + 2] + part * (pieces[n, j + 2] - pieces[n, i + 2])
            to_s, to_t = to_triangle_squared(x, y, z, triangles, s), to_triangle_squared(x, y, z, triangles, t)
            if max(to_s, to_t) <= enough:
                break
            if to_s <= to_t:
                low = part
            else:
                high = part
            part = 0.5 * (low + high)
    for r in range(PIECE_COLUMNS):
        pieces[n + 1, r] = pieces[n, r]
    x = pieces[n, i] + part * (pieces[n, j] - pieces[n, i])
    y = pieces[n, i + 1] + part * (pieces[n, j + 1] - pieces[n, i + 1])
    z = pieces[n, i + 2] + part * (pieces[n, j + 2] - pieces[n, i + 2])
    pieces[n, j], pieces[n, j + 1], pieces[n, j + 2] = x, y, z
    pieces[n + 1, i], pieces[n + 1, i + 1], pieces[n + 1, i + 2] = x, y, z
    pieces[n, DEPTH_COLUMN] = pieces[n + 1, DEPTH_COLUMN] = level + 1
    return (at + 1) % 3, x, y, z


@lean_kernel  # (S, 16) f8, i8, i8, f8, i8 -> nothing
def set_new_corner(pieces, n, corner, squared, t):
    """Writes the squared distance and the nearest triangle t of the corner that `cut` created, in both halves."""
    pieces[n, DISTANCE_COLUMNS + corner], pieces[n, NEAREST_COLUMNS + corner] = squared, t
    other = (corner + 2) % 3
    pieces[n + 1, DISTANCE_COLUMNS + other], pieces[n + 1, NEAREST_COLUMNS + other] = squared, t


@lean_kernel
def triangle_bound(pieces, limit, tree, hint, stack, budget):
    """Proves that every point of a triangle lies within the squared distance `limit` of the mesh, piece by piece.

    Returns a proven upper bound of the squared distances, inf if none up to `limit` was proven; and the mesh
    triangle from which the next call should start (its `hint`).

    pieces (64, 16): the stack of pieces still to be tested; row 0 holds the triangle. budget (1,) i8: the number
    of pieces that may still be tested; it is decreased.
    """
    triangles, top = tree.triangles, 1
    reached = piece_to_triangle_squared(pieces, 0, triangles, hint)
    if reached <= limit:
        return reached, hint
    x, y, z = pieces[0, 0] + pieces[0, 3] + pieces[0, 6], pieces[0, 1] + pieces[0, 4] + pieces[0, 7], pieces[0, 2]
    z = (z + pieces[0, 5] + pieces[0, 8]) / 3.0
    squared, hint = nearest_triangle(tree, x / 3.0, y / 3.0, z, hint, 0.0, stack)
    if squared > limit:
        return np.inf, hint
    reached = piece_to_triangle_squared(pieces, 0, triangles, hint)
    if reached <= limit:
        return reached, hint
    for c in range(3):
        x, y, z = pieces[0, 3 * c], pieces[0, 3 * c + 1], pieces[0, 3 * c + 2]
        squared, t = nearest_triangle(tree, x, y, z, hint, 0.0, stack)
        if squared > limit:
            return np.inf, hint
        pieces[0, DISTANCE_COLUMNS + c], pieces[0, NEAREST_COLUMNS + c] = squared, t
    pieces[0, DEPTH_COLUMN], reached = 0.0, 0.0
    while budget[0] > 0:
        budget[0] -= 1
        top -= 1
        bound = piece_bound(pieces, top, triangles, limit)
        if bound <= limit:
            reached = max(reached, bound)
            if top == 0:
                return reached, hint
            continue
        if pieces[top, DEPTH_COLUMN] >= MAX_CUT_DEPTH or top + 2 > pieces.shape[0]:
            return np.inf, hint
        corner, x, y, z = cut(pieces, top, triangles, limit)
        squared, t = nearest_triangle(tree, x, y, z, int(pieces[top, NEAREST_COLUMNS + corner]), 0.0, stack)
        if squared > limit:
            return np.inf, hint
        set_new_corner(pieces, top, corner, squared, t)
        top += 2
    return np.inf, hint


@lean_kernel  # (T, 3, 3) f8, TriangleTree, f8, (64,) i8 -> f8
def farthest_sample(triangles, tree, reached, stack):
    """The greatest distance [m] of a corner or centre of the triangles from the mesh, at least `reached`."""
    squared, hint = reached * reached, 0
    for t in range(triangles.shape[0]):
        for c in range(4):
            x, y, z = triangles[t, c % 3, 0], triangles[t, c % 3, 1], triangles[t, c % 3, 2]
            if c == 3:
                x = (x + triangles[t, 1, 0] + triangles[t, 2, 0]) / 3.0
                y = (y + triangles[t, 1, 1] + triangles[t, 2, 1]) / 3.0
                z = (z + triangles[t, 1, 2] + triangles[t, 2, 2]) / 3.0
            found, hint = nearest_triangle(tree, x, y, z, hint, squared, stack)
            squared = max(squared, found)
    return np.sqrt(squared)


@lean_kernel
def directed_bounds(triangles, tree, reached, relative, floor, ceiling, pieces, stack):
    """A lower and a proven upper bound of the greatest distance of points of the triangles (T, 3, 3) from a mesh [m].

    Both bounds differ by `relative` at most, or lie below `floor`; the upper one does not exceed `ceiling` if this
    can be proven. `reached` is a known lower bound: the greater it is, the fewer pieces the proof needs. Scratch:
    pieces (256, 16), stack (64,) i8.
    """
    others, reached, hint, ceiling = tree.triangles, reached * reached, 0, ceiling * ceiling
    proven = reached
    for t in range(triangles.shape[0]):
        for c in range(3):
            for r in range(3):
                pieces[0, 3 * c + r] = triangles[t, c, r]
            x, y, z = triangles[t, c, 0], triangles[t, c, 1], triangles[t, c, 2]
            squared, hint = nearest_triangle(tree, x, y, z, hint, 0.0, stack)
            pieces[0, DISTANCE_COLUMNS + c], pieces[0, NEAREST_COLUMNS + c] = squared, hint
            reached = max(reached, squared)
        pieces[0, DEPTH_COLUMN], top = 0.0, 1
        while top > 0:
            top -= 1
            wanted = max(reached * (1.0 + relative), floor * floor)
            if reached <= ceiling:
                wanted = min(wanted, ceiling)
            bound = piece_bound(pieces, top, others, wanted)
            if bound <= wanted or pieces[top, DEPTH_COLUMN] >= 2 * MAX_CUT_DEPTH or top + 2 > pieces.shape[0]:
                proven = max(proven, bound)
                continue
            corner, x, y, z = cut(pieces, top, others, wanted)
            squared, hint = nearest_triangle(tree, x, y, z, int(pieces[top, NEAREST_COLUMNS + corner]), 0.0, stack)
            set_new_corner(pieces, top, corner, squared, hint)
            reached = max(reached, squared)
            top += 2
    return np.sqrt(reached), np.sqrt(proven)
