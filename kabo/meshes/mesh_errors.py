"""Errors about unusable meshes, and the minimal requirement on every mesh: triangles on finite vertices."""

import numpy as np

from kabo.displays import counted
from kabo.errors import Diagnostic, MeshError
from kabo.language.formulas import Place
from kabo.meshes.mesh import Mesh

MAX_COORDINATE = 1e9  # metres: beyond, squares of coordinates lose their meaning long before they overflow
EXPORT_HINT = "export the mesh again"
FETCH_HINT = "fetch the mesh itself: git lfs pull"


def refuse(place: Place | None, message: str, hint: str | None = None) -> MeshError:
    """The error for a mesh that cannot be used, at the place in the file that names it."""
    at = place or Place("scene", 1, 1)
    return MeshError([Diagnostic(at.file, at.line, at.column, message, hint, at.length)])


def unusable(mesh: Mesh, place: Place | None, said: str, hint: str | None = None) -> MeshError:
    """The error whose message is a mesh's name and the statement `said`: `mesh file "cup.stl" is a single triangle`."""
    named = f'mesh file "{mesh.path.name}"' if mesh.path is not None else "the mesh"
    return refuse(place or Place(str(mesh.path or "mesh"), 1, 1), f"{named} {said}", hint)


def require_numbers(mesh: Mesh, place: Place | None = None) -> None:
    """Raises an error unless a mesh has triangles, all on finite vertices that exist.

    Args:
        mesh: vertices in metres. place: the place in a file that names the mesh; by default the mesh file itself.

    Raises:
        MeshError: one sentence with the count.
    """
    vertices, faces = mesh.vertices, mesh.faces
    if not len(vertices) or not len(faces):
        size = f"{counted(len(vertices), 'vertex', 'vertices')} and {counted(len(faces), 'triangle')}"
        raise unusable(mesh, place, f"has {size}, which enclose nothing", EXPORT_HINT)
    wrong = int((~np.isfinite(vertices)).any(axis=1).sum())
    if wrong:
        said = f"cannot be used: {wrong} of {len(vertices)} vertices are not finite"
        raise unusable(mesh, place, said, EXPORT_HINT)
    absent = int(((faces < 0) | (faces >= len(vertices))).any(axis=1).sum())
    if absent:
        said = f"cannot be used: {absent} of {len(faces)} triangles name a vertex that is not there"
        raise unusable(mesh, place, said, EXPORT_HINT)
    farthest = float(np.abs(vertices).max())
    if farthest > MAX_COORDINATE:
        said = f"has vertices up to {farthest:.3g} m from the origin"
        raise unusable(mesh, place, said, "scale it to metres and move it to its origin")
