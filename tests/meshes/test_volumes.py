"""The volume of a closed mesh, beside a library that is not ours, wherever the mesh lies."""

import numpy as np
import pytest
import trimesh

from kabo.meshes import Mesh, volume_of

SHAPES = (
    trimesh.creation.icosphere(2),
    trimesh.creation.annulus(0.3, 0.5, 0.1),
    trimesh.creation.capsule(1.0, 0.2),
)


@pytest.mark.parametrize("seed", range(12))
def test_the_volume_is_the_same_wherever_a_mesh_lies_and_below_zero_inside_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = SHAPES[seed % len(SHAPES)].copy()
    expected = float(shape.volume)
    shape.apply_transform(trimesh.transformations.random_rotation_matrix(rng.random(3)))
    vertices, faces = np.array(shape.vertices) + rng.uniform(-100.0, 100.0, 3), np.array(shape.faces, np.int64)
    assert volume_of(Mesh(vertices, faces)) == pytest.approx(expected, rel=1e-9)
    assert volume_of(Mesh(vertices, faces[:, ::-1])) == pytest.approx(-expected, rel=1e-9)
