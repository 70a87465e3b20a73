"""The shapes of a scene as elements: mesh files in metres, boxes, and round primitives with meshes around them."""

from itertools import product

import numpy as np

from kabo.arrays import Array
from kabo.language.formulas import Place
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, Rounding, hull_of, load_mesh, outwards
from kabo.scene.elements import Element

CYLINDER_SIDES = 64  # sides of the prism that circumscribes a cylinder
SPHERE_SUBDIVISIONS, CAP_SUBDIVISIONS = 4, 3  # of the icosahedra around a sphere, and around the ends of a capsule


# Most scenes have no round shape, and loading trimesh takes longer than all the rest of them.
_UNIT_BOX = np.array(list(product((-0.5, 0.5), repeat=3)))
_BOX_FACES = np.array(
    [(1, 3, 0), (4, 1, 0), (0, 3, 2), (2, 4, 0), (1, 7, 3), (5, 1, 4), (5, 7, 1), (3, 7, 2), (6, 4, 2), (2, 7, 6)]
    + [(6, 5, 4), (7, 5, 6)]
)


def element_of(shape: Shape, place: Place | None, mesh: Mesh | None = None) -> Element:
    """The element of any shape, in its owner's frame [m].

    Args:
        shape: the shape; components of its mesh that are inside out are turned.
        place: the place of its owner, for errors about shapes without a place of their own.
        mesh: the mesh of the shape, if it is there already.

    Raises:
        MeshError: the mesh file does not load.
    """
    at, made = shape.place or place, mesh or mesh_of(shape, place)
    if shape.kind == "mesh" or shape.size is None:
        return Element("mesh", made, place=at, path=shape.path)
    if shape.kind == "box":
        return Element("box", made, made.vertices, None, at)
    radius, _, z = shape.size
    if shape.kind == "sphere":
        return Element("sphere", made, np.zeros((1, 3)), Rounding(radius=radius), at)
    ends = np.array([[0.0, 0.0, -z / 2], [0.0, 0.0, z / 2]])
    rounding = Rounding(disc=radius) if shape.kind == "cylinder" else Rounding(radius=radius)
    return Element(shape.kind, made, ends, rounding, at)


def mesh_of(shape: Shape, place: Place | None) -> Mesh:
    """The mesh of any shape, in its owner's frame [m], with inside-out components turned."""
    if shape.kind == "mesh":
        if shape.path is None:
            raise ValueError("a mesh needs a path")
        return outwards(load_mesh(shape.path, shape.scale, shape.place or place))[0]
    return primitive(shape)


def primitive(shape: Shape) -> Mesh:
    """The mesh of a box, or one around a cylinder, a capsule (both along z, centred) or a sphere."""
    if shape.size is None:
        raise ValueError(f"a {shape.kind} needs a size")
    if shape.kind == "box":
        return Mesh(_UNIT_BOX * np.asarray(shape.size), _BOX_FACES.copy())
    if shape.kind == "cylinder":
        import trimesh

        made = trimesh.creation.cylinder(
            shape.size[0] / np.cos(np.pi / CYLINDER_SIDES), shape.size[2], sections=CYLINDER_SIDES
        )
        vertices, faces = made.vertices, made.faces
    elif shape.kind == "capsule":
        return _capsule(shape.size[0], shape.size[2])
    else:
        vertices, faces = _around_ball(shape.size[0], SPHERE_SUBDIVISIONS)
    return Mesh(np.ascontiguousarray(vertices, dtype=np.float64), np.asarray(faces, dtype=np.int64))


def _around_ball(radius: float, subdivisions: int) -> tuple[Array, Array]:
    """Vertices and faces of a mesh around a ball: all its faces touch the ball or lie outside."""
    import trimesh

    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    inner = float(np.min(np.einsum("ij,ij->i", made.face_normals, made.triangles[:, 0])))
    made.apply_scale(radius / inner)
    return made.vertices, made.faces


def _capsule(radius: float, length: float) -> Mesh:
    cap = _around_ball(radius, CAP_SUBDIVISIONS)[0]
    half = np.array([0.0, 0.0, length / 2])
    return hull_of(Mesh(np.concatenate([cap - half, cap + half]), np.zeros((0, 3), dtype=np.int64)))
