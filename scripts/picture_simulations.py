"""Draws the scene of each domain as the simulator has it, settled under gravity.

python -m scripts.picture_simulations
"""

from pathlib import Path

import numpy as np

from kabo.language import load_problem
from kabo.pictures.panels import captioned, framed, grid, png
from kabo.pictures.rendering import Pixels
from kabo.pictures.simulated import simulated_drawing
from kabo.pictures.views import ViewWishes, picture_of
from kabo.scene import GeometricState, Scene, attachment, load_scene
from kabo.simulation import Physics
from kabo.whole_files import write_atomically

ROOT = Path(__file__).resolve().parent.parent
SCENES = "docs/pictures/simulations.png"
PROBLEMS = {  # one of each domain with geometry
    "ASSEMBLY": "domains/assembly/gearbox.yaml",
    "BARTENDER": "domains/bartender/four_bottles.yaml",
    "CIRCULAR": "domains/circular_rearrange/n3.yaml",
    "FORCE SENSING": "domains/force_sensing/n3.yaml",
    "INSPECTION": "domains/inspection/three_boxes_covered.yaml",
    "STACKED": "domains/stacked/n4.yaml",
    "WAITER": "domains/waiter/two_cups.yaml",
    "two cans": "examples/two_cans/scene.yaml",
    "two arms": "examples/two_arms/problem.yaml",
}
SIZE, COLUMNS = (420, 320), 3  # of a panel [pixels]
SETTLED = 0.5  # [s]


def panel(name: str, file: str) -> Pixels:
    """The scene of a problem or scene file under its name, with the greatest way that a body has settled."""
    scene = scene_of(ROOT / file)
    physics = Physics(scene)
    state, moved = settled(scene, physics)
    pixels = picture_of(simulated_drawing(scene, state), ViewWishes(size=SIZE, labels=False))
    shapes = len(physics.description.things)
    return captioned(framed(pixels), [f"{name}: {shapes} shapes, settled by {1000.0 * moved:.2g} mm"], 1)


def scene_of(file: Path) -> Scene:
    """The scene of a problem or scene file."""
    if file.name.startswith("scene"):
        return load_scene(file)
    problem = load_problem(file)
    assert problem.scene is not None
    return load_scene(problem.scene)


def settled(scene: Scene, physics: Physics) -> tuple[GeometricState, float]:
    """Where everything is after a moment of gravity, and how far a body has moved at most [m]."""
    before = {name: physics.pose(name) for name in scene.movable}
    for _ in range(round(SETTLED / physics.settings.timestep)):
        physics.step()
    after = {name: physics.pose(name) for name in scene.movable}
    moved = max((float(np.linalg.norm(after[n][:3, 3] - pose[:3, 3])) for n, pose in before.items()), default=0.0)
    changes: dict[str, object] = {name: attachment("world", pose) for name, pose in after.items()}
    changes |= {name: physics.configuration(name) for name in scene.robots}
    return scene.start.replace(changes), moved  # type: ignore[arg-type]


def made() -> bytes:
    """All panels as one PNG."""
    return png(grid([panel(name, file) for name, file in PROBLEMS.items()], COLUMNS))


if __name__ == "__main__":
    write_atomically(ROOT / SCENES, made())
