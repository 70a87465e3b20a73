"""Draws every scene and every mesh without a display: `python -m scripts.pictures` (extra `pictures`).

A scene's picture shows its robots at home, its bodies, and its regions as glass.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista
from numpy.typing import NDArray
from PIL import Image

import kabo
from kabo.scene import Mesh, link_poses, world_T

ROOT = Path(__file__).resolve().parent.parent
WINDOW = (1000, 680)
COLOURS = 160  # of a picture file: enough for flat shades, a third of the bytes
STEEL, ORANGE, DARK, WOOD, GLASS, GREY = "#dfe3e8", "#f29f3d", "#4a5260", "#e6cfa8", "#58a55c", "#9aa3ad"
MOVABLE = ("#3f7fbf", "#4fa36b", "#b05fa0", "#c9593f", "#7a6fc0", "#c2a23a")


@dataclass(frozen=True)
class View:
    """A picture: which problem, and from where it is looked at."""

    problem: str
    picture: str
    camera: tuple[float, float, float]
    focus: tuple[float, float, float]
    angle: float = 30.0


VIEWS = (
    View("domains/bartender/four_bottles.yaml", "domains/bartender/scene.png", (3.1, 0.9, 1.9), (0.0, -0.05, 0.28)),
    View("domains/force_sensing/n6.yaml", "domains/force_sensing/scene.png", (2.7, -0.6, 2.0), (0.15, 0.0, 0.5)),
    View("domains/stacked/n6.yaml", "domains/stacked/scene.png", (1.75, 0.75, 0.8), (0.2, 0.0, 0.24)),
)


def _surface(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> pyvista.PolyData:
    return pyvista.PolyData.from_regular_faces(vertices, faces)


def _stage(camera: tuple[float, float, float], focus: tuple[float, float, float], angle: float) -> pyvista.Plotter:
    plotter = pyvista.Plotter(off_screen=True, window_size=list(WINDOW), lighting="light kit")
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera_position = [camera, focus, (0.0, 0.0, 1.0)]
    plotter.camera.view_angle = angle
    return plotter


def _add(
    plotter: pyvista.Plotter, mesh: Mesh, pose: NDArray[np.float64], colour: str, opacity: float = 1.0
) -> None:
    surface = _surface(mesh.vertices, mesh.faces).transform(pose, inplace=False)
    plotter.add_mesh(
        surface,
        color=colour,
        opacity=opacity,
        specular=0.3,
        split_sharp_edges=True,
        smooth_shading=True,
        feature_angle=25.0,
    )


def _save(plotter: pyvista.Plotter, path: Path) -> None:
    """Writes what the plotter shows as PNG with a palette."""
    path.parent.mkdir(parents=True, exist_ok=True)
    image = Image.fromarray(plotter.screenshot(return_img=True))
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    plotter.close()


def draw_scene(view: View) -> None:
    """Draws a problem's first state to the view's picture file."""
    scene = kabo.load_scene(kabo.load_problem(ROOT / view.problem).scene)
    plotter = _stage(view.camera, view.focus, view.angle)
    for robot in scene.robots.values():
        poses = link_poses(robot, scene.start.robots[robot.name])
        for index, (name, link) in enumerate(robot.links.items()):
            if link.mesh is not None:
                finger = "finger" in name or "palm" in name or "gripper" in name
                _add(plotter, link.mesh, poses[name], DARK if finger else (STEEL, ORANGE)[index % 2])
    movable = [name for name, body in scene.bodies.items() if body.movable]
    for name, body in scene.bodies.items():
        colour = MOVABLE[movable.index(name) % len(MOVABLE)] if body.movable else (GREY if "tap" in name else WOOD)
        _add(plotter, body.mesh, world_T(scene, scene.start, name), colour)
    for name in scene.regions:
        if name != "anywhere":
            bounds = np.c_[-np.array(scene.regions[name].size), scene.regions[name].size].ravel()
            box = pyvista.Box(bounds).transform(world_T(scene, scene.start, name), inplace=False)
            plotter.add_mesh(box, color=GLASS, opacity=0.25)
    _save(plotter, ROOT / view.picture)


def main() -> None:
    """The command."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    for view in VIEWS:
        draw_scene(view)


if __name__ == "__main__":
    main()
