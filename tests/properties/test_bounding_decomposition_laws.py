"""[K Def. 3] on random solids: the parts cover all of the solid, and no point of theirs is farther than they say.

Solids are overlapping boxes, so that distance and membership are a line of arithmetic each, and none of it ours.
"""

import os
import sys
import tempfile
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
import trimesh
from hypothesis import event, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from kabo.arrays import Array
from kabo.geometry import bounding_decomposition
from kabo.geometry.bounding.bounding_decomposition import Decomposition
from kabo.meshes import Mesh

EXAMPLES = max(3, int(60 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))))
Box = tuple[Array, Array, Array]  # middle, half sides, rotation


@st.composite
def boxes(draw: st.DrawFn, most: int) -> list[Box]:
    """Some turned boxes, each with a point of the one before in it."""
    found: list[Box] = []
    for _ in range(draw(st.integers(1, most))):
        half = np.array([draw(st.floats(0.01, 0.1)) for _ in range(3)])
        turn = Rotation.from_euler("xyz", [draw(st.sampled_from([0.0, 0.4, 1.1])) for _ in range(3)]).as_matrix()
        place = np.array([draw(st.floats(-0.9, 0.9)) for _ in range(3)])
        middle = found[-1][0] + found[-1][2] @ (place * found[-1][1]) if found else np.zeros(3)
        found.append((middle, half, turn))
    return found


def mesh_of(solid: list[Box]) -> Mesh:
    shapes = []
    for middle, half, turn in solid:
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = turn, middle
        shapes.append(trimesh.creation.box(2 * half, transform=place))
    joined = trimesh.util.concatenate(shapes)
    return Mesh(np.array(joined.vertices, np.float64), np.array(joined.faces, np.int64))


def distance(solid: list[Box], points: Array) -> Array:
    """Of each point to the solid."""
    return np.min(
        [
            np.linalg.norm(np.maximum(np.abs((points - middle) @ turn) - half, 0.0), axis=1)
            for middle, half, turn in solid
        ],
        axis=0,
    )


def points_in(solid: list[Box], rng: np.random.Generator) -> Array:
    """Corners, points of faces and points inside of every box."""
    found = []
    for middle, half, turn in solid:
        unit = rng.uniform(-1, 1, (600, 3))
        unit[:300, :][np.arange(300), rng.integers(0, 3, 300)] = rng.choice([-1.0, 1.0], 300)
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        found.append(middle + (np.vstack([unit, corners]) * half) @ turn.T)
    return np.vstack(found)


@pytest.mark.slow
@settings(max_examples=EXAMPLES)
@given(
    solid_and_share=st.tuples(boxes(most=2), st.just(0.02))
    | st.tuples(boxes(most=4), st.sampled_from([0.05, 0.1])),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_parts_cover_the_solid_and_none_sticks_out_farther_than_said(
    solid_and_share: tuple[list[Box], float], seed: int
) -> None:
    """Both sides of [K Def. 3]."""
    solid, share = solid_and_share
    mesh = mesh_of(solid)
    epsilon = share * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    with tempfile.TemporaryDirectory() as folder:
        made = bounding_decomposition(mesh, epsilon, cache=Path(folder))
    holds(made, solid, epsilon, seed)


@settings(max_examples=max(3, EXAMPLES // 3))
@given(solid=boxes(most=3), share=st.sampled_from([0.05, 0.1]), seed=st.integers(0, 2**32 - 1))
def test_so_it_is_for_meshes_of_so_many_triangles_that_a_coarser_one_is_decomposed(
    solid: list[Box], share: float, seed: int
) -> None:
    mesh = mesh_of(solid)
    fine = Mesh(*trimesh.remesh.subdivide(*trimesh.remesh.subdivide(mesh.vertices, mesh.faces)))
    epsilon = share * float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    module = sys.modules["kabo.geometry.bounding.decomposition"]
    with tempfile.TemporaryDirectory() as folder, patch.object(module, "COARSEN_ABOVE_TRIANGLES", 100):
        made = bounding_decomposition(fine, epsilon, cache=Path(folder))
    holds(made, solid, epsilon, seed)


def holds(made: Decomposition, solid: list[Box], epsilon: float, seed: int) -> None:
    """Fails unless the parts cover the solid within their bounds, as far as some thousand points tell."""
    rng = np.random.default_rng(seed)
    event(f"parts: {min(len(made.parts), 5)}")
    hulls = [ConvexHull(part).equations for part in made.parts]
    points = points_in(solid, rng)
    covered = np.any([(points @ own[:, :3].T + own[:, 3] <= 0.0).all(axis=1) for own in hulls], axis=0)
    assert covered.all(), f"{(~covered).sum()} of {len(points)} points of the solid are in no part"
    for part, bound in zip(made.parts, made.deviations, strict=True):
        inside = np.vstack([part, rng.dirichlet(np.full(len(part), 0.3), 3000) @ part])
        assert distance(solid, inside).max() <= bound <= epsilon
