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
from kabo.errors import MeshError
from kabo.language.formulas import Place
from kabo.meshes import Mesh, Rounding, hollow_pieces, hull_of, require_closed

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


def is_open(element: Element) -> bool:
    """Whether an element is a mesh that is not closed, so that it has no inside."""
    if element.kind != "mesh":
        return False
    try:
        require_closed(element.mesh)
    except MeshError:
        return True
    return False


def with_hulls(elements: Sequence[Element]) -> tuple[Element, ...]:
    """The elements with each open mesh replaced by its convex hull; if none is open, with each mesh replaced.

    Of an open mesh, closed pieces that are far from convex stay as they are, and the hull is that of the rest. If what is
    to be replaced is flat, and has no hull, the hull of all elements stands for them.

    Raises:
        MeshError: all elements lie in a plane.
    """
    opened = [is_open(element) for element in elements]
    try:
        if not any(opened):
            return tuple(_hull(each, each.mesh) if each.kind == "mesh" else each for each in elements)
        found: list[Element] = []
        for each, is_opened in zip(elements, opened, strict=True):
            found += _pieces(each) if is_opened else [each]
        return tuple(found)
    except MeshError:
        whole = one_mesh([element.mesh for element in elements])
        if whole is None or len(elements) == 1:
            raise
        return (_hull(elements[0], whole),)


def _hull(element: Element, mesh: Mesh) -> Element:
    """The convex hull of a mesh in place of an element."""
    return Element("mesh", hull_of(mesh), place=element.place)


def _pieces(element: Element) -> list[Element]:
    """An open mesh as its closed pieces that are far from convex, and the hull of the rest."""
    kept, rest = hollow_pieces(element.mesh)
    found = [Element("mesh", piece, place=element.place, path=element.path) for piece in kept]
    return found if rest is None else [*found, _hull(element, rest)]
