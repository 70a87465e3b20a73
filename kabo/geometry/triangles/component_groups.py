"""Groups of a mesh's components that may be bounded one by one: no group crosses itself, cavities stay with their solids.

Contraction keeps a mesh without crossings free of them, and then its winding number is 0 or 1 everywhere. Where faces
cross already it could make pieces turn inside out, which lie outside the union; so overlapping components are
contracted separately: what lies within each of them lies within their union.
"""

import numpy as np

from kabo.arrays import Array, Integers
from kabo.errors import Diagnostic, MeshError
from kabo.geometry.triangles.crossings import crossing_faces
from kabo.meshes.nesting import shells
from kabo.meshes.topology import components, edges_of, labels


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


def _with_cavities(vertices: Array, faces: Integers, component: Integers) -> Integers:
    """The number of the group (F,) of each face: a cavity is in the group of all components whose boxes meet its own."""
    count = int(component.max()) + 1
    found = shells(vertices, faces, component, np.ones(count, bool))
    first, second = [], []
    for cavity in (shell for shell in found if shell.volume < 0.0):
        for other in found:
            if (cavity.box[0] <= other.box[1]).all() and (other.box[0] <= cavity.box[1]).all():
                first.append(cavity.number)
                second.append(other.number)
    joined = labels(count, np.array(first, np.int64), np.array(second, np.int64))
    grouped: Integers = joined[component]
    return grouped


def _alone(vertices: Array, faces: Integers) -> tuple[Array, Integers]:
    """The vertices and faces of a part of a mesh."""
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3).astype(np.int64)
