"""Draws what `drawing` describes with VTK, without a display: arrays of pixels, the same for the same input.

Glass is drawn in a pass of its own, and mixed over the opaque picture where it is nearer: only its first surface
counts, so hundreds of hulls inside each other are as clear as one, and the bodies below stay visible.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array
from kabo.meshes.mesh import Faces, Vertices
from kabo.pictures.cameras import Camera, directions, fitted
from kabo.pictures.drawing import Drawing, Solid

Pixels = NDArray[np.uint8]  # (H, W, 3)
Numbers = NDArray[np.int64]  # (H, W), of solids
SAMPLES = 2  # a picture is drawn so many times larger along each side, and made smaller: smooth edges
SMALL = (192, 128)  # the size of the pictures by which a side is chosen
FRONT, FRONT_FROM = 0.3, 0.1  # how much a side gains by being the front; [m] from which on there is one
OUTLINE, OUTLINE_STEP = 0.45, 0.012  # darkness of outlines; the step in depth, relative to it, that makes one
AMBIENT, SPECULAR = 0.12, 0.25
FEATURE_ANGLE = 25.0  # degrees between faces: sharper edges stay sharp when shaded
EDGE_COLOUR = "#3a3f47"
DISTANCE_COLOURS = ("#e4e8ee", "#f3d27a", "#e58a3c", "#c23b4e", "#5d1747")  # from 0 to epsilon


class Stage:
    """A window without a display that holds the solids of a drawing; they can be moved, and looked at again."""

    def __init__(self, drawing: Drawing, size: tuple[int, int], *, greatest_distance: float = 1.0) -> None:
        import pyvista

        _quieten()
        self.drawing, self.size = drawing, size
        made: Any = pyvista.Plotter  # its types are not those of its wrapper
        self._plotter: Any = made(
            off_screen=True, window_size=[SAMPLES * side for side in size], lighting="light kit"
        )
        self._plotter.set_background("white")
        self._plotter.render_window.SetMultiSamples(0)  # our own samples keep depths and numbers exact
        self._actors = {id(solid): _actor(self._plotter, solid, greatest_distance) for solid in drawing.everything}
        self._edges = [_edge_actor(self._plotter, solid) for solid in drawing.solids if solid.edges is not None]

    def place(self, poses: Mapping[str, Array]) -> None:
        """Moves the solids of some names, those of glass excepted, to poses (4, 4)."""
        for solid in self.drawing.solids:
            if solid.name in poses:
                self._actors[id(solid)].user_matrix = poses[solid.name]

    def shot(self, camera: Camera) -> tuple[Pixels, Array]:
        """The picture (H, W, 3) from a camera, and depths (H, W) [m], inf where there is nothing."""
        self._aim(camera)
        pixels, depth = self._pass(self.drawing.solids, edges=True)
        pixels = _outlined(pixels, depth)
        for glass in self.drawing.glass:
            over, nearer = self._pass(glass.solids, edges=False)
            share = glass.opacity * (nearer < depth)[:, :, None]
            pixels = (1.0 - share) * pixels + share * _outlined(over, nearer)
        return _smaller(pixels, self.size), depth[::SAMPLES, ::SAMPLES]

    def best_direction(self, points: Array, states: Sequence[Mapping[str, Array]] = ({},)) -> Array:
        """The direction (3,) from which the solids show most of themselves, by their weights, in all of some states.

        Sides on which what weighs most is nearer than the rest are preferred: arms are seen behind their work.

        Args:
            points: that are in the picture [m]. states: of each, the poses (4, 4) of solids that move.
        """
        aspect = SMALL[0] / SMALL[1]
        self._plotter.window_size = list(SMALL)
        self._flat(True)
        front = _front(self.drawing.everything)
        # Cameras are fitted to all points of all states, once: that takes longer than to draw a small picture.
        cameras = [fitted(points, away, aspect) for away in directions()]
        turned = [1.0 + FRONT * float(away[:2] @ front) / float(np.linalg.norm(away[:2])) for away in directions()]
        scores = np.zeros(len(cameras))
        for poses in states:
            self.place(poses)
            for number, camera in enumerate(cameras):
                scores[number] += round(turned[number] * self._score(camera), 6)
        self.place({solid.name: solid.pose for solid in self.drawing.solids})
        self._flat(False)
        self._plotter.window_size = [SAMPLES * side for side in self.size]
        return directions()[int(np.argmax(scores))]

    def visible(self, camera: Camera) -> Numbers:
        """For every pixel (H, W) of a picture from a camera, the number of the solid that is seen, else -1."""
        opaque = self.drawing.solids
        self._flat(True)
        self._plotter.window_size = list(self.size)
        self._aim(camera)
        self._show(opaque, edges=False)
        numbers = _numbers(self._shot())
        self._plotter.window_size = [SAMPLES * side for side in self.size]
        self._flat(False)
        return np.where(numbers < len(opaque), numbers, -1)

    def resize(self, size: tuple[int, int]) -> None:
        """Takes pictures of another size from now on."""
        self.size = size
        self._plotter.window_size = [SAMPLES * side for side in size]

    def close(self) -> None:
        """Frees the window."""
        self._plotter.close()

    def _aim(self, camera: Camera) -> None:
        """Points the camera; all solids are shown, so that what is nearest and farthest is that of all passes."""
        self._show(self.drawing.everything, edges=False)
        self._plotter.camera_position = [tuple(camera.position), tuple(camera.focus), (0.0, 0.0, 1.0)]
        self._plotter.camera.view_angle = float(np.rad2deg(camera.angle))
        self._plotter.renderer.ResetCameraClippingRange()

    def _score(self, camera: Camera) -> float:
        """How much is seen of the things from a camera: roots, so that many small ones count more than one large."""
        self._aim(camera)
        numbers = _numbers(self._shot()).ravel()
        counts = np.bincount(numbers[numbers < len(self._actors)], minlength=len(self._actors))
        return float(np.sqrt(counts) @ [solid.weight for solid in self.drawing.everything])

    def _flat(self, flat: bool) -> None:
        """Draws every solid in the colour that means its number, without light; or as it is again."""
        for number, solid in enumerate(self.drawing.everything):
            actor = self._actors[id(solid)]
            actor.prop.lighting = not flat
            actor.prop.ambient, actor.prop.diffuse = (1.0, 0.0) if flat else (AMBIENT, 1.0)
            actor.prop.specular = 0.0 if flat else SPECULAR
            actor.mapper.scalar_visibility = not flat and solid.distances is not None
            actor.prop.color = _numbered(number) if flat else solid.colour

    def _show(self, solids: Sequence[Solid], *, edges: bool) -> None:
        shown = {id(solid) for solid in solids}
        for key, actor in self._actors.items():
            actor.SetVisibility(key in shown)
        for actor in self._edges:
            actor.SetVisibility(edges)

    def _pass(self, solids: Sequence[Solid], *, edges: bool) -> tuple[Array, Array]:
        """Pixels (H, W, 3) in doubles and depths (H, W) [m] of some solids alone, in full resolution."""
        self._show(solids, edges=edges)
        pixels = self._shot()
        depth = -np.asarray(self._plotter.get_image_depth(fill_value=-np.inf), np.float64)
        return pixels.astype(np.float64), depth

    def _shot(self) -> Pixels:
        self._plotter.render()
        return np.asarray(self._plotter.screenshot(return_img=True))


def poly_data(vertices: Vertices, faces: Faces) -> Any:
    """A mesh in the form of the library that draws."""
    import pyvista

    triangles: Any = np.asarray(faces)
    return pyvista.PolyData.from_regular_faces(np.asarray(vertices, np.float64), triangles)


def _quieten() -> None:
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # it complains that there is no display, and draws


def _actor(plotter: Any, solid: Solid, greatest_distance: float) -> Any:
    surface = poly_data(solid.vertices, solid.faces)
    look: dict[str, Any] = {
        "color": solid.colour,
        "ambient": AMBIENT,
        "specular": SPECULAR,
        "specular_power": 20.0,
    }
    if solid.distances is not None:
        from matplotlib.colors import LinearSegmentedColormap

        colours = LinearSegmentedColormap.from_list("distance", DISTANCE_COLOURS)
        surface["distance"] = solid.distances
        look = {"scalars": "distance", "clim": (0.0, greatest_distance), "cmap": colours, "ambient": AMBIENT}
        look["show_scalar_bar"] = False
    if solid.smooth:
        look |= {"split_sharp_edges": True, "smooth_shading": True, "feature_angle": FEATURE_ANGLE}
    actor = plotter.add_mesh(surface, **look)
    actor.user_matrix = solid.pose
    return actor


def _edge_actor(plotter: Any, solid: Solid) -> Any:
    assert solid.edges is not None
    surface = poly_data(*solid.edges)
    actor = plotter.add_mesh(
        surface.extract_all_edges(), color=EDGE_COLOUR, line_width=1.0 * SAMPLES, lighting=False
    )
    actor.user_matrix = solid.pose
    with suppress(AttributeError):
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -2.0)  # not half in the surface
    return actor


def _numbered(number: int) -> tuple[float, float, float]:
    """A colour that means a number; white means nothing."""
    return (number % 64 * 4 + 2) / 255.0, (number // 64 % 64 * 4 + 2) / 255.0, 0.0


def _numbers(pixels: Pixels) -> Numbers:
    """The numbers that the pixels mean; a very large one for the background."""
    red, green, blue = (pixels[:, :, k].astype(np.int64) for k in range(3))
    return np.where(blue > 127, 1 << 30, red // 4 + 64 * (green // 4))


def _front(solids: Sequence[Solid]) -> Array:
    """The direction (2,) in which what weighs most lies from all else; zero where there is no such side."""
    middles = np.array([solid.world_points.mean(axis=0)[:2] for solid in solids])
    weights = np.array([solid.weight for solid in solids])
    heavy = weights == weights.max()
    if heavy.all():
        return np.zeros(2)
    across = middles[heavy].mean(axis=0) - middles[~heavy].mean(axis=0)
    return np.asarray(across / max(float(np.linalg.norm(across)), FRONT_FROM))


def _outlined(pixels: Array, depth: Array) -> Array:
    """The pixels with outlines: darker where the depth jumps, so that light bodies stand out from a light ground."""
    with np.errstate(invalid="ignore"):
        step = np.zeros(depth.shape, np.bool_)
        for axis in (0, 1):
            one, other = (np.roll(depth, shift, axis) for shift in (1, -1))
            # The second difference: slanted faces have none, edges against what lies behind have one.
            bend = one + other - 2.0 * depth
            step |= ~np.isfinite(bend) & np.isfinite(depth)
            step |= np.isfinite(bend) & (bend > OUTLINE_STEP * depth)
    return pixels * (1.0 - OUTLINE * step[:, :, None])


def _smaller(pixels: Array, size: tuple[int, int]) -> Pixels:
    """The mean of each square of samples."""
    width, height = size
    means = pixels.reshape(height, SAMPLES, width, SAMPLES, 3).mean(axis=(1, 3))
    return np.asarray(np.rint(means), np.uint8)
