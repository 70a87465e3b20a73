"""The pieces of a mesh that is not closed: closed ones that are far from convex, and the rest.

A file of a robot's link often holds several bodies, such as a housing with an open bottom on a frame that is closed. One
hull around all of them fills what lies between.
"""

import numpy as np

from kabo.errors import MeshError
from kabo.meshes.hulls import hull_of
from kabo.meshes.mesh import Faces, Mesh, Vertices, merged
from kabo.meshes.requirements import require_solid
from kabo.meshes.soundness import closed_components
from kabo.meshes.topology import components, edges_of
from kabo.meshes.volumes import volume_of

FILLED = 0.8  # of the volume of its hull that a piece fills which gains little as it is
LEAST_SHARE = 0.05  # of the volume of the hull of all: pieces with smaller hulls, and smaller gains, do not matter
MAX_FACES = 20_000  # of a piece; finer ones take long to cover by convex parts


def hollow_pieces(mesh: Mesh) -> tuple[list[Mesh], Mesh | None]:
    """The closed pieces of a mesh that fill little of their own hulls, the greatest first, and all the rest as one mesh.

    Pieces share no vertex; vertices that are equal count as one. A piece is left in the rest if it is no solid, points
    inwards, is small beside the whole, or has very many faces; and so are all, if the whole's hull is hardly greater than
    what they fill and the hull of the rest, or if triangles that are only lines may lie between them. The rest is None if
    nothing is left.
    """
    vertices, faces = merged(mesh.vertices, mesh.faces)
    edges = edges_of(faces)
    component = components(edges, len(faces))
    closed = np.flatnonzero(closed_components(edges, component)) if len(faces) else ()
    if not len(closed) or len(faces) < len(mesh.faces):  # the hull of all encloses such lines, too
        return [], mesh
    whole = volume_of(hull_of(mesh))
    pieces = {number: _of_faces(vertices, faces[component == number]) for number in map(int, closed)}
    sizes = {number: _hollow(piece, LEAST_SHARE * whole) for number, piece in pieces.items()}
    kept = sorted((number for number in sizes if sizes[number]), key=lambda number: (-sizes[number], number))
    left = ~np.isin(component, kept)
    rest = _of_faces(vertices, faces[left]) if left.any() else None
    filled = sum(volume_of(pieces[number]) for number in kept) + (
        0.0 if rest is None else volume_of(hull_of(rest))
    )
    if filled > (1.0 - LEAST_SHARE) * whole:
        return [], mesh
    return [pieces[number] for number in kept], rest


def _hollow(piece: Mesh, least: float) -> float:
    """The volume of a piece's hull [m3]; 0 if the piece is to be left in the rest."""
    volume = volume_of(piece)
    if volume <= 0.0 or len(piece.faces) > MAX_FACES:
        return 0.0
    try:
        around = volume_of(hull_of(piece))
        if around < least or volume > FILLED * around:
            return 0.0
        require_solid(piece)
    except MeshError:
        return 0.0
    return around


def _of_faces(vertices: Vertices, faces: Faces) -> Mesh:
    """The mesh of some faces, with the vertices that they use."""
    used, own = np.unique(faces, return_inverse=True)
    return Mesh(np.ascontiguousarray(vertices[used]), own.reshape(-1, 3))
