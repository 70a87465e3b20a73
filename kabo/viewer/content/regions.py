"""The mesh of a region: the convex volume that its half-spaces leave."""

import numpy as np

from kabo.meshes import Mesh, hull_of
from kabo.scene import Region


def region_mesh(region: Region) -> Mesh:
    """The mesh of a region, in its own frame."""
    from scipy.spatial import HalfspaceIntersection  # slow to import

    half_spaces = np.c_[region.normals, -region.offsets]
    corners = HalfspaceIntersection(half_spaces, _inside(region)).intersections
    return hull_of(Mesh(np.ascontiguousarray(corners), np.zeros((0, 3), dtype=np.int64)))


def _inside(region: Region) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """The point of a region that is deepest inside."""
    from scipy.optimize import linprog

    lengths = np.linalg.norm(region.normals, axis=1)
    A = np.c_[region.normals, lengths]
    done = linprog([0.0, 0.0, 0.0, -1.0], A_ub=A, b_ub=region.offsets, bounds=[(None, None)] * 3 + [(0.0, None)])
    return np.asarray(done.x[:3], dtype=np.float64)
