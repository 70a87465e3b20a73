"""Groups of a mesh's components that may be bounded one by one: no group crosses itself, cavities stay with their solids.

Contraction keeps a mesh without crossings free of them, and then its winding number is 0 or 1 everywhere. Where faces
cross already it could make pieces turn inside out, which lie outside the union; so overlapping components are
contracted separately: what lies within each of them lies within their union.

The solid inside a mesh is also the union of such groups, as long as no group winds around anything negatively that
another one winds around positively; then what is deep in one group is as deep in the solid.
"""

import numpy as np

from kabo.arrays import Array, Integers
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.triangles.convexity import is_convex
from kabo.geometry.triangles.crossings import crossing_faces
from kabo.meshes.nesting import Shell, shells
from kabo.meshes.topology import components, edges_of, labels, neighbours


def groups_without_crossings(vertices: Array, faces: Integers, name: str) -> list[Integers]:
    """The faces (F, 3) of each group of components; one group if no faces cross.

    Args:
        vertices: (V, 3) [m]. faces: (F, 3) of closed components.
        name: the name of the mesh, for errors.

    Raises:
        MeshError: a component crosses itself, or a cavity the surface around it.
    """
    if not crossing_faces(vertices, faces).any():
        return [faces]
    component = components(edges_of(faces), len(faces))
    group = _with_cavities(vertices, faces, component)
    found = [faces[group == number] for number in np.unique(group)]
    crossed = [int(crossing_faces(*_alone(vertices, own)).sum()) for own in found]
    if any(crossed):
        worst = int(np.argmax(crossed))
        said = (
            f"the mesh crosses itself: {crossed[worst]} of the {len(found[worst])} triangles of one component meet "
            "others of it, so no mesh can be proven to lie within"
        )
        remedy = "unite it with itself, e.g. in MeshLab or with manifold3d, or ask for an outer mesh"
        raise MeshError([Diagnostic(name, 1, 1, said, remedy)])
    return found


def uniting_groups(vertices: Array, faces: Integers) -> list[Integers]:
    """The indices of faces (F,) in groups of closed components, such that the solid is the union of the groups' solids.

    A component that is convex and turned outwards, or encloses a positive volume and does not cross itself, winds
    around nothing negatively. Each other one is in the group of all components whose boxes meet its own: in its box
    the whole mesh winds as this group does.
    """
    component = _closed_pieces(faces)
    count = int(component.max()) + 1
    if count == 1:
        return [np.arange(len(faces))]
    found = shells(vertices, faces, component, np.ones(count, bool))
    doubtful = [shell for shell in found if not _winds_positively(vertices, shell)]
    group = _joined(found, doubtful, count)[component]
    return [np.flatnonzero(group == number) for number in np.unique(group)]


def _closed_pieces(faces: Integers) -> Integers:
    """The number of the closed piece (F,) of each face; pieces that touch along an edge are apart if each closes there."""
    edges = edges_of(faces)
    piece = labels(len(faces), *(side // 3 for side in neighbours(edges, ~edges.crowded)))
    count = int(piece.max()) + 1
    shared, index = np.unique(edges.of_side * count + np.repeat(piece, 3), return_inverse=True)
    unbalanced = np.bincount(index.reshape(-1), np.where(edges.forward, 1.0, -1.0)) != 0.0
    left_open = np.zeros(len(edges.ends), bool)
    left_open[shared[unbalanced] // count] = True
    return labels(len(faces), *(side // 3 for side in neighbours(edges, left_open | ~edges.crowded)))


def _winds_positively(vertices: Array, shell: Shell) -> bool:
    """Whether a component is proven to wind around no point negatively."""
    if not shell.volume > 0.0:
        return False
    own, faces = _alone(vertices, shell.faces)
    return is_convex(own, faces) or not crossing_faces(own, faces).any()


def _with_cavities(vertices: Array, faces: Integers, component: Integers) -> Integers:
    """The number of the group (F,) of each face: a cavity is in the group of all components whose boxes meet its own."""
    count = int(component.max()) + 1
    found = shells(vertices, faces, component, np.ones(count, bool))
    cavities = [shell for shell in found if shell.volume < 0.0]
    grouped: Integers = _joined(found, cavities, count)[component]
    return grouped


def _joined(found: list[Shell], some: list[Shell], count: int) -> Integers:
    """The number of the group of each component: some components are joined with all whose boxes meet theirs."""
    first, second = [], []
    for one in some:
        for other in found:
            if (one.box[0] <= other.box[1]).all() and (other.box[0] <= one.box[1]).all():
                first.append(one.number)
                second.append(other.number)
    return labels(count, np.array(first, np.int64), np.array(second, np.int64))


def _alone(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The vertices and faces of a part of a mesh."""
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3).astype(np.int64)
