"""Whether a mesh is closed is asked for alone, and with all counts of its defects: both say the same."""

import numpy as np
import trimesh

from kabo.meshes import Mesh, examine
from kabo.meshes.soundness import is_closed

CASES = 300


def spoilt(seed: int) -> Mesh:
    """A ball or two; by chance faces are missing, turned or degenerate, or name no vertex, or a vertex is not finite."""
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(subdivisions=1)
    vertices, faces = np.array(ball.vertices), np.array(ball.faces, np.int64)
    if rng.random() < 0.3:
        faces = np.vstack([faces, faces + len(vertices)])
        vertices = np.vstack([vertices, vertices + 3.0])
    if rng.random() < 0.3:
        faces = np.delete(faces, rng.integers(len(faces), size=rng.integers(1, 4)), axis=0)
    if rng.random() < 0.2:
        faces[rng.integers(len(faces))] = faces[rng.integers(len(faces))][::-1]
    if rng.random() < 0.2:
        faces = np.vstack([faces, [[3, 4, 4]]])
    if rng.random() < 0.1:
        faces = np.vstack([faces, [[0, 1, len(vertices)]]])
    if rng.random() < 0.1:
        vertices[rng.integers(len(vertices))] = np.nan
    return Mesh(vertices, faces)


def test_a_mesh_is_closed_as_the_counts_of_its_defects_say():
    meshes = [spoilt(seed) for seed in range(CASES)]
    meshes.append(Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64)))
    found = [is_closed(mesh) for mesh in meshes]
    assert found == [examine(mesh).is_closed for mesh in meshes]
    assert 50 < sum(found) < CASES - 50
