"""Pictures of a mesh beside what encloses it, coloured by the distance between the two, drawn without a display.

The library that draws, pyvista, is the extra `pictures`; `require_pictures` says so before a long computation.
"""

from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from kabo.errors import Diagnostic, InputError
from kabo.meshes.mesh import Faces, Vertices
from kabo.whole_files import write_atomically

Surface = tuple[Vertices, Faces]
WINDOW_SIZE = (1500, 860)
ROW_SHARES = (0.09, 0.79, 0.12)  # title, panels, colour bar
MAX_EDGE_SHARE = 0.02  # share of the diagonal: longer edges of coloured surfaces are divided
MAX_DRAWN_EDGES = 4000  # triangles whose edges are drawn; more would be a grey veil
VIEW_DIRECTION = (1.0, -1.5, 0.9)
DISTANCE_COLOURS = ("#e4e8ee", "#f3d27a", "#e58a3c", "#c23b4e", "#5d1747")  # from 0 to epsilon
PART_COLOURS = ("#3f7fbf", "#f29f3d", "#4fa36b", "#b05fa0", "#c9593f", "#7a6fc0", "#c2a23a", "#58b0a8", "#8c8f94")


def require_pictures() -> None:
    """Raises an error unless the libraries that draw pictures are installed.

    Raises:
        InputError: the extra is not installed.
    """
    if find_spec("pyvista") is None:
        hint = 'install it with the extra: pip install "kabo[pictures]"'
        raise InputError([Diagnostic("--picture", 1, 1, "drawing pictures needs the library pyvista", hint)])


def draw_bound(path: Path, original: Surface, bound: Surface, *, epsilon: float, title: str) -> None:
    """Draws a mesh and its bounding mesh, each coloured by its distance from the other [m].

    Args:
        path: the picture (PNG). original, bound: vertices (V, 3) [m] and faces (F, 3).
        epsilon: [m], the end of the colour scale. title: a line above.
    """
    first, second = _surface(original), _surface(bound)
    panels = [
        [(_coloured(first, second), {"scalars": "distance"}), (first, None)],
        [(_coloured(second, first), {"scalars": "distance"}), (second, None)],
    ]
    _draw(path, panels, ("the mesh", "what bounds it"), epsilon, title)


def draw_parts(path: Path, original: Surface, parts: Sequence[Surface], *, epsilon: float, title: str) -> None:
    """Draws a mesh, the convex parts that cover it, and these coloured by their distance from the mesh [m].

    Args:
        path: the picture (PNG). original: vertices (V, 3) [m] and faces (F, 3). parts: the same for each part.
        epsilon: [m], the end of the colour scale. title: a line above.
    """
    first = _surface(original)
    hulls = [_surface(part) for part in parts]
    plain = [(first, {"color": "#c9ced6"})]
    own = [(hull, {"color": PART_COLOURS[number % len(PART_COLOURS)]}) for number, hull in enumerate(hulls)]
    far = [(_coloured(hull, first), {"scalars": "distance"}) for hull in hulls]
    _draw(path, [plain, own, far], ("the mesh", "convex parts", "distance of the parts"), epsilon, title)


def draw_bodies(path: Path, bodies: Sequence[tuple[Surface, str]], *, title: str) -> None:
    """Draws bodies where they are, each in one colour.

    Args:
        path: the picture (PNG). bodies: vertices (V, 3) [m] and faces (F, 3), and a colour such as "#3f7fbf".
        title: a line above.
    """
    _draw(path, [[(_surface(body), {"color": colour}) for body, colour in bodies]], ("",), 1.0, title)


def _surface(surface: Surface) -> Any:
    import pyvista

    faces: Any = np.asarray(surface[1])
    return pyvista.PolyData.from_regular_faces(np.asarray(surface[0], np.float64), faces)


def _coloured(surface: Any, other: Any) -> Any:
    """The surface, divided into small triangles, with the distance of each vertex from the other surface [m]."""
    fine = surface.subdivide_adaptive(max_edge_len=MAX_EDGE_SHARE * surface.length, max_n_passes=8)
    fine = fine.compute_implicit_distance(other)
    fine["distance"] = np.abs(fine["implicit_distance"])
    return fine


def _draw(path: Path, panels: Sequence[Sequence[Any]], names: Sequence[str], epsilon: float, title: str) -> None:
    import pyvista
    from PIL import Image
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # it complains that there is no display, and draws
    size = len(panels)
    rows: Any = {
        "shape": (3, size),
        "groups": [(0, slice(None)), (2, slice(None))],
        "row_weights": list(ROW_SHARES),
    }
    plotter: Any = pyvista.Plotter(
        off_screen=True, window_size=list(WINDOW_SIZE), border=False, lighting="light kit", **rows
    )
    plotter.set_background("white")
    _write_title(plotter, title)
    bar = None
    for column, layers in enumerate(panels):
        plotter.subplot(1, column)
        for surface, look in layers:
            bar = _add(plotter, surface, look, epsilon) or bar
        plotter.add_text(names[column], position="lower_left", font_size=11, color="#333333")
        _look(plotter, panels)
    if bar is not None:
        plotter.subplot(2, 0)
        plotter.add_scalar_bar(
            "distance [m]", mapper=bar, width=0.6, height=0.55, position_x=0.2, position_y=0.3, **_BAR
        )
    with suppress(AttributeError):  # the software renderers of some systems have none
        plotter.enable_anti_aliasing("ssaa")
    picture = BytesIO()
    Image.fromarray(plotter.screenshot(return_img=True)).save(picture, "PNG", optimize=True)
    plotter.close()
    write_atomically(path, picture.getvalue())


_BAR = {"color": "#222222", "fmt": "%.3g", "n_labels": 5, "title_font_size": 18, "label_font_size": 16}


def _write_title(plotter: Any, title: str) -> None:
    plotter.subplot(0, 0)
    plotter.add_text(title, position=(0.012, 0.3), viewport=True, font_size=13, color="#111111")


def _add(plotter: Any, surface: Any, look: dict[str, Any] | None, epsilon: float) -> Any:
    """Adds one layer; returns what the colour bar needs if it is coloured by distance."""
    if look is None:
        if surface.n_cells <= MAX_DRAWN_EDGES:
            lines = plotter.add_mesh(surface.extract_all_edges(), color="#3a3f47", line_width=1.0, lighting=False)
            lines.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            lines.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -2.0)  # not half in the surface
        return None
    if "scalars" not in look:
        plotter.add_mesh(surface, smooth_shading=False, ambient=0.12, **look)
        return None
    from matplotlib.colors import LinearSegmentedColormap

    colours = LinearSegmentedColormap.from_list("distance", DISTANCE_COLOURS)
    shown = {"clim": (0.0, epsilon), "cmap": colours, "show_scalar_bar": False, "ambient": 0.12}
    return plotter.add_mesh(surface, smooth_shading=False, **shown, **look).mapper


def _look(plotter: Any, panels: Sequence[Sequence[Any]]) -> None:
    """Sets the same camera in all panels: from one corner, as near as shows everything in all of them."""
    boxes = np.array([surface.bounds for layers in panels for surface, _ in layers]).reshape(-1, 3, 2)
    low, high = boxes[:, :, 0].min(axis=0), boxes[:, :, 1].max(axis=0)
    centre, radius = (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0
    away = np.array(VIEW_DIRECTION) / np.linalg.norm(VIEW_DIRECTION)
    right = np.cross((0.0, 0.0, 1.0), away)
    right /= np.linalg.norm(right)
    half = (high - low) / 2.0
    width, height = np.abs(right) @ half, np.abs(np.cross(away, right)) @ half
    aspect = WINDOW_SIZE[0] / len(panels) / (WINDOW_SIZE[1] * ROW_SHARES[1])
    plotter.camera_position = [tuple(centre + 4.0 * radius * away), tuple(centre), (0.0, 0.0, 1.0)]
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 1.1 * max(height, width / aspect)
