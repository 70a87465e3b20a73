"""A loose octree over the boxes of faces, in which inserting and removing a face takes constant time.

Faces may overhang a cell by half of its width, so a face belongs to exactly one cell: the smallest that contains
its centre and is not narrower than the face. If the pool has no node left, or a face lies outside the root, it
belongs to an ancestor instead: queries then visit it more often, but never miss it. A query compares the box
around all faces that entered a subtree since it was last empty, which is tighter than the cell and free of
rounding.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.compilation import lean_kernel

MAX_DEPTH = 16  # of a node below the root
STACK_SIZE = 8 * MAX_DEPTH + 8
_HEAD, _COUNT, _PARENT, _CHILDREN = 0, 1, 2, 3  # columns of nodes
_HALF, _LOW, _HIGH = 3, 4, 7  # columns of cells, after the centre
_NEXT, _PREVIOUS, _NODE = 0, 1, 2  # columns of links


class Octree(NamedTuple):
    """The arrays of a tree, made by `octree_of` and changed by `insert` and `remove` only."""

    nodes: NDArray[np.int32]  # (N, 11): first face or -1, faces in the subtree, parent, eight children or -1
    cells: NDArray[np.float64]  # (N, 10): centre and half-width of the cell, box around the faces in the subtree
    used: NDArray[np.int64]  # (1,): nodes in use
    links: NDArray[np.int32]  # (F, 3): next and previous face of the same node or -1, the node or -1
    boxes: NDArray[np.float64]  # (F, 6): low, then high corner of each face


def octree_of(low: NDArray[np.float64], high: NDArray[np.float64], faces_capacity: int) -> Octree:
    """An empty tree for faces 0 to `faces_capacity` - 1 in the box from `low` to `high`, each (3,) [m].

    Its pool has as many nodes as faces, more than surfaces need (measured: 0.01 to 0.33 nodes for each face).
    """
    capacity = faces_capacity + 64
    nodes = np.full((capacity, 3 + 8), -1, dtype=np.int32)
    nodes[0, _COUNT] = 0
    cells = np.zeros((capacity, 10))
    # Room at the border: an outer mesh sticks out a little.
    cells[0, :_HALF], cells[0, _HALF] = 0.5 * (low + high), 0.55 * float(np.max(high - low))
    return Octree(
        nodes, cells, np.ones(1, dtype=np.int64), np.full((faces_capacity, 3), -1, dtype=np.int32),
        np.zeros((faces_capacity, 6)),
    )  # fmt: skip


@lean_kernel  # i8, i8 -> i8; writes nodes, cells, used
def _child(nodes, cells, used, node, octant):
    """The child of a node, created if there was none; -1 if the pool is used up."""
    child = nodes[node, _CHILDREN + octant]
    if child >= 0 or used[0] >= nodes.shape[0]:
        return child
    child = used[0]
    used[0] += 1
    nodes[node, _CHILDREN + octant] = child
    nodes[child, _COUNT], nodes[child, _PARENT] = 0, node
    half = 0.5 * cells[node, _HALF]
    for k in range(3):
        cells[child, k] = cells[node, k] + (half if (octant >> k) & 1 else -half)
    cells[child, _HALF] = half
    return child


@lean_kernel  # i8, i8 -> writes nodes, cells
def _enter(nodes, cells, boxes, node, face):
    """Counts a face in the subtree of a node and grows its box; the box of an empty subtree is set to the face's."""
    empty = nodes[node, _COUNT] == 0
    nodes[node, _COUNT] += 1
    for k in range(3):
        low, high = boxes[face, k], boxes[face, 3 + k]
        cells[node, _LOW + k] = low if empty else min(low, cells[node, _LOW + k])
        cells[node, _HIGH + k] = high if empty else max(high, cells[node, _HIGH + k])


@lean_kernel  # Octree, i8, f8 x 6 [m]
def insert(tree, face, low_x, low_y, low_z, high_x, high_y, high_z):
    """Inserts a face that is not in the tree, with its box."""
    nodes, cells, used, links, boxes = tree.nodes, tree.cells, tree.used, tree.links, tree.boxes
    boxes[face, 0], boxes[face, 1], boxes[face, 2] = low_x, low_y, low_z
    boxes[face, 3], boxes[face, 4], boxes[face, 5] = high_x, high_y, high_z
    x, y, z = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 0.5 * (low_z + high_z)
    extent = 0.5 * max(high_x - low_x, high_y - low_y, high_z - low_z)
    node = 0
    _enter(nodes, cells, boxes, node, face)
    far = max(abs(x - cells[0, 0]), abs(y - cells[0, 1]), abs(z - cells[0, 2]))
    if far <= cells[0, _HALF]:
        for _ in range(MAX_DEPTH):
            if not extent <= 0.5 * cells[node, _HALF]:
                break
            octant = (x > cells[node, 0]) + 2 * (y > cells[node, 1]) + 4 * (z > cells[node, 2])
            child = _child(nodes, cells, used, node, octant)
            if child < 0:
                break
            node = child
            _enter(nodes, cells, boxes, node, face)
    first = nodes[node, _HEAD]
    links[face, _NEXT], links[face, _PREVIOUS], links[face, _NODE] = first, -1, node
    if first >= 0:
        links[first, _PREVIOUS] = face
    nodes[node, _HEAD] = face


@lean_kernel  # Octree, i8
def remove(tree, face):
    """Removes a face from the tree, if the tree contains this face."""
    nodes, links = tree.nodes, tree.links
    node, following, previous = links[face, _NODE], links[face, _NEXT], links[face, _PREVIOUS]
    if node < 0:
        return
    if previous >= 0:
        links[previous, _NEXT] = following
    else:
        nodes[node, _HEAD] = following
    if following >= 0:
        links[following, _PREVIOUS] = previous
    links[face, _NODE] = -1
    while node >= 0:
        nodes[node, _COUNT] -= 1
        node = nodes[node, _PARENT]


@lean_kernel  # Octree, f8 x 6 [m], (STACK_SIZE,) i8, (F,) i8 -> i8
def query(tree, low_x, low_y, low_z, high_x, high_y, high_z, stack, found):
    """Writes the faces whose boxes meet or touch a box; returns their number.

    The order of the faces depends on the order of insertions and removals. If `found` is too short, it is filled
    only.
    """
    nodes, cells, links, boxes = tree.nodes, tree.cells, tree.links, tree.boxes
    count, top = 0, 1
    stack[0] = 0
    while top > 0:
        top -= 1
        node = stack[top]
        face = nodes[node, _HEAD]
        while face >= 0:
            meets = (boxes[face, 0] <= high_x) & (boxes[face, 3] >= low_x)
            meets &= (boxes[face, 1] <= high_y) & (boxes[face, 4] >= low_y)
            meets &= (boxes[face, 2] <= high_z) & (boxes[face, 5] >= low_z)
            if meets:
                if count < found.shape[0]:
                    found[count] = face
                count += 1
            face = links[face, _NEXT]
        for octant in range(8):
            child = nodes[node, _CHILDREN + octant]
            if child < 0 or nodes[child, _COUNT] == 0:
                continue
            near = (cells[child, _LOW] <= high_x) & (cells[child, _HIGH] >= low_x)
            near &= (cells[child, _LOW + 1] <= high_y) & (cells[child, _HIGH + 1] >= low_y)
            near &= (cells[child, _LOW + 2] <= high_z) & (cells[child, _HIGH + 2] >= low_z)
            if near:
                stack[top] = child
                top += 1
    return count
