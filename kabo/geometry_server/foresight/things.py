"""The bodies and links of a scene as they stand at its start."""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry import Enclosure, FixedGroup
from kabo.scene import Mesh, Scene, link_poses, world_T
from kabo.scene.transforms import flat


@dataclass(frozen=True)
class Thing:
    """A body or link at the start: its name, its mesh, its pose (4, 4), and its box in the world [m]."""

    name: str
    mesh: Mesh
    pose: Array
    low: Array
    high: Array

    @classmethod
    def at(cls, name: str, mesh: Mesh, pose: Array) -> "Thing":
        """A mesh at a pose."""
        return cls(name, mesh, pose, *box_at(mesh, pose))

    @property
    def triangles(self) -> Array:
        """Its triangles (T, 3, 3) in the world [m]."""
        return np.asarray(placed(self.mesh.vertices, self.pose)[self.mesh.faces])

    def group(self, lowered: float = 0.0) -> FixedGroup:
        """The thing for exact predicates, which read its mesh only, let down by some length [m]."""
        pose = self.pose.copy()
        pose[2, 3] -= lowered
        return FixedGroup(
            flat(pose), Enclosure((np.stack([self.low, self.high]),), 0.0), (self.mesh.vertices, self.mesh.faces)
        )


def things_at_start(scene: Scene) -> list[Thing]:
    """All bodies, and all links that have a mesh, in the scene's order."""
    state = scene.start
    bodies = {name: (body.mesh, world_T(scene, state, name)) for name, body in scene.bodies.items()}
    for name, robot in scene.robots.items():
        poses = link_poses(robot, state.robots[name])
        found = ((link, part.mesh) for link, part in robot.links.items() if part.mesh is not None)
        bodies |= {f"{name}.{link}": (mesh, poses[link]) for link, mesh in found if mesh is not None}
    return [Thing.at(name, mesh, pose) for name, (mesh, pose) in bodies.items() if len(mesh.faces)]


def box_at(mesh: Mesh, pose: Array) -> tuple[Array, Array]:
    """The least and the greatest coordinates (3,) in the world of a mesh at a pose (4, 4) [m]."""
    points = pose[:3, :3] @ mesh.vertices.T + pose[:3, 3:]  # (3, V): each row is read at once
    return points.min(axis=1), points.max(axis=1)


def placed(points: Array, pose: Array) -> Array:
    """Points (V, 3) moved by a pose (4, 4)."""
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])
