"""Pictures of meshes: beside what encloses them, as convex parts, and coloured by the distance between the two."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kabo.arrays import Array
from kabo.meshes.mesh import Faces, Vertices
from kabo.pictures.cameras import fitted, natural_aspect
from kabo.pictures.drawing import Drawing, Solid
from kabo.pictures.panels import captioned, distance_bar, framed, grid, png, titled
from kabo.pictures.rendering import Stage, poly_data
from kabo.pictures.views import View, ViewWishes, chosen_view, taken

Surface = tuple[Vertices, Faces]
MAX_EDGE_SHARE = 0.02  # share of the diagonal: longer edges of coloured surfaces are divided
MAX_DRAWN_EDGES = 4000  # triangles whose edges are drawn; more would be a grey veil
PLAIN = "#c9ced6"
PART_COLOURS = ("#3f7fbf", "#f29f3d", "#4fa36b", "#b05fa0", "#c9593f", "#7a6fc0", "#c2a23a", "#58b0a8", "#8c8f94")
PANEL_WIDTHS = {1: 900, 2: 620, 3: 440}


def bound_picture(original: Surface, bound: Surface, *, epsilon: float, title: str, wishes: ViewWishes) -> bytes:
    """A mesh and its bounding mesh as PNG, each coloured by its distance from the other.

    Args:
        original, bound: vertices (V, 3) [m] and faces (F, 3). epsilon: [m], the end of the colour scale. title: a
            line above. wishes: the camera.
    """
    panels = [
        ("the mesh", (_coloured("mesh", original, [bound]),)),
        ("what bounds it", (_coloured("bound", bound, [original]),)),
    ]
    return _sheet(panels, epsilon, title, wishes)


def parts_picture(
    original: Surface, parts: Sequence[Surface], *, epsilon: float, title: str, wishes: ViewWishes
) -> bytes:
    """A mesh, the convex parts that cover it, and these coloured by their distance from the mesh, as PNG.

    Args:
        original, parts, epsilon, title, wishes: as of `bound_picture`.
    """
    own = tuple(
        Solid(f"part {number}", *part, PART_COLOURS[number % len(PART_COLOURS)], smooth=False)
        for number, part in enumerate(parts)
    )
    far = tuple(_coloured(f"part {number}", part, [original]) for number, part in enumerate(parts))
    panels = [
        ("the mesh", (Solid("mesh", *original, PLAIN, smooth=False),)),
        ("convex parts", own),
        ("distance of the parts", far),
    ]
    return _sheet(panels, epsilon, title, wishes)


def mesh_drawing(name: str, surface: Surface) -> Drawing:
    """The drawing of one mesh with its edges."""
    edges = surface if len(surface[1]) <= MAX_DRAWN_EDGES else None
    return Drawing((Solid(name, *surface, PLAIN, smooth=False, edges=edges),))


def _sheet(
    panels: Sequence[tuple[str, tuple[Solid, ...]]], epsilon: float, title: str, wishes: ViewWishes
) -> bytes:
    """Panels side by side from the same camera, which shows all of each, over the bar of colours."""
    drawings = [Drawing(solids) for _, solids in panels]
    points = np.concatenate([drawing.points for drawing in drawings])
    view: View | None = None
    found = []
    for (name, _), drawing in zip(panels, drawings, strict=True):
        stage = Stage(drawing, (PANEL_WIDTHS[len(panels)],) * 2, greatest_distance=epsilon)
        try:
            view = view or _view(stage, points, wishes, PANEL_WIDTHS[len(panels)])
            found.append(captioned(framed(taken(stage, view)), [name], 1))
        finally:
            stage.close()
    sheet = grid(found, len(found))
    return png(titled(np.concatenate([sheet, distance_bar(sheet.shape[1], epsilon)]), title))


def _view(stage: Stage, points: Array, wishes: ViewWishes, width: int) -> View:
    """The view as wished; else from one corner, where faces in all three directions are seen."""
    if wishes.camera is not None or wishes.look_at is not None:
        return chosen_view(stage, points, replace(wishes, size=None), width)
    away = np.array([1.0, -1.5, 0.9])
    aspect = natural_aspect(points, away, narrowest=0.75)
    return View(fitted(points, away, aspect), (width, 2 * round(width / aspect / 2.0)))


def _coloured(name: str, surface: Surface, others: Sequence[Surface]) -> Solid:
    """The surface, divided into small triangles, with the distance of each vertex from the nearest other surface [m]."""
    whole = poly_data(*surface)
    fine = whole.subdivide_adaptive(max_edge_len=MAX_EDGE_SHARE * whole.length, max_n_passes=8)
    distances = np.full(fine.n_points, np.inf)
    for other in others:
        distances = np.minimum(
            distances, np.abs(fine.compute_implicit_distance(poly_data(*other))["implicit_distance"])
        )
    edges = surface if len(surface[1]) <= MAX_DRAWN_EDGES else None
    return Solid(
        name, np.asarray(fine.points), fine.regular_faces, PLAIN, smooth=False, edges=edges, distances=distances
    )
