"""The shapes of a scene as meshes: files in metres, and primitives that enclose their solid."""

import numpy as np

from kabo.language.formulas import Place
from kabo.language.scene_description import Shape
from kabo.meshes import Mesh, load_mesh, outwards

CYLINDER_SIDES = 64  # sides of the prism that circumscribes a cylinder


def primitive(shape: Shape) -> Mesh:
    """The mesh of a box, cylinder (axis z, centred) or sphere; meshes of round shapes circumscribe the solid."""
    import trimesh

    if shape.size is None:
        raise ValueError(f"a {shape.kind} needs a size")
    if shape.kind == "box":
        made = trimesh.creation.box(extents=shape.size)
    elif shape.kind == "cylinder":
        made = trimesh.creation.cylinder(
            shape.size[0] / np.cos(np.pi / CYLINDER_SIDES), shape.size[2], sections=CYLINDER_SIDES
        )
    else:
        made = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
        inner = float(np.min(np.einsum("ij,ij->i", made.face_normals, made.triangles[:, 0])))
        made.apply_scale(shape.size[0] / inner)
    return Mesh(np.ascontiguousarray(made.vertices, dtype=np.float64), np.asarray(made.faces, dtype=np.int64))


def mesh_of(shape: Shape, place: Place | None) -> Mesh:
    """The mesh of any shape, in its owner's frame [m], with inside-out components turned."""
    if shape.kind == "mesh":
        if shape.path is None:
            raise ValueError("a mesh needs a path")
        return outwards(load_mesh(shape.path, shape.scale, shape.place or place))[0]
    return primitive(shape)
