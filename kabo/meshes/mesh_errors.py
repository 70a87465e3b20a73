"""Errors about unusable meshes, and the minimal requirement on every mesh: triangles on finite vertices."""

from typing import Any

import numpy as np

from kabo.displays import counted
from kabo.errors import Diagnostic, MeshError
from kabo.given import refuse as refuse_argument
from kabo.given import require_methods, shown
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


def mesh_of(given: Any) -> Mesh:
    """The mesh of whatever has `vertices` (V, 3) [m] and `faces` (F, 3), as arrays or lists.

    Raises:
        ArgumentError: it has none, or they are no arrays of numbers of this shape.
    """
    require_methods("mesh", given, "vertices", "faces")
    return Mesh(
        _rows("vertices", given.vertices, np.float64),
        _rows("faces", given.faces, np.int64),
        getattr(given, "path", None),
    )


def _rows(name: str, given: object, kind: type[np.float64] | type[np.int64]) -> Any:
    """The array (N, 3) that is given, of any shape if it is empty; floats that are whole numbers count as such."""
    try:
        found = np.asarray(given)
        fits = not found.size or (found.ndim == 2 and found.shape[1] == 3 and found.dtype.kind in "iuf")
    except ValueError:  # rows of different lengths
        fits = False
    if fits:
        with np.errstate(invalid="ignore"):  # what is not finite is no whole number
            rows = found.astype(kind, copy=False)
        if kind is np.float64 or (rows == found).all():
            return rows if rows.size else rows.reshape(0, 3)
    what = "numbers" if kind is np.float64 else "whole numbers"
    refuse_argument("mesh", f"mesh.{name} must be an array of {what} with three columns, not {shown(given)}")


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
