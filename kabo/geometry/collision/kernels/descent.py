"""Descents in trees of parts: a pair that is not proven apart is replaced by pairs with the children of one part.

Which part is divided depends on sizes and on whether a part *has* children, known or not; so answers never depend on
which children are known already.
"""

from kabo.compilation import leaf_kernel, lean_kernel
from kabo.geometry.collision.kernels.bundles import CHILD_COUNT, FIRST_CHILD, FIRST_OPEN, OPEN

FINAL = -1  # neither part has children: what was found of them decides


@leaf_kernel  # Tree, i8, i8 -> bool
def is_final(tree, a, b):
    """Whether neither of two parts has children."""
    return (tree.children[a, CHILD_COUNT] == 0) & (tree.children[b, CHILD_COUNT] == 0)


@lean_kernel  # Tree, i8, i8 -> i8
def divided(tree, a, b):
    """Which of two parts is replaced by its children: the larger one of those that have any; FINAL if none has."""
    if is_final(tree, a, b):
        return FINAL
    first = tree.children[b, CHILD_COUNT] == 0 or tree.diameters[a] >= tree.diameters[b]
    return a if first and tree.children[a, CHILD_COUNT] != 0 else b


@lean_kernel  # Tree, i8, i8, i8 -> i8
def put_children(tree, a, b, top):
    """Puts the pairs with the children of one part on the stack, the first on top; returns the height of the stack.

    FINAL if neither part has children, FIRST_OPEN - p if the children of part p are not known yet.
    """
    part = divided(tree, a, b)
    if part < 0:
        return FINAL
    count, first = tree.children[part, CHILD_COUNT], tree.children[part, FIRST_CHILD]
    if count == OPEN:
        return FIRST_OPEN - part
    for k in range(count - 1, -1, -1):
        tree.stack[top, 0], tree.stack[top, 1] = a, b
        tree.stack[top, 0 if part == a else 1] = first + k
        top += 1
    return top
