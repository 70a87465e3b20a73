"""How much a closed mesh encloses."""

import numpy as np

from kabo.meshes.mesh import Mesh


def volume_of(mesh: Mesh) -> float:
    """The volume that a closed mesh encloses [m3], by tetrahedra from one vertex; below 0 if it is inside out."""
    corners = (mesh.vertices - mesh.vertices[0])[mesh.faces]
    return float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0
