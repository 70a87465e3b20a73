"""Draws what an arm sweeps, as convex polyhedra: `python -m scripts.picture_swept_volume` (extra `pictures`).

The arm of BARTENDER turns from its start to a pose over the table. Left within 2 cm, right within 5 mm: glass is
everything that the links may touch on their way, proven; the arm is drawn at the start, in the middle and at the end.
"""

import argparse
from pathlib import Path

import numpy as np
import pyvista
from PIL import Image

import kabo
from kabo.scene import Scene, link_poses

ROOT = Path(__file__).resolve().parent.parent
PROBLEM, ARM = ROOT / "domains" / "bartender" / "four_bottles.yaml", "left"
TURN = np.array([1.3, 0.5, -0.5, 0.6, 0.3, 0.4])  # radians of every joint
TOLERANCES = (0.02, 0.005)  # metres
STEEL, ORANGE, GLASS = "#dfe3e8", "#f29f3d", "#58a55c"


def draw(picture: Path) -> list[str]:
    """Draws both volumes side by side; returns a line of figures for each."""
    description = kabo.load_problem(PROBLEM).scene
    assert description is not None
    scene = kabo.load_scene(description)
    predicates = kabo.GeometryServer(scene).predicates()
    start = np.array(scene.start.robots[ARM])
    end = start.copy()
    end[: len(TURN)] += TURN
    motion = predicates.motion(ARM, [start, end])
    plotter = pyvista.Plotter(off_screen=True, shape=(1, 2), window_size=[1500, 720], border=False)
    lines = []
    for column, tolerance in enumerate(TOLERANCES):
        volume = predicates.swept_volume(motion, tolerance)
        vertices, faces = volume.mesh()
        plotter.subplot(0, column)
        plotter.set_background("white")
        glass = pyvista.PolyData.from_regular_faces(vertices, faces)
        plotter.add_mesh(glass, color=GLASS, opacity=0.16, smooth_shading=False)
        for t in (0.0, 0.5, 1.0):
            _arm(plotter, scene, start + t * (end - start))
        line = f"{len(volume.parts)} polyhedra, none farther than {1e3 * volume.deviation:.1f} mm from the way"
        plotter.add_text(line, position="lower_edge", font_size=11, color="black")
        lines.append(f"within {tolerance:g} m: {line}; {len(vertices)} vertices")
        plotter.camera_position = [(2.6, 2.3, 1.5), (-0.25, 0.85, 0.45), (0.0, 0.0, 1.0)]
        plotter.camera.view_angle = 32.0
    plotter.enable_anti_aliasing("ssaa")
    picture.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(plotter.screenshot(return_img=True)).save(picture, optimize=True)
    plotter.close()
    return lines


def _arm(plotter: pyvista.Plotter, scene: Scene, q: np.ndarray) -> None:
    robot = scene.robots[ARM]
    poses = link_poses(robot, tuple(float(v) for v in q))
    for index, (name, link) in enumerate(robot.links.items()):
        if link.mesh is not None:
            surface = pyvista.PolyData.from_regular_faces(link.mesh.vertices, link.mesh.faces)
            look = {"specular": 0.3, "split_sharp_edges": True, "smooth_shading": True, "feature_angle": 25.0}
            plotter.add_mesh(
                surface.transform(poses[name], inplace=False), color=(STEEL, ORANGE)[index % 2], **look
            )


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--output", type=Path, default=ROOT / "docs" / "pictures" / "swept_volume.png", metavar="FILE"
    )
    options = parser.parse_args()
    draw(options.output)


if __name__ == "__main__":
    main()
