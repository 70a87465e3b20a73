"""A proven interval of the Hausdorff distance of two triangle meshes, by branch and bound over their triangles."""

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.bounding.kernels.triangle_bounds import directed_bounds, farthest_sample
from kabo.geometry.triangles.triangle_trees import tree_of


def hausdorff_bound(
    first_vertices: Array,
    first_faces: Integers,
    second_vertices: Array,
    second_faces: Integers,
    rel: float = 0.01,
    *,
    ceiling: float = np.inf,
) -> tuple[float, float]:
    """Lower and upper bound of the Hausdorff distance of two surfaces [m]; the lower one is attained at a point.

    Args:
        first_vertices, second_vertices: (V, 3) [m]. first_faces, second_faces: (F, 3), at least one each.
        rel: the desired relative gap of the bounds; an upper bound below 1e-4 of the diagonal is not improved.
        ceiling: the greatest value of the upper bound [m], if the distance can be proven not to exceed it.
    """
    first, second = tree_of(first_vertices, first_faces), tree_of(second_vertices, second_faces)
    floor = 1e-4 * float(np.linalg.norm(np.ptp(first_vertices, axis=0)))
    both = (first.triangles, second), (second.triangles, first)
    pieces, stack = np.empty((256, 16)), np.empty(64, np.int64)
    reached = proven = 0.0
    # The farthest samples come first: proving nearby parts to within a fraction of their own distance cuts wide fans
    # into as many pieces as the square of their triangles.
    for triangles, tree in both:
        reached = farthest_sample(triangles, tree, reached, stack)
    for triangles, tree in both:
        reached, high = directed_bounds(triangles, tree, reached, 2.0 * rel, floor, ceiling, pieces, stack)
        proven = max(proven, high)
    return reached, proven
