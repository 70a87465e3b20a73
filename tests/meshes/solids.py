"""Small meshes for tests of the meshes room: boxes, put together, turned, cut and spoilt."""

import numpy as np
import trimesh

from kabo.meshes import Mesh
from kabo.meshes.mesh import merged


def box(size: float = 1.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0), *, inverted: bool = False) -> Mesh:
    """A cube with its middle at a point, pointing outwards unless it is inverted."""
    made = trimesh.creation.box(extents=(size, size, size))
    faces = np.array(made.faces, np.int64)
    return Mesh(np.array(made.vertices, np.float64) + np.array(at), faces[:, ::-1] if inverted else faces)


def together(*meshes: Mesh) -> Mesh:
    """Meshes in one, equal vertices merged."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
    return Mesh(*merged(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces)))


def without(mesh: Mesh, *faces: int) -> Mesh:
    """A mesh with some faces missing."""
    return Mesh(mesh.vertices, np.delete(mesh.faces, faces, axis=0))


def volume(mesh: Mesh) -> float:
    """The signed volume [m3], by a library that is not ours."""
    return float(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume)


def side(mesh: Mesh, axis: int, sign: int) -> tuple[int, ...]:
    """The faces of one side of a cube around the origin."""
    corners = mesh.vertices[mesh.faces][:, :, axis] * sign
    return tuple(int(face) for face in np.flatnonzero((corners > 0.0).all(axis=1)))
