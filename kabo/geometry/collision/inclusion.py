"""The bounded inclusion predicate: whether points are inside an intersection of half-spaces [K Def. 1, Table 4.1]."""

from kabo.arrays import Array


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
