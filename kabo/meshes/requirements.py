"""Requirements on meshes before geometry relies on them; errors are one sentence with the counts and the remedy.

Two levels: `require_closed` is what winding numbers need; `require_solid` is what edge contraction needs: every
edge between two faces that are oriented alike, every component the right way round.
"""

from collections.abc import Iterable
from typing import Literal

from kabo.displays import counted
from kabo.errors import Diagnostic
from kabo.language.formulas import Place
from kabo.meshes.counts import listed
from kabo.meshes.mesh import Mesh, merged
from kabo.meshes.mesh_errors import EXPORT_HINT, require_numbers, unusable
from kabo.meshes.soundness import Soundness, examine
from kabo.meshes.topology import edges_of

LARGE_EXTENT = 5.0  # [m]: parts and robots are smaller, unless given in millimetres
MIN_EXTENT = 1e-9  # [m]: a smaller mesh is a point, or given in the wrong unit
_CLOSE_HINT = "close it, e.g. in MeshLab (Filters, Remeshing, Close Holes)"
_CLEAN_HINT = "remove what is left by hand, e.g. in MeshLab (Filters, Cleaning and Repairing)"
_REPAIR_HINT = "try --repair (in Python: load_mesh(…, repair=True))"


def require_closed(mesh: Mesh, place: Place | None = None) -> None:
    """Raises an error unless a mesh is closed: each edge is passed equally often in both directions.

    Equal vertices count as one.

    Args:
        mesh: vertices in metres. place: the place in a file that names the mesh; by default the mesh file itself.

    Raises:
        MeshError: the mesh is empty, not finite or open, or its faces name missing vertices.
    """
    require_numbers(mesh, place)
    _, faces = merged(mesh.vertices, mesh.faces)
    if not len(faces):
        raise unusable(mesh, place, "has degenerate triangles only and encloses nothing", EXPORT_HINT)
    edges = edges_of(faces)
    open_edges = int((edges.balance != 0).sum())
    if open_edges:
        said = f"is not closed: {open_edges} of its {len(edges.ends)} edges do not join two triangles"
        remedy = "close its holes and unify its normals, e.g. with MeshLab, or give a primitive shape"
        remedy += "; or name the link in the robot's `hulls`"
        raise unusable(mesh, place, f"{said} that are turned the same way", remedy)


def require_solid(
    mesh: Mesh,
    *,
    borders: Literal["refuse", "keep"] = "refuse",
    place: Place | None = None,
    repair: bool = False,
) -> None:
    """Raises an error unless a mesh bounds solids: closed, a manifold, each component the right way round.

    Args:
        mesh: vertices in metres.
        borders: "keep" accepts open borders.
        place: the place in a file that names the mesh; by default the mesh file itself.
        repair: whether the safe repairs were tried already; then the remedy does not suggest them.

    Raises:
        MeshError: one sentence with all counts, and the remedy.
    """
    require_numbers(mesh, place)
    found = examine(mesh)
    if found.faces == 1:
        raise unusable(mesh, place, "is a single triangle, which encloses nothing", _CLOSE_HINT)
    if found.extent < MIN_EXTENT:
        raise unusable(mesh, place, f"is only {found.extent:.3g} m large", "scale it to metres")
    faults = list(_faults(found, borders))
    if faults:
        raise unusable(mesh, place, f"is no solid: it has {listed(faults)}", _remedy(found, borders, repair))


def units_warning(
    mesh: Mesh,
    place: Place | None = None,
    *,
    named: str | None = None,
    fix: str = "then scale it: `scale: 0.001` in a scene, `--scale 0.001` in a command",
) -> Diagnostic | None:
    """A warning, with the fix, if a mesh is so large that it may be given in millimetres; else None.

    Args:
        mesh: vertices in metres.
        place: the place in a file that names the mesh.
        named: the name of the mesh in the message.
        fix: the remedy at the end of the message.
    """
    low, high = mesh.bounds
    extent = float((high - low).max())
    if extent <= LARGE_EXTENT:
        return None
    named = named or (f'mesh file "{mesh.path.name}"' if mesh.path is not None else "the mesh")
    said = f"{named} is {extent:.4g} m large: is it given in millimetres?"
    at = place or Place(str(mesh.path or "mesh"), 1, 1)
    return Diagnostic(at.file, at.line, at.column, said, fix, at.length, "warning")


def _faults(found: Soundness, borders: str) -> Iterable[str]:
    """The faults with their counts, the plainest first, each as the end of a sentence that begins with `it has`."""
    if found.repeated:
        yield f"{counted(found.repeated, 'triangle')} naming a vertex twice"
    if found.zero_area:
        yield f"{counted(found.zero_area, 'triangle')} without area"
    if found.duplicates:
        yield f"{counted(found.duplicates, 'triangle')} repeating another one"
    if found.borders and borders == "refuse":
        yield f"{counted(found.borders, 'open edge')} around {counted(found.holes, 'hole')}"
    if found.crowded:
        yield f"{counted(found.crowded, 'edge')} of more than two triangles"
    if found.turned:
        yield f"{counted(found.turned, 'edge')} between triangles that are turned against each other"
    if found.pinched:
        yield f"{counted(found.pinched, 'vertex', 'vertices')} in which surfaces only touch"
    if found.inside_out:
        yield f"{counted(found.inside_out, 'component')} of {found.components} turned inside out"


def _remedy(found: Soundness, borders: str, repair: bool) -> str:
    if repair:
        further = _CLOSE_HINT if found.borders else _CLEAN_HINT
        return f"all that is safe to repair has been repaired; {further}"
    if found.borders and borders == "refuse":
        return f"{_CLOSE_HINT}, or {_REPAIR_HINT}, which fills holes of three or four edges"
    return _REPAIR_HINT
