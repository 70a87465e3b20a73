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
from kabo.scene import Scene, link_poses, world_T
from scripts.gearbox import COLLAR, SEAT, SHOULDER
from scripts.generate_meshes import GEARBOX, ROBOTS, THINGS
from scripts.mesh_files import triangles
from scripts.robot_files import RobotModel
from scripts.solids import HIGH

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
ROOT = Path(__file__).resolve().parent.parent
WINDOW = (1000, 680)
STEEL, ORANGE, DARK, WOOD, GLASS, GREY = "#dfe3e8", "#f29f3d", "#4a5260", "#e6cfa8", "#58a55c", "#9aa3ad"
MOVABLE = ("#3f7fbf", "#4fa36b", "#b05fa0", "#c9593f", "#7a6fc0", "#c2a23a")


@dataclass(frozen=True)
class View:
    """A picture: which problem, and from where it is looked at."""

    problem: str
    picture: str
    camera: Vector
    focus: Vector


VIEWS = (
    View(
        "domains/bartender/four_bottles.yaml", "domains/bartender/scene.png", (3.1, 0.9, 1.9), (0.0, -0.05, 0.28)
    ),
    View(
        "domains/circular_rearrange/n5.yaml",
        "domains/circular_rearrange/scene.png",
        (3.1, 0.6, 1.9),
        (0.0, 0.0, 0.28),
    ),
    View("domains/force_sensing/n6.yaml", "domains/force_sensing/scene.png", (2.7, -0.6, 2.0), (0.15, 0.0, 0.5)),
    View("domains/assembly/gearbox.yaml", "domains/assembly/scene.png", (2.3, 0.45, 1.35), (-0.2, 0.02, 0.36)),
    View(
        "domains/inspection/three_boxes_covered.yaml",
        "domains/inspection/scene.png",
        (2.7, -1.1, 1.9),
        (0.25, 0.0, 0.65),
    ),
    View("domains/waiter/two_cups.yaml", "domains/waiter/scene.png", (-2.2, -5.0, 4.0), (0.0, -0.1, 0.2)),
    View("domains/stacked/n6.yaml", "domains/stacked/scene.png", (1.75, 0.75, 0.8), (0.2, 0.0, 0.24)),
)
# Where things stand in the picture of all meshes, in the order of THINGS: the table behind, the others in front.
SHELF = (
    (0.5, 0.0, 0.0),
    (0.5, 0.3, 0.0),
    (0.5, 0.55, 0.0),
    (0.5, 0.95, 0.0),
    (0.5, 1.45, 0.0),
    (-0.7, 2.0, 0.0),
    (0.5, 1.85, 0.0),
)


def draw_scene(view: View) -> None:
    """Draws a problem's first state to the view's picture file."""
    description = kabo.load_problem(ROOT / view.problem).scene
    assert description is not None
    scene = kabo.load_scene(description)
    plotter = _stage(view.camera, view.focus, 30.0)
    _add_robots(plotter, scene)
    movable = list(scene.movable)
    for name, body in scene.bodies.items():
        colour = MOVABLE[movable.index(name) % len(MOVABLE)] if body.movable else (GREY if name == "tap" else WOOD)
        opacity = 0.35 if name == "panel" else 1.0
        _add(plotter, body.mesh.vertices, body.mesh.faces, world_T(scene, scene.start, name), colour, opacity)
    for name, region in scene.regions.items():
        if name not in {"anywhere", "work_area", "hall"}:
            box = pyvista.Box(np.c_[-np.array(region.size), region.size].ravel())
            plotter.add_mesh(box.transform(region.world_T_region, inplace=False), color=GLASS, opacity=0.25)
    _save(plotter, ROOT / view.picture)


def draw_gallery(picture: Path) -> None:
    """Draws every robot, bent a little, and every thing, side by side."""
    plotter = _stage((4.3, 1.0, 1.6), (0.0, 0.95, 0.5), 30.0)
    for index, make in enumerate(ROBOTS.values()):
        robot = make(HIGH)
        place = _placed(robot, _offset((0.0, 0.5 * index, 0.0)))
        for number, (name, solid) in enumerate(robot.links.items()):
            if solid is not None:
                _add(plotter, *triangles(solid), place[name], (STEEL, ORANGE)[number % 2])
    for index, thing in enumerate(THINGS.values()):
        _add(plotter, *triangles(thing(HIGH)), _offset(SHELF[index]), MOVABLE[index % len(MOVABLE)])
    _save(plotter, picture)


def draw_gearbox(picture: Path) -> None:
    """Draws the parts of the gearbox apart on their axis, and put together under a pipe of glass."""
    plotter = _stage((0.8, 0.11, 0.48), (0.0, 0.11, 0.185), 30.0)
    apart = (("tree", 0.0, 0), ("bearing", 0.165, 1), ("pipe", 0.22, 2), ("bearing", 0.375, 3))
    together = (("tree", 0.0, 0), ("bearing", SHOULDER, 1), ("pipe", COLLAR, 2), ("bearing", COLLAR + SEAT, 3))
    for y, places in ((0.0, apart), (0.22, together)):
        for name, z, colour in places:
            opacity = 0.3 if name == "pipe" and y else 1.0
            _add(plotter, *triangles(GEARBOX[name](HIGH)), _offset((0.0, y, z)), MOVABLE[colour], opacity)
    _save(plotter, picture)


def _placed(robot: RobotModel, world_T_root: Floats) -> dict[str, Floats]:
    """The pose of every link with all joints at zero."""
    place = {robot.joints[0].parent: world_T_root}
    for joint in robot.joints:
        half_turn = np.diag([-1.0, -1.0, 1.0, 1.0]) if joint.rpy[2] else np.eye(4)
        place[joint.child] = place[joint.parent] @ _offset(joint.origin) @ half_turn
    return place


def _offset(origin: Vector) -> Floats:
    pose = np.eye(4)
    pose[:3, 3] = origin
    return pose


def _stage(camera: Vector, focus: Vector, angle: float) -> pyvista.Plotter:
    plotter = pyvista.Plotter(off_screen=True, window_size=list(WINDOW), lighting="light kit")
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    plotter.camera_position = [camera, focus, (0.0, 0.0, 1.0)]
    plotter.camera.view_angle = angle
    return plotter


def _add_robots(plotter: pyvista.Plotter, scene: Scene) -> None:
    for robot in scene.robots.values():
        poses = link_poses(robot, scene.start.robots[robot.name])
        for index, (name, link) in enumerate(robot.links.items()):
            if link.mesh is not None:
                hand = any(word in name for word in ("finger", "palm", "gripper"))
                colour = DARK if hand else (STEEL, ORANGE)[index % 2]
                _add(plotter, link.mesh.vertices, link.mesh.faces, poses[name], colour)


def _add(
    plotter: pyvista.Plotter,
    vertices: Floats,
    faces: NDArray[np.int64],
    pose: Floats,
    colour: str,
    opacity: float = 1.0,
) -> None:
    surface = pyvista.PolyData.from_regular_faces(vertices, faces).transform(pose, inplace=False)
    look = {"specular": 0.3, "split_sharp_edges": True, "smooth_shading": True, "feature_angle": 25.0}
    plotter.add_mesh(surface, color=colour, opacity=opacity, **look)


def _save(plotter: pyvista.Plotter, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(plotter.screenshot(return_img=True)).save(path, optimize=True)
    plotter.close()


def main() -> None:
    """The command."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    for view in VIEWS:
        draw_scene(view)
    draw_gearbox(ROOT / "domains" / "assembly" / "gearbox.png")
    draw_gallery(ROOT / "docs" / "pictures" / "meshes.png")


if __name__ == "__main__":
    main()
