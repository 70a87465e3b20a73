"""Counts of the defects of a mesh; the mesh is neither changed nor refused."""

from dataclasses import dataclass

import numpy as np

from kabo.meshes.mesh import Faces, Mesh, Vertices
from kabo.meshes.nesting import inside_out, shells
from kabo.meshes.topology import Edges, Mask, components, edges_of, holes, pinched, repeating


@dataclass(frozen=True)
class Soundness:
    """The sizes of a mesh and the counts of all defects that keep it from bounding a solid.

    Edges, components and areas are counted on faces that have three different, existing, finite vertices.
    """

    vertices: int
    faces: int
    not_finite: int  # vertices
    out_of_range: int  # faces that name a vertex that is not there
    repeated: int  # faces that name a vertex twice
    zero_area: int  # faces whose three vertices lie on a line
    duplicates: int  # faces on the same three vertices as another one
    edges: int
    borders: int  # edges of one face
    holes: int  # loops of such edges
    crowded: int  # edges of three faces or more
    unbalanced: int  # edges not passed equally often in both directions: 0 on a closed surface
    turned: int  # edges between two faces of opposite orientation
    pinched: int  # vertices where surfaces touch
    components: int
    inside_out: int  # closed components that are turned inside out
    extent: float  # the longest side of the bounding box [m]

    @property
    def is_closed(self) -> bool:
        """Whether every edge is passed equally often in both directions, so that winding numbers are whole."""
        return self.faces > 0 and not (self.not_finite or self.out_of_range or self.unbalanced)


def examine(mesh: Mesh) -> Soundness:
    """The counts of all defects of a mesh."""
    vertices, faces = _arrays(mesh)
    finite, present, numbers = _existing(vertices, faces)
    distinct = _distinct_corners(faces)
    usable = faces[numbers & distinct]
    edges = edges_of(usable)
    component = components(edges, len(usable)) if len(usable) else np.empty(0, dtype=np.int64)
    return Soundness(
        vertices=len(vertices),
        faces=len(faces),
        not_finite=int((~finite).sum()),
        out_of_range=int((~present).sum()),
        repeated=int((present & ~distinct).sum()),
        zero_area=int(flat(vertices, usable).sum()),
        duplicates=int(repeating(np.sort(usable, axis=1)).sum()),
        edges=len(edges.ends),
        borders=int(edges.border.sum()),
        holes=holes(edges),
        crowded=int(edges.crowded.sum()),
        unbalanced=int((edges.balance != 0).sum()),
        turned=int(edges.turned.sum()),
        pinched=pinched(usable, edges),
        components=int(component.max()) + 1 if len(usable) else 0,
        inside_out=len(turned_components(vertices, usable, edges, component)) if len(usable) else 0,
        extent=float(np.ptp(vertices[finite], axis=0).max()) if finite.any() else 0.0,
    )


def is_closed(mesh: Mesh) -> bool:
    """`Soundness.is_closed` of a mesh, without its other counts, which take many times as long."""
    vertices, faces = _arrays(mesh)
    finite, present, _ = _existing(vertices, faces)
    if not len(faces) or not finite.all() or not present.all():
        return False
    return not edges_of(faces[_distinct_corners(faces)]).balance.any()


def turned_components(vertices: Vertices, faces: Faces, edges: Edges, component: Faces) -> list[int]:
    """The numbers of the closed components that are inside out."""
    closed = closed_components(edges, component)
    return inside_out(vertices, shells(vertices, faces, component, closed))


def closed_components(edges: Edges, component: Faces) -> Mask:
    """A mask (C,) of the closed components, whose edges are all passed equally often in both directions."""
    closed = np.ones(int(component.max()) + 1, dtype=bool)
    open_sides = np.flatnonzero(edges.balance[edges.of_side] != 0)
    closed[component[open_sides // 3]] = False
    return closed


def flat(vertices: Vertices, faces: Faces) -> Mask:
    """A mask (F,) of the faces whose area is 0 within the precision of their coordinates."""
    if not len(faces):
        return np.zeros(0, dtype=bool)
    corners = vertices[faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.linalg.norm(np.cross(first, second), axis=1)
    longest = np.sqrt(np.maximum((first**2).sum(axis=1), (second**2).sum(axis=1)))
    rounding = 4.0 * np.finfo(np.float64).eps * np.abs(corners).max(axis=(1, 2))
    without_area: Mask = area <= longest * rounding
    return without_area


def _arrays(mesh: Mesh) -> tuple[Vertices, Faces]:
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64).reshape(-1, 3)


def _existing(vertices: Vertices, faces: Faces) -> tuple[Mask, Mask, Mask]:
    """The vertices that are finite (V,); the faces whose vertices are there (F,), and are finite besides (F,)."""
    finite = np.asarray(np.isfinite(vertices).all(axis=1))
    present = np.asarray(((faces >= 0) & (faces < len(vertices))).all(axis=1))
    numbers = present.copy()
    numbers[present] = finite[faces[present]].all(axis=1)
    return finite, present, numbers


def _distinct_corners(faces: Faces) -> Mask:
    distinct: Mask = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return distinct
