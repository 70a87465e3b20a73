"""A robot as its parameters say it, and its URDF: links with one mesh each, joints with limits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from scripts.mesh_files import write_stl
from scripts.solids import Solid

Vector = tuple[float, float, float]
UP: Vector = (0.0, 0.0, 1.0)
LEFT: Vector = (0.0, 1.0, 0.0)
RIGHT: Vector = (0.0, -1.0, 0.0)
FORWARD: Vector = (1.0, 0.0, 0.0)


@dataclass(frozen=True)
class Joint:
    """One joint; a fixed one has no limits. Lengths in metres, angles in radians, speeds per second."""

    name: str
    parent: str
    child: str
    origin: Vector
    axis: Vector = UP
    kind: str = "revolute"
    limits: tuple[float, float] | None = None
    speed: float = 1.0
    mimic: str | None = None
    rpy: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RobotModel:
    """A robot's name, its link solids (None: a frame without a body) and its joints, parents first."""

    name: str
    links: Mapping[str, Solid | None]
    joints: Sequence[Joint]


def write_robot(robot: RobotModel, folder: Path) -> dict[str, int]:
    """Writes `<name>.urdf` and a mesh per link into `folder`; returns the triangles of each link."""
    folder.mkdir(parents=True, exist_ok=True)
    counts = {
        name: write_stl(folder / f"{name}.stl", solid) for name, solid in robot.links.items() if solid is not None
    }
    lines = ['<?xml version="1.0"?>', f'<robot name="{robot.name}">']
    for name, solid in robot.links.items():
        lines += [f'  <link name="{name}"/>'] if solid is None else _link(name)
    for joint in robot.joints:
        lines += _joint(joint)
    (folder / f"{robot.name}.urdf").write_text("\n".join([*lines, "</robot>", ""]), encoding="utf-8")
    return counts


def _link(name: str) -> list[str]:
    geometry = f'<geometry><mesh filename="{name}.stl"/></geometry>'
    return [
        f'  <link name="{name}">',
        f"    <visual>{geometry}</visual>",
        f"    <collision>{geometry}</collision>",
        "  </link>",
    ]


def _joint(joint: Joint) -> list[str]:
    lines = [
        f'  <joint name="{joint.name}" type="{joint.kind}">',
        f'    <parent link="{joint.parent}"/>',
        f'    <child link="{joint.child}"/>',
        f'    <origin xyz="{_text(joint.origin)}" rpy="{_text(joint.rpy)}"/>',
    ]
    if joint.limits is not None:
        lower, upper = joint.limits
        lines += [
            f'    <axis xyz="{_text(joint.axis)}"/>',
            f'    <limit lower="{lower:.9g}" upper="{upper:.9g}" velocity="{joint.speed:.9g}" effort="100"/>',
        ]
    if joint.mimic is not None:
        lines += [f'    <mimic joint="{joint.mimic}" multiplier="1" offset="0"/>']
    return [*lines, "  </joint>"]


def _text(vector: Vector) -> str:
    return " ".join(f"{value:.9g}" for value in vector)
