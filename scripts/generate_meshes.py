"""Writes every mesh and URDF of the repository: `python -m scripts.generate_meshes [--output DIR] [--detail low]`.

The same bytes on every run. `--parts` also computes, beside each mesh, the convex parts that a clone solves with.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

from scripts import gearbox, things
from scripts.arm6 import arm6
from scripts.arm7 import arm7
from scripts.grippers import SLIM, SMALL, WIDE, gripper
from scripts.mesh_files import write_stl
from scripts.mobile5 import mobile5
from scripts.robot_files import RobotModel, write_robot
from scripts.solids import HIGH, LOW, Detail, Solid

MESHES = Path(__file__).resolve().parent.parent / "meshes"
ROBOTS: dict[str, Callable[[Detail], RobotModel]] = {
    "arm6": arm6,
    "arm7": arm7,
    "mobile5": mobile5,
    "gripper_wide": lambda detail: gripper(WIDE, detail),
    "gripper_small": lambda detail: gripper(SMALL, detail),
    "gripper_slim": lambda detail: gripper(SLIM, detail),
}
THINGS: dict[str, Callable[[Detail], Solid]] = {
    "bottle": things.bottle,
    "cup": things.cup,
    "block": things.wooden_block,
    "tap": things.tap,
    "crate": things.crate,
    "table": things.table,
    "panel": things.panel,
}
GEARBOX: dict[str, Callable[[Detail], Solid]] = {
    "bearing": gearbox.bearing,
    "pipe": gearbox.pipe,
    "tree": gearbox.tree,
}
MILLIMETRES = {"bottle"}  # drawn in millimetres, as many CAD exports are; scenes say `scale: 0.001`


def generate(folder: Path, detail: Detail) -> dict[str, int]:
    """Writes all meshes and URDFs below `folder`; returns the triangles of each mesh by its path in it."""
    counts = {}
    for name, make in ROBOTS.items():
        robot = write_robot(make(detail), folder / name)
        counts.update({f"{name}/{link}.stl": count for link, count in robot.items()})
    for name, thing in THINGS.items():
        scale = 0.001 if name in MILLIMETRES else 1.0
        counts[f"{name}/{name}.stl"] = write_stl(folder / name / f"{name}.stl", thing(detail), scale)
    for name, part in GEARBOX.items():
        counts[f"gearbox/{name}.stl"] = write_stl(folder / "gearbox" / f"{name}.stl", part(detail))
    return counts


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=MESHES)
    parser.add_argument("--detail", choices=["high", "low"], default="high")
    options = parser.parse_args()
    generate(options.output, HIGH if options.detail == "high" else LOW)


if __name__ == "__main__":
    main()
