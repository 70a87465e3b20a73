"""Spheres, capsules and cylinders for the library coal, as they are and not as meshes around them."""

from dataclasses import dataclass
from typing import Any

import coal
import numpy as np

from kabo.arrays import Array
from kabo.scene import Element, Mesh


@dataclass(frozen=True)
class Shape:
    """A round element of a body, or the triangles of another, as coal has it in a pose of its own."""

    geometry: Any
    body_T: Array  # (4, 4) from the shape's own frame
    element: Element | None = None  # if it is round

    def holds(self, point: Array) -> bool:
        """Whether a point (3,) of the body's frame lies in a round shape; False for triangles."""
        if self.element is None or self.element.corners is None or self.element.rounding is None:
            return False
        ball, disc, _ = self.element.rounding
        start, away = self.element.corners[0], point - self.element.corners[0]
        axis = self.element.corners[-1] - start
        share = float(away @ axis / (axis @ axis)) if axis.any() else 0.0
        nearest = min(1.0, max(0.0, share))
        across = float(np.linalg.norm(away - nearest * axis))
        return across <= disc and share == nearest if disc else across <= ball


def round_shape(element: Element) -> Shape | None:
    """The shape of a sphere, capsule or cylinder; None for all other elements."""
    if element.corners is None or element.rounding is None:
        return None
    ball, disc, axis = element.rounding
    ends, pose = element.corners, np.eye(4)
    pose[:3, 3] = ends.mean(axis=0)
    if len(ends) == 1:
        return Shape(coal.Sphere(ball), pose, element)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    across = np.array(axis) if disc or not length else (ends[1] - ends[0]) / length
    first = np.cross(across, np.eye(3)[np.argmin(np.abs(across))])
    first /= np.linalg.norm(first)
    pose[:3, :3] = np.column_stack([first, np.cross(across, first), across])
    return Shape(coal.Cylinder(disc, length) if disc else coal.Capsule(ball, length), pose, element)


def triangles(mesh: Mesh) -> Any:
    """The triangles of a mesh as coal's tree."""
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(len(mesh.faces), len(mesh.vertices))
    tree.addVertices(np.ascontiguousarray(mesh.vertices))
    tree.addTriangles(mesh.faces.astype(np.uint64))
    tree.endModel()
    return tree
