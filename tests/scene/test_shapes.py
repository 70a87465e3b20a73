"""Shapes of a scene: primitives enclose their solid."""

import numpy as np
import pytest
import trimesh

from kabo.language.scene_description import Shape
from kabo.scene.shapes import primitive
from tests.meshes.solids import volume


@pytest.mark.parametrize("shape", [Shape("cylinder", size=(0.1, 0.1, 0.4)), Shape("sphere", size=(0.1, 0.1, 0.1))])
def test_a_round_primitive_encloses_its_solid(shape: Shape) -> None:
    made = primitive(shape)
    hull = trimesh.Trimesh(made.vertices, made.faces)
    assert hull.is_watertight
    away = np.einsum("ij,ij->i", hull.face_normals, hull.triangles[:, 0])
    assert away.min() >= 0.1 - 1e-12
    assert np.linalg.norm(made.vertices[:, :2], axis=1).max() <= 0.1 * 1.01


def test_a_box_is_the_one_of_trimesh() -> None:
    size = (0.3, 0.07, 1.1)
    made, theirs = primitive(Shape("box", size=size)), trimesh.creation.box(extents=size)
    assert np.array_equal(made.vertices, theirs.vertices)
    assert np.array_equal(made.faces, theirs.faces)
    assert volume(made) == pytest.approx(np.prod(size))
