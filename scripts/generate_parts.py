"""Writes the convex parts beside every mesh, so that a clone solves at once: `python -m scripts.generate_parts`.

Slow (minutes), and run after `scripts.generate_meshes` only for the meshes that changed.
"""

import argparse
from pathlib import Path

from kabo.geometry import write_parts
from kabo.scene import load_mesh
from scripts.generate_meshes import MESHES, MILLIMETRES

COARSE = 0.004  # how far a part may stick out of its mesh [m]: what epsilon 0.01 leaves to each body
FINE = 0.003  # for what hands hold, and for hands
HANDS = ("gripper_wide", "gripper_small", "gripper_slim", "bottle", "cup", "block", "gearbox", "panel")


def tolerance_of(path: Path) -> float:
    """How far the parts of a mesh may stick out of it [m]."""
    return FINE if path.parent.name in HANDS else COARSE


def parts_file(path: Path) -> Path:
    """Where the parts of a mesh are kept."""
    return path.with_name(f"{path.name}.parts")


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="*", type=Path, help="mesh files; none: those that have no parts yet")
    options = parser.parse_args()
    missing = [path for path in sorted(MESHES.glob("*/*.stl")) if not parts_file(path).exists()]
    for path in options.meshes or missing:
        mesh = load_mesh(path, 0.001 if path.parent.name in MILLIMETRES else 1.0)
        write_parts(mesh, tolerance_of(path))


if __name__ == "__main__":
    main()
