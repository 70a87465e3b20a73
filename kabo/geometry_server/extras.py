"""Extra bodies: geometry that exists only for some stages of a task, given as a shape or as padding around a thing."""

from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.language.scene_description import Shape
from kabo.scene import Element, Mesh, element_of
from kabo.scene.transforms import transform


@dataclass(frozen=True)
class Extra:
    """A body attached to `parent` (`world`, a body or `robot.link`) at a pose in its frame.

    `pads`: whether this body is padding around its parent, with the parent's permitted contacts.
    """

    name: str
    parent: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    element: Element = field(compare=False)
    digest: str  # of the mesh
    shape: Shape = field(compare=False)
    pads: bool = False

    @property
    def mesh(self) -> Mesh:
        """The mesh of the body, around it if it is round."""
        return self.element.mesh

    @property
    def parent_T(self) -> Array:  # noqa: N802
        """The pose (4, 4) of this body in its parent's frame."""
        return transform(self.position, self.quaternion)


def extra(
    name: str,
    parent: str,
    shape: Shape,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    quaternion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
) -> Extra:
    """An extra body with the given shape, attached to `parent` at a position and orientation in the parent's frame."""
    element = element_of(shape, None)
    return Extra(name, parent, position, quaternion, element, element.mesh.digest, shape)


def padding(name: str, parent: str, vertices: Array, distance: float) -> Extra:
    """A cylinder about a thing's z axis that contains every point within `distance` [m] of its vertices (V, 3)."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle = (low + high) / 2
    radius = float(np.linalg.norm(vertices[:, :2] - middle[:2], axis=1).max()) + distance
    height = float(high[2] - low[2]) + 2 * distance
    shape = Shape("cylinder", size=(radius, radius, height))
    element = element_of(shape, None)
    x, y, z = (float(v) for v in middle)
    return Extra(name, parent, (x, y, z), (0.0, 0.0, 0.0, 1.0), element, element.mesh.digest, shape, pads=True)
