"""The bounded inclusion predicate: whether points are inside an intersection of half-spaces [K Def. 1, Table 4.1]."""

from kabo.arrays import Array
from kabo.geometry.budget import Budget
from kabo.geometry.collision.part_trees import Cover
from kabo.geometry.parts import Enclosure


def contains(halfspaces: tuple[Array, Array], points: Array, margin: float) -> bool:
    """Whether all points lie in all half-spaces, at least `margin` deep.

    True is a proof if `margin` exceeds rounding errors (1e-9 m suffices up to a kilometre). If all points are at
    least twice the margin deep, the answer is True. For a convex part it suffices to test its vertices.

    Args:
        halfspaces: normals n (H, 3) of length 1 and offsets d (H,) of the half-spaces n·x <= d.
        points: points (P, 3) in the same frame [m].
        margin: the required depth [m].
    """
    normals, offsets = halfspaces
    depth = offsets - points @ normals.T
    return bool((depth >= margin).all())  # NaN is outside


def lies_within(halfspaces: tuple[Array, Array], enclosure: Enclosure, budget: Budget) -> bool:
    """Whether a body is proven to lie in all half-spaces; parts that reach out are divided where they have children.

    Args:
        halfspaces: as in `contains`, in the body's frame.
        enclosure: the body's parts.
        budget: the shares of epsilon: parts that deviate by more than its geometry do not decide.
    """
    normals, offsets = halfspaces
    cover, place = Cover.of(enclosure), 0
    while place < len(cover.nodes):
        rounding = cover.enclosure.rounding_of(place)
        if contains((normals, offsets - rounding.reach(normals)), cover.enclosure.parts[place], budget.numeric):
            place += 1
        elif cover.is_final(place, budget.geometry):
            return False
        else:
            cover = cover.divided(place)
    return True
