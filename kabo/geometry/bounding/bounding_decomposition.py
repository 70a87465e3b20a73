"""Bounding convex decompositions [K Def. 3]: convex parts proven to cover a solid and to stay within epsilon of it.

Covering holds by construction and is proven cell by cell (`enclosing_union`); the distance of every point of every
part to the solid is proven by tetrahedra (`nearness`). A decomposition is computed once and then read from the
cache.
"""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Protocol

import numpy as np

from kabo.arrays import Array, Integers
from kabo.compilation import cache_folder
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.bounding import stored_decompositions, stored_parts
from kabo.geometry.bounding.bounding_mesh import bounding_mesh
from kabo.geometry.bounding.enclosing_union import (
    TooManyCells,
    Undecided,
    Union,
    cells_of,
    enclosing_union,
    proven_union,
)
from kabo.geometry.bounding.verified_parts import are_verified, record_proof
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh, require_closed

COARSEN_ABOVE_TRIANGLES = 5_000  # above which a coarser bounding mesh is decomposed instead
COARSE_MESH_SHARE = 0.1  # of epsilon: how far that bounding mesh may deviate
Made = tuple[tuple[Array, ...], tuple[float, ...]]  # parts and their deviations
TIGHTER_SHARES = (0.4, 0.55, 0.7, 0.85)  # of epsilon: tried in turn to reach a target number of parts


class Triangles(Protocol):
    """The interface of a triangle mesh: vertices (V, 3) [m] and faces (F, 3)."""

    @property
    def vertices(self) -> Array:
        """The vertices (V, 3) [m]."""

    @property
    def faces(self) -> Integers:
        """The vertex indices (F, 3) of all faces."""


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Convex parts whose union contains a solid, and whose points all lie near this solid."""

    parts: tuple[Array, ...]  # the corners of each, (V, 3) [m]
    deviations: tuple[float, ...]  # of each part: a proven bound of its greatest distance from the solid [m]
    epsilon: float  # [m]
    seconds: float  # spent on computing the parts, or on reading them

    @property
    def hausdorff_upper_bound(self) -> float:
        """A proven upper bound, at most `epsilon`, of the Hausdorff distance between union and solid [m]."""
        return max(self.deviations)

    @property
    def worst(self) -> int:
        """The index of the part with the greatest deviation."""
        return int(np.argmax(self.deviations))


def bounding_decomposition(
    mesh: Triangles,
    epsilon: float,
    *,
    parts: int | None = None,
    vertices_per_part: int | None = None,
    seed: int = 0,
    cache: Path | None = None,
) -> Decomposition:
    """Few convex parts with few vertices that cover the solid inside a closed mesh, within `epsilon` of it [K 4.4].

    The same triangles, parameters and seed give the same parts, whatever the order of vertices and faces.

    Args:
        mesh: a closed mesh with vertices (V, 3) [m], whose components may overlap.
        epsilon: the greatest permitted distance of any point of the parts from the solid [m].
        parts: the desired number of parts; more are made if epsilon requires it.
        vertices_per_part: the desired greatest number of vertices of a part; exceeded where it cannot be kept.
        seed: a part of the cache's key; the parts do not depend on it, since the method uses no random numbers.
        cache: the folder of stored decompositions; None is the folder in kabo's cache.

    Raises:
        ValueError: epsilon is not a positive length, or a desired number is not positive.
        MeshError: the mesh is empty, not finite, open or too fine for epsilon, or has indices out of range.
    """
    began = perf_counter()
    if not (np.isfinite(epsilon) and epsilon > 0.0):
        raise ValueError(f"epsilon is {epsilon:g} m, which is not a positive length")
    if (parts is not None and parts < 1) or (vertices_per_part is not None and vertices_per_part < 4):
        raise ValueError("a decomposition has at least one part, and a part at least four vertices")
    folder = cache_folder() / "decompositions" if cache is None else cache
    vertices = np.asarray(mesh.vertices, np.float64)
    faces = np.asarray(mesh.faces, np.int64)
    parameters = (float(epsilon), parts, vertices_per_part, seed)
    path = getattr(mesh, "path", None)
    require_closed(Mesh(vertices, faces, path))
    given = stored_decompositions.name_of(vertices, faces, parameters)
    found = _verified(vertices, faces, epsilon, stored_decompositions.read(folder, given))
    if found is None:
        vertices, faces = stored_parts.canonical(vertices, faces)
        canonical = stored_decompositions.name_of(vertices, faces, parameters)
        found = _verified(vertices, faces, epsilon, stored_decompositions.read(folder, canonical))
        if found is None:
            found = _made(vertices, faces, epsilon, parts, vertices_per_part, path)
        with suppress(OSError):  # a read-only cache costs time, never an answer
            for name in {given, canonical}:
                stored_decompositions.write(folder, name, *found)
    return Decomposition(*found, epsilon, perf_counter() - began)


def _verified(vertices: Array, faces: Integers, epsilon: float, found: Made | None) -> Made | None:
    """The parts found in the cache, if their claims are proven; else None."""
    if found is None or max(found[1]) > epsilon:
        return None
    return found if are_verified(Solid(*stored_parts.canonical(vertices, faces)), *found) else None


def _made(
    vertices: Array,
    faces: Integers,
    epsilon: float,
    parts: int | None,
    vertices_per_part: int | None,
    path: Path | None,
) -> Made:
    solid = Solid(vertices, faces)
    coarse, epsilon_left = _coarse(vertices, faces, epsilon)
    try:
        try:
            union = _union(coarse or solid, epsilon_left, parts, vertices_per_part)
            if coarse is not None:
                union = proven_union(solid, union, epsilon - epsilon_left, epsilon)
        except (TooManyCells, Undecided):
            if coarse is None:
                raise
            union = _union(solid, epsilon, parts, vertices_per_part)
    except (TooManyCells, Undecided) as error:
        why = (
            "need more than a thousand convex parts"
            if isinstance(error, TooManyCells)
            else "have hollows around which no convex parts could be proven"
        )
        said = f"is too fine: its {len(faces)} triangles {why} within {epsilon:g} m"
        remedy = "ask for a larger epsilon, or simplify the mesh where it has fine hollows"
        named = "mesh" if path is None else str(path)
        raise MeshError([Diagnostic(named, 1, 1, f"the mesh {said}", remedy)]) from None
    record_proof(solid, union.parts, union.deviations)
    return union.parts, union.deviations


def _coarse(vertices: Array, faces: Integers, epsilon: float) -> tuple[Solid | None, float]:
    """A coarser solid around a mesh of many triangles, and the rest of epsilon; None and epsilon if it is not needed.

    Parts that cover it cover the mesh. Their distance from the mesh itself is proven at the end.
    """
    if len(faces) <= COARSEN_ABOVE_TRIANGLES:
        return None, epsilon
    try:
        outer = bounding_mesh(Mesh(vertices, faces), COARSE_MESH_SHARE * epsilon)
    except (MeshError, ValueError):  # what it cannot bound may still be cut
        return None, epsilon
    return Solid(outer.vertices, outer.faces), epsilon - outer.hausdorff_upper_bound


def _union(solid: Solid, epsilon: float, parts: int | None, vertices_per_part: int | None) -> Union:
    cells = cells_of(solid, epsilon)
    union = enclosing_union(solid, cells, epsilon, vertices_per_part)
    target = parts or 0
    for share in TIGHTER_SHARES if len(union.parts) < target else ():
        with suppress(Undecided):
            tighter = enclosing_union(solid, cells, share * epsilon, vertices_per_part)
            if len(tighter.parts) <= target:
                return tighter
    return union
