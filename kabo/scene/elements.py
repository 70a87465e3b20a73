"""Elements: the meshes and primitive shapes that a link or a body consists of, round ones exactly.

A body is the union of its elements. The shape of a box, sphere, capsule or cylinder is the hull of its corners with
its rounding; the mesh of a round one lies around it, and serves pictures, hulls and exact geometry.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from kabo.arrays import Array
from kabo.language.formulas import Place
from kabo.meshes import Mesh, Rounding

ElementKind = Literal["mesh", "box", "sphere", "capsule", "cylinder"]


@dataclass(frozen=True)
class Element:
    """A piece of a body, in the frame of its link or body [m].

    `corners` (V, 3) are None for a mesh; of a box there are eight, of a sphere one, of a capsule and of a cylinder
    two, the ends of its axis. `rounding` is what is added to their hull; None for meshes and boxes.
    """

    kind: ElementKind
    mesh: Mesh
    corners: Array | None = None
    rounding: Rounding | None = None
    place: Place | None = field(default=None, compare=False)  # of its entry in the URDF or scene file
    path: Path | None = field(default=None, compare=False)  # of the file of a mesh

    def moved(self, matrix: Array) -> "Element":
        """This element moved by a rigid transform (4, 4)."""
        if np.array_equal(matrix, np.eye(4)):
            return self
        rotation = matrix[:3, :3]
        corners = None if self.corners is None else self.corners @ rotation.T + matrix[:3, 3]
        rounding = None if self.rounding is None else self.rounding.turned(rotation)
        return Element(self.kind, self.mesh.moved(matrix), corners, rounding, self.place, self.path)


def one_mesh(meshes: Sequence[Mesh]) -> Mesh | None:
    """The meshes of all elements as one; None without meshes."""
    if len(meshes) <= 1:
        return meshes[0] if meshes else None
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)])
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), faces)
