"""The convex parts that enclose a closed mesh, proven within a tolerance of it: read from a file, or computed once.

Parts are looked up beside the mesh file, then in the cache; otherwise they are computed by
`kabo.geometry.bounding.decomposition` and stored. Parts from a file are used once their claims are proven
[kabo.geometry.bounding.verified_parts]. If a scene scales a mesh, parts beside its file are scaled too: those with
deviation d of a mesh are parts with deviation s·d of the mesh scaled by s.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from kabo.arrays import Array, Integers
from kabo.children import never
from kabo.compilation import cache_folder
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.bounding import stored_parts
from kabo.geometry.bounding.pieces import parts_of_pieces
from kabo.geometry.bounding.verified_parts import are_verified, record_proof
from kabo.geometry.parts import Enclosure
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh, load_mesh, outwards, require_closed

# [m] per unit of a mesh file, for which parts beside it were probably made.
COMMON_SCALES = (1.0, 1e-3, 1e-2, 0.0254)


def enclosing_parts(
    vertices: Array,
    faces: Integers,
    tolerance: float,
    *,
    source: Path | None = None,
    cache: Path | None = None,
    seed: int = 0,
    look: Callable[[], None] = never,
) -> Enclosure:
    """Convex parts (V <= 24, 3) whose union covers the solid inside a closed mesh.

    Every point of the parts lies within `deviation` <= `tolerance` of the solid, which is proven, not sampled. The
    same mesh, tolerance and seed give the same parts, whatever the order of vertices and faces.

    Args:
        vertices: the vertices (V, 3) of the mesh [m].
        faces: the vertex indices (F, 3) of its triangles.
        tolerance: the greatest permitted deviation of the parts from the solid [m].
        source: the mesh file; parts stored beside it are used if they were made for this mesh.
        cache: the folder of stored parts; None is the folder in kabo's cache.
        seed: the seed of CoACD.
        look: called repeatedly while parts are computed; an exception ends the computation.

    Raises:
        MeshError: the mesh is empty, not finite, open or too fine for the tolerance, or has indices out of range.
    """
    name = "mesh" if source is None else str(source)
    vertices, faces = _usable(np.asarray(vertices, np.float64), np.asarray(faces, np.int64), source)
    solid, digest = Solid(vertices, faces), stored_parts.digest_of(vertices, faces)
    if source is not None:
        beside = stored_parts.read(stored_parts.beside(source), digest) or _scaled(solid, source)
        stored = _verified(solid, beside, tolerance)
        if stored is not None:
            return stored
    kept = (cache_folder() / "parts" if cache is None else cache) / f"{digest[:32]}-{tolerance:.9g}-{seed}.parts"
    found = _verified(solid, stored_parts.read(kept, digest), tolerance)
    if found is not None:
        return found
    look()
    made = _made(solid, tolerance, seed, name, look=look)
    with suppress(OSError):  # a read-only cache costs time, never an answer
        stored_parts.write(kept, digest, {float(f"{tolerance:.9g}"): made})
    return made


def _verified(solid: Solid, stored: dict[float, Enclosure], tolerance: float) -> Enclosure | None:
    """The best fitting of stored enclosures whose claims are proven; None if there is none."""
    left = dict(stored)
    while (best := stored_parts.fitting(left, tolerance)) is not None:
        if are_verified(solid, best.parts, [best.deviation] * len(best.parts)):
            return best
        left = {key: made for key, made in left.items() if made is not best}
    return None


def _scaled(solid: Solid, source: Path) -> dict[float, Enclosure]:
    """The enclosures beside a mesh file, scaled along each axis like the mesh; none if the mesh is no scaled copy."""
    if not stored_parts.beside(source).is_file():
        return {}
    for unit in COMMON_SCALES:
        try:
            original = load_mesh(source, unit)
            vertices, faces = _usable(original.vertices, original.faces, source)
        except MeshError:
            return {}
        stored = stored_parts.read(stored_parts.beside(source), stored_parts.digest_of(vertices, faces))
        sides = np.ptp(vertices, axis=0)
        if stored and (sides > 0.0).all():
            factors = np.ptp(solid.vertices, axis=0) / sides
            grown = float(factors.max()) * (1.0 + 1e-9)
            return {
                grown * key: Enclosure(tuple(part * factors for part in made.parts), grown * made.deviation)
                for key, made in stored.items()
            }
    return {}


def write_parts(
    mesh: Path, vertices: Array, faces: Integers, *tolerances: float, pieces: Sequence[Array] = ()
) -> None:
    """Writes the file `<mesh>.parts` with an enclosure of the mesh for each tolerance [m]; keeps stored enclosures.

    Args:
        mesh: the path of the mesh file.
        vertices, faces: the mesh as loaded from this file.
        pieces: convex sets (P, 3) [m] that together contain the mesh; used only if this can be proven.

    Raises:
        MeshError: the mesh cannot be enclosed, as in `enclosing_parts`.
        OSError: the folder cannot be written.
    """
    vertices, faces = _usable(np.asarray(vertices, np.float64), np.asarray(faces, np.int64), mesh)
    solid, digest = Solid(vertices, faces), stored_parts.digest_of(vertices, faces)
    enclosures = stored_parts.read(stored_parts.beside(mesh), digest)
    for tolerance in tolerances:
        if tolerance not in enclosures:
            enclosures[float(tolerance)] = _made(solid, tolerance, 0, str(mesh), pieces)
    stored_parts.write(stored_parts.beside(mesh), digest, enclosures)


def _made(
    solid: Solid,
    tolerance: float,
    seed: int,
    name: str,
    pieces: Sequence[Array] = (),
    look: Callable[[], None] = never,
) -> Enclosure:
    # Loaded here since stored parts, which most runs use, need no search for cuts (0.1 s).
    from kabo.geometry.bounding.decomposition import ToleranceTooFine, decompose, proven_deviation

    turned, done = outwards(Mesh(solid.vertices, solid.faces))
    if done is not None:  # inside out it is the same solid, but CoACD makes nothing of it
        solid = Solid(turned.vertices, turned.faces)
    try:
        parts = (parts_of_pieces(solid, pieces, tolerance) if pieces else None) or decompose(
            solid, tolerance, seed, look
        )
    except ToleranceTooFine as error:
        raise _unusable(
            name,
            f"a mesh of {len(solid.faces)} triangles needs more than {error} convex parts "
            f"to be enclosed within {tolerance:g} m",
            "ask for a larger epsilon, or simplify the mesh where it has fine hollows",
        ) from None
    made = Enclosure(tuple(parts), proven_deviation(solid, parts, tolerance))
    record_proof(solid, made.parts, [made.deviation] * len(made.parts))
    return made


def _usable(vertices: Array, faces: Integers, source: Path | None) -> tuple[Array, Integers]:
    """The canonical form of a mesh; MeshError unless it is closed."""
    require_closed(Mesh(vertices, faces, source))
    return stored_parts.canonical(vertices, faces)


def _unusable(name: str, message: str, hint: str | None = None) -> MeshError:
    return MeshError([Diagnostic(name, 1, 1, message, hint)])
