"""The bounded inclusion predicate: whether points are inside an intersection of half-spaces [K Def. 1, Table 4.1]."""

from kabo.arrays import Array


def contains(halfspaces: tuple[Array, Array], points: Array, margin: float) -> bool:
    """Whether all points lie in all half-spaces, at least `margin` deep.

    True is a proof if `margin` exceeds rounding (1e-9 m does, up to a kilometre); at a depth of twice the margin
    or more the answer is True. The hull of points inside is inside too, so for a convex part its vertices do.

    Args:
        halfspaces: normals (H, 3) of length 1 and offsets (H,): n·x <= d. points: (P, 3), same frame. margin: [m].
    """
    normals, offsets = halfspaces
    depth = offsets - points @ normals.T
    return bool((depth >= margin).all())  # NaN is outside
