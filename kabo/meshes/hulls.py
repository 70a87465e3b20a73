"""Convex hulls as closed triangle meshes whose faces point outwards."""

import numpy as np

from kabo.errors import KaboError
from kabo.meshes.mesh import Faces, Mesh, Vertices
from kabo.meshes.mesh_errors import unusable

THICKNESS_HINT = "give it a thickness, or a primitive shape"


def hull_of(mesh: Mesh) -> Mesh:
    """The convex hull of a mesh: always closed, with no `path`.

    Raises:
        MeshError: its vertices lie in a plane.
    """
    try:
        faces = hull_faces(mesh.vertices)
    except KaboError:
        raise unusable(mesh, None, "is flat: it has no convex hull with an inside", THICKNESS_HINT) from None
    used, faces = np.unique(faces, return_inverse=True)
    return Mesh(mesh.vertices[used], faces.reshape(-1, 3))


def hull_faces(vertices: Vertices) -> Faces:
    """The triangles (F, 3) of the convex hull of vertices (V, 3): indices of these vertices, facing outwards.

    Raises:
        KaboError: the vertices lie in a plane: no solid.
    """
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError) as error:
        raise KaboError(f"{len(vertices)} vertices have no hull: {' '.join(str(error).split())[:160]}") from None
    faces = hull.simplices.astype(np.int64)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0.0
    outwards: Faces = np.where(inwards[:, None], faces[:, ::-1], faces)
    return outwards
