"""The convex parts that enclose a closed mesh, proven within a tolerance of it: read from a file, or computed once.

Parts are looked up beside the mesh file, then in the cache; otherwise they are computed and kept. Parts from a file
are used once their claims are proven [kabo.geometry.bounding.verified_parts]. Scaled and moved copies of a mesh have
the same shape [kabo.geometry.bounding.shapes], and thus share files.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

from kabo.children import made_in_child, never
from kabo.compilation import cache_folder
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.bounding import stored_parts
from kabo.geometry.bounding.cover_tree import CoverTree, kept_or_made
from kabo.geometry.bounding.decomposition import Request, made_cover
from kabo.geometry.bounding.enclosing_union import Aims, TooManyCells, Undecided
from kabo.geometry.bounding.shapes import Shape, shape_of
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.bounding.verified_parts import are_verified
from kabo.geometry.parts import COLUMNS, Enclosure
from kabo.meshes import Mesh

PART_WORTH = 24.0  # of one part, in corners: about what a part costs when collisions are checked
DIRECT_CELLS = 120  # above which a coarser cover is made, and refined on demand
USUAL_ROOTS = 0.004  # [m] for which a cover is made if a finer one is asked for, of a mesh that is not small
ROOTS_SHARE = 0.02  # of a mesh's diagonal: the same for a small one
COARSEST_ROOTS = 64.0  # a stored cover made for a tolerance coarser by more than this factor is not refined


def enclosing_parts(
    mesh: Mesh,
    tolerance: float,
    *,
    cache: Path | None = None,
    look: Callable[[], None] = never,
    coarse: float | None = None,
) -> Enclosure:
    """Convex parts (V <= 64, 3) [m] whose union covers the solid inside a closed mesh, within `tolerance` of it.

    A proven bound says for each part how far its points may be from the solid; where the tolerance would need very
    many parts, coarser ones come back, of which `Enclosure.finer` refines one. The same triangles and tolerance give
    the same parts, whatever the order of vertices and faces, and whatever the cache holds.

    Args:
        mesh: a closed mesh [m], whose components may overlap or be inside out; parts beside its file are used.
        tolerance: the greatest permitted distance of the finest parts' points from the solid [m].
        cache: the folder of stored parts; None is the folder in kabo's cache.
        look: called repeatedly while parts are computed; an exception ends the computation.
        coarse: a tolerance [m] for the parts that come back, to be refined to `tolerance`; None: 4 mm, or 2 % of the
            diagonal of a small mesh.

    Raises:
        MeshError: the mesh is empty, not finite, open or too fine for the tolerance, or has indices out of range.
        ValueError: the tolerance is not positive.
    """
    if not tolerance > 0.0:
        raise ValueError(f"a tolerance of {tolerance:g} m is no positive length")
    shape, name = shape_of(mesh), name_of(mesh)
    aims = aims_for(shape, tolerance, name)
    folder = cache_folder() / "parts" if cache is None else cache
    cover = None if mesh.path is None else _beside(shape, mesh.path, aims.tolerance)
    if cover is None:
        begun = min(USUAL_ROOTS, ROOTS_SHARE * shape.metres(shape.solid.diagonal)) if coarse is None else coarse
        first = aims_for(shape, max(begun, tolerance), name)
        cover = kept_cover(shape, Request(first, cells=DIRECT_CELLS), folder, name, look)
    return CoverTree.of(shape, cover, aims, name, folder).enclosure()


def aims_for(shape: Shape, tolerance: float, name: str) -> Aims:
    """What parts for collision checks within a tolerance [m] shall be like.

    Raises:
        MeshError: the tolerance is less than what rounding allows.
    """
    length = shape.lengths(tolerance)
    if not length > 0.0:
        said = f"{tolerance:g} m is finer than a mesh of {shape.scale:g} m is known"
        raise MeshError([Diagnostic(name, 1, 1, said, "ask for a larger epsilon")])
    return Aims(length, corners=COLUMNS, strict=True, worth=PART_WORTH)


def name_of(mesh: Mesh) -> str:
    """The name of a mesh in errors: its file, if it has one."""
    return "mesh" if mesh.path is None else str(mesh.path)


def kept_cover(shape: Shape, request: Request, folder: Path, name: str, look: Callable[[], None] = never) -> Cover:
    """The cover of a shape in a folder, or a new one, which is then kept there.

    Raises:
        MeshError: the tolerance cannot be kept.
    """
    asked = stored_parts.METHOD_VERSION, shape.digest, tuple(request.aims), *request[1:]
    key = hashlib.sha256(repr(asked).encode()).hexdigest()

    def made() -> Cover:
        look()
        if look is never:
            return _made(shape, request, name)
        return made_in_child(lambda: _made(shape, request, name), look)

    return kept_or_made(shape, folder / f"{key[:40]}.parts", None, made)


def write_parts(mesh: Mesh, *tolerances: float) -> None:
    """Writes the file `<mesh>.parts` with parts of the mesh for each tolerance [m]; keeps stored ones.

    Raises:
        MeshError: the mesh cannot be enclosed, as in `enclosing_parts`.
        OSError: the folder cannot be written.
        ValueError: the mesh comes from no file.
    """
    if mesh.path is None:
        raise ValueError("a mesh without a file has no place for its parts")
    shape, name, path = shape_of(mesh), name_of(mesh), stored_parts.beside(mesh.path)
    covers = {each.tolerance: each for each in stored_parts.read(path, shape.digest)}
    for tolerance in tolerances:
        aims = aims_for(shape, tolerance, name)
        if aims.tolerance not in covers:
            covers[aims.tolerance] = _made(shape, Request(aims, cells=DIRECT_CELLS), name)
    stored_parts.write(path, shape.digest, list(covers.values()))


def _beside(shape: Shape, source: Path, tolerance: float) -> Cover | None:
    """The proven cover beside a mesh file that suits a tolerance best, or that may be refined to it; None if none."""
    left = stored_parts.read(stored_parts.beside(source), shape.digest)
    while left:
        best = max(left, key=lambda made: (max(made.deviations) <= tolerance, -abs(made.tolerance - tolerance)))
        if _suits(best, tolerance) and are_verified(shape.solid, best):
            return best
        left = [made for made in left if made is not best]
    return None


def _suits(cover: Cover, tolerance: float) -> bool:
    """Whether a cover beside a mesh is near enough for a tolerance, or can be refined to it.

    A finer one serves every coarser tolerance: who put it there chose how near parts shall be, as of hands.
    """
    return max(cover.deviations) <= tolerance or cover.tolerance <= COARSEST_ROOTS * tolerance


def _made(shape: Shape, request: Request, name: str) -> Cover:
    try:
        return made_cover(shape.solid, request)
    except (TooManyCells, Undecided) as error:
        why = (
            "need more than a thousand convex parts"
            if isinstance(error, TooManyCells)
            else "are cut by CoACD into hulls that cannot be widened to cover them"
            if request.engine == "coacd"
            else "have hollows around which no convex parts could be proven"
        )
        within = shape.metres(request.aims.tolerance)
        said = f"is too fine: its {len(shape.solid.faces)} triangles {why} within {within:g} m"
        remedy = "ask for a larger epsilon, or simplify the mesh where it has fine hollows"
        raise MeshError([Diagnostic(name, 1, 1, f"the mesh {said}", remedy)]) from None
