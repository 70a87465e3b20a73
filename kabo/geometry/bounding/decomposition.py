"""Makes covers: few convex parts, proven to cover a solid and to stay within a tolerance of it [K Def. 3].

Covering holds by construction and is proven cell by cell (`enclosing_union`); the distance of every point of every
part to the solid is proven by tetrahedra (`nearness`). Where a tolerance would need very many cells, a coarser cover is
made, whose parts can be refined one by one: each is replaced by parts that cover what it covers of the solid.
"""

from contextlib import suppress
from typing import Literal, NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.errors import MeshError
from kabo.geometry.bounding import enclosing_union
from kabo.geometry.bounding.bounding_mesh import bounding_mesh
from kabo.geometry.bounding.cells import inside_planes, whole
from kabo.geometry.bounding.coacd_engine import coacd_cover
from kabo.geometry.bounding.containment import hull_planes, solid_points
from kabo.geometry.bounding.enclosing_union import Aims, TooManyCells, Undecided, cells_of, proven_cover
from kabo.geometry.bounding.nearness import proven_near
from kabo.geometry.bounding.splitting import FLAT_THICKNESS_SHARE, HulledCell, creases
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.triangles.solids import Solid
from kabo.meshes import Mesh

COARSEN_ABOVE_TRIANGLES = 5_000  # above which a coarser bounding mesh is decomposed instead
COARSEN_FEW_ABOVE_TRIANGLES = (
    30_000  # the same if parts are to be few, which cells of the mesh itself serve better
)
COARSE_MESH_SHARE = 0.1  # of the tolerance: how far that bounding mesh may deviate
TIGHTER_SHARES = (0.4, 0.55, 0.7, 0.85)  # of the tolerance: tried in turn to reach a target number of parts
FINEST_ROOTS = (
    0.002  # of a solid's diagonal: the least tolerance that is tried for a whole solid, if parts are to be few
)
FEW_TRIANGLES = 200  # up to which any tolerance is tried
LEVEL_RATIO = 4.0  # of the tolerances of a part and its children, in a tree of parts


class Request(NamedTuple):
    """What is asked of a cover; a shape and a request decide its bytes."""

    aims: Aims
    parts: int | None = None  # the desired number of parts; more are made if the tolerance requires it
    cells: int | None = None  # above which a coarser cover is made; None: a thousand, and none is
    engine: Literal["kabo", "coacd"] = "kabo"  # what cuts the solid into pieces
    seed: int = 0  # of CoACD, which alone makes random choices


def made_cover(solid: Solid, request: Request) -> Cover:
    """A cover of a solid; its tolerance is that of the request, or coarser by a power of `LEVEL_RATIO`.

    Raises:
        TooManyCells, Undecided: there is no such cover.
    """
    tolerance = request.aims.tolerance
    if request.engine == "coacd":
        return coacd_cover(solid, request.aims, request.seed)
    if request.aims.few_parts and len(solid.faces) > FEW_TRIANGLES:
        while tolerance < FINEST_ROOTS * solid.diagonal:  # finer ones would need very many cells
            tolerance *= LEVEL_RATIO
    while True:
        aims = request.aims._replace(tolerance=tolerance)
        try:
            return _covered(solid, aims, request)
        except (TooManyCells, Undecided):
            tolerance *= LEVEL_RATIO
            if request.cells is None or tolerance > 1.0:
                raise


def finer_tolerance(tolerance: float, finest: float) -> float:
    """The tolerance of the children of a part that was made for `tolerance`: a level between it and `finest`."""
    finer = finest
    while finer * LEVEL_RATIO <= 0.5 * tolerance:
        finer *= LEVEL_RATIO
    return finer


def refined_cover(solid: Solid, part: Array, aims: Aims) -> Cover:
    """Parts that cover what a convex part (V, 3) covers of a solid, each within the tolerance of the whole solid.

    Raises:
        TooManyCells, Undecided: there are no such parts.
    """
    planes = hull_planes(part)
    inner = inside_planes(whole(solid.vertices, solid.faces), planes)
    if not len(inner.segments):  # the part is within the solid, or outside
        if not proven_near(solid, part, aims.tolerance):
            raise Undecided
        return Cover((part,), (aims.tolerance,), aims.tolerance)
    concave = creases(solid.vertices, solid.faces)
    within = np.all(concave.middles @ planes[:, :3].T <= planes[:, 3], axis=1)
    points = solid_points(inner.points, FLAT_THICKNESS_SHARE * aims.tolerance)
    cells = cells_of(solid, aims, [HulledCell(points, inner, concave.within(within))])
    return enclosing_union.enclosing_union(solid, cells, aims)


def _covered(solid: Solid, aims: Aims, request: Request) -> Cover:
    many = COARSEN_FEW_ABOVE_TRIANGLES if aims.few_parts else COARSEN_ABOVE_TRIANGLES
    coarse, left = _coarse(solid, aims.tolerance) if len(solid.faces) > many else (None, aims.tolerance)
    try:
        found = _union(coarse or solid, aims._replace(tolerance=left), request)
        return found if coarse is None else proven_cover(solid, found, aims.tolerance - left, aims.tolerance)
    except (TooManyCells, Undecided):
        if coarse is None:
            raise
    return _union(solid, aims, request)


def _coarse(solid: Solid, tolerance: float) -> tuple[Solid | None, float]:
    """A coarser solid around one of many triangles, and the rest of the tolerance; None and all of it if there is none.

    Parts that cover it cover the solid. Their distance from the solid itself is proven at the end.
    """
    try:
        outer = bounding_mesh(Mesh(solid.vertices, solid.faces), COARSE_MESH_SHARE * tolerance)
    except (MeshError, ValueError):  # what it cannot bound may still be cut
        return None, tolerance
    return Solid(outer.vertices, outer.faces), tolerance - outer.hausdorff_upper_bound


def _union(solid: Solid, aims: Aims, request: Request) -> Cover:
    cells = cells_of(solid, aims, most=request.cells)
    union = enclosing_union.enclosing_union(solid, cells, aims)
    target = request.parts or 0
    for share in TIGHTER_SHARES if len(union.parts) < target else ():
        with suppress(Undecided):
            tight = aims._replace(tolerance=share * aims.tolerance)
            tighter = enclosing_union.enclosing_union(solid, cells, tight)
            if len(tighter.parts) <= target:
                return Cover(tighter.parts, tighter.deviations, aims.tolerance)
    return union
