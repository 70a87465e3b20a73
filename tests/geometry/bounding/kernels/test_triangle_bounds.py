"""Proven distances of triangles: never below what sampling reaches, and found where there is some room."""

import numpy as np
import pytest
import trimesh
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.geometry.bounding.kernels import triangle_bounds as kernels
from kabo.geometry.triangles.triangle_trees import tree_of
from tests.geometry.surfaces import distances_to_surface

SEEDS = st.integers(0, 2**32 - 1)
MESHES = ("ball", "box", "cone", "disc")


def mesh_of(name):
    """Vertices and faces: round, edged, with an apex of 200 triangles, or flat."""
    if name == "ball":
        made = trimesh.creation.icosphere(subdivisions=2)
        return np.array(made.vertices), np.array(made.faces, np.int64)
    if name == "box":
        made = trimesh.creation.box().subdivide()
        return np.array(made.vertices), np.array(made.faces, np.int64)
    angle, i = 2 * np.pi * np.arange(200) / 200, np.arange(200)
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    apex = [[0.1, 0.0, 1.0 if name == "cone" else 0.0]]
    return np.concatenate([rim, apex]), np.stack([i, (i + 1) % 200, 0 * i + 200], axis=1)


TREES = {name: (*mesh_of(name), tree_of(*mesh_of(name))) for name in MESHES}
STEPS = 12
FINE = np.array([(i, j, STEPS - i - j) for i in range(STEPS + 1) for j in range(STEPS + 1 - i)]) / STEPS


def bounded(triangle, limit, tree, hint=0, bound=kernels.triangle_bound):
    """The proven bound [m], or inf."""
    pieces = np.full((64, kernels.PIECE_COLUMNS), np.nan)
    pieces[0, :9] = triangle.ravel()
    squared, near = bound(pieces, limit * limit, tree, hint, np.empty(64, np.int64), np.array([4000]))
    assert 0 <= near < len(tree.triangles)
    return np.sqrt(squared)


@st.composite
def triangles(draw):
    """A triangle near a mesh: one of its own, shaken; one that bridges two places; or any."""
    rng, name = np.random.default_rng(draw(SEEDS)), draw(st.sampled_from(MESHES))
    vertices, faces, tree = TREES[name]
    kind = draw(st.sampled_from(["shaken", "bridge", "chord", "any"]))
    if kind == "shaken":
        triangle = vertices[faces[rng.integers(len(faces))]] + 10.0 ** rng.uniform(-6, -1) * rng.normal(
            size=(3, 3)
        )
    elif kind == "bridge":
        centre = tree.triangles[rng.integers(len(faces))].mean(axis=0)
        near = np.argsort(np.linalg.norm(vertices - centre, axis=1))[:12]
        triangle = vertices[rng.choice(near, 3, replace=False)]
    elif kind == "chord":
        triangle = vertices[rng.choice(len(vertices), 3, replace=False)]
    else:
        triangle = rng.normal(size=(3, 3))
    return name, kind, np.ascontiguousarray(triangle), int(rng.integers(len(faces)))


def sampled(triangle, vertices, faces):
    """The greatest distance of many points of a triangle [m]."""
    return distances_to_surface(FINE @ triangle, vertices, faces).max()


@given(drawn=triangles(), factor=st.floats(0.3, 3.0))
def test_a_bound_holds_for_every_point_and_keeps_the_limit(drawn, factor):
    name, _, triangle, hint = drawn
    vertices, faces, tree = TREES[name]
    farthest = sampled(triangle, vertices, faces)
    limit = max(1e-9, factor * farthest)
    bound = bounded(triangle, limit, tree, hint)
    event("proven" if bound < np.inf else "not proven")
    if bound < np.inf:
        assert farthest <= bound * (1.0 + 1e-12) + 1e-15
        assert bound <= limit * (1.0 + 1e-15)


@given(drawn=triangles())
def test_a_triangle_with_a_tenth_of_room_is_accepted(drawn):
    name, kind, triangle, hint = drawn
    vertices, faces, tree = TREES[name]
    event(kind)
    # What lies between the samples is not farther than half their spacing.
    spacing = max(np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1)) / STEPS
    limit = (sampled(triangle, vertices, faces) + spacing) / 0.9
    assert bounded(triangle, limit, tree, hint) <= limit


@given(drawn=triangles(), share=st.floats(0.0, 0.99))
def test_a_triangle_that_reaches_farther_is_refused(drawn, share):
    name, _, triangle, hint = drawn
    vertices, faces, tree = TREES[name]
    farthest = sampled(triangle, vertices, faces)
    if farthest > 1e-9:
        assert bounded(triangle, share * farthest, tree, hint) == np.inf


@pytest.mark.parametrize("name", MESHES)
def test_triangles_of_the_mesh_are_at_no_distance(name):
    vertices, faces, tree = TREES[name]
    for triangle in vertices[faces[::7]]:
        assert bounded(triangle, 1e-12, tree) <= 1e-12


def test_a_triangle_over_a_fan_of_two_hundred_is_proven_with_room():
    """Nearest are a hundred and more triangles that meet in a point: half the limit is needed to end within the pieces."""
    tree = TREES["disc"][2]
    triangle = np.array([[-0.5, -0.4, 0.01], [0.5, -0.4, 0.01], [0.0, 0.6, 0.01]])
    assert 0.01 <= bounded(triangle, 0.02, tree) <= 0.02
    assert bounded(triangle, 0.0099, tree) == np.inf


@pytest.mark.parametrize("corners", [[[0.2, 0.1, 0.3]] * 3, [[0.0, 0, 0.2], [0.4, 0, 0.2], [0.2, 0, 0.2]]])
def test_triangles_without_area_are_measured_too(corners):
    vertices, faces, tree = TREES["disc"]
    triangle = np.array(corners)
    farthest = sampled(triangle, vertices, faces)
    assert farthest <= bounded(triangle, 1.05 * farthest, tree) * (1 + 1e-12) <= 1.06 * farthest
    assert bounded(triangle, 0.95 * farthest, tree) == np.inf


def directed(
    triangles, tree, relative=0.01, floor=1e-6, ceiling=np.inf, bounds=kernels.directed_bounds, reached=0.0
):
    return bounds(
        np.ascontiguousarray(triangles),
        tree,
        reached,
        relative,
        floor,
        ceiling,
        np.empty((256, 16)),
        np.empty(64, np.int64),
    )


@given(name=st.sampled_from(MESHES), other=st.sampled_from(MESHES), seed=SEEDS)
def test_directed_bounds_enclose_what_sampling_reaches(name, other, seed):
    rng = np.random.default_rng(seed)
    vertices, faces, tree = TREES[name]
    moved = TREES[other][0][TREES[other][1][rng.integers(0, len(TREES[other][1]), 3)]]
    moved = moved + rng.normal(size=3) * 10.0 ** rng.uniform(-6, 0)
    low, high = directed(moved, tree)
    farthest = max(sampled(triangle, vertices, faces) for triangle in moved)
    assert low <= high <= max(1e-6, low * np.sqrt(1.01)) * (1 + 1e-12)
    assert farthest <= high * (1 + 1e-12) + 1e-15
    # A distance that is reached is one that denser and denser samples come near.
    assert low <= farthest + 2.0 * max(np.ptp(moved, axis=1).max(), 1e-9) / STEPS


@given(drawn=triangles(), known=st.floats(1e-3, 1.0))
def test_what_is_known_to_be_reached_is_where_bounds_begin(drawn, known):
    name, _, triangle, _ = drawn
    vertices, faces, tree = TREES[name]
    low, high = directed(triangle[None], tree, reached=known)
    assert known * (1 - 1e-15) <= low <= high <= max(1e-6, low * np.sqrt(1.01)) * (1 + 1e-12)
    assert sampled(triangle, vertices, faces) <= high * (1 + 1e-12) + 1e-15
    found = kernels.farthest_sample(triangle[None], tree, known, np.empty(64, np.int64))
    points = np.vstack([triangle, triangle.mean(axis=0)])
    farthest = max(known, distances_to_surface(points, vertices, faces).max())
    assert found == pytest.approx(farthest, rel=1e-12, abs=1e-15)


@given(drawn=triangles(), share=st.floats(1.0001, 1.3))
def test_a_bound_stays_below_a_ceiling_that_can_be_shown(drawn, share):
    name, _, triangle, _ = drawn
    tree = TREES[name][2]
    low, high = directed(triangle[None], tree, relative=0.01, floor=1e-4)
    ceiling = share * max(high, 1e-4)
    assert directed(triangle[None], tree, relative=0.5, floor=1.0, ceiling=ceiling)[1] <= ceiling * (1 + 1e-15)
    assert directed(triangle[None], tree, relative=0.5, floor=1.0)[1] >= low * (1 - 1e-12)


def test_cut_pieces_are_the_piece():
    """Both halves share the new corner, keep their turn, and have the area of the whole."""
    rng = np.random.default_rng(1)
    tree = TREES["ball"][2]
    for level in range(10):
        for _ in range(20):
            pieces = np.zeros((2, kernels.PIECE_COLUMNS))
            pieces[0, :9], pieces[0, kernels.DEPTH_COLUMN] = rng.normal(size=9), level
            pieces[0, kernels.NEAREST_COLUMNS : kernels.NEAREST_COLUMNS + 3] = rng.choice(
                len(tree.triangles), 3, replace=False
            )
            whole = pieces[0, :9].reshape(3, 3).copy()
            corner, *place = kernels.cut(pieces, 0, tree.triangles, 0.0)
            halves = pieces[:, :9].reshape(2, 3, 3)
            assert np.array_equal(halves[0, corner], place) and np.array_equal(halves[1, (corner + 2) % 3], place)
            normals = [np.cross(t[1] - t[0], t[2] - t[0]) for t in (whole, *halves)]
            assert normals[1] + normals[2] == pytest.approx(normals[0], abs=1e-12)
            assert all(normal @ normals[0] >= 0 for normal in normals[1:])
            assert (pieces[:, kernels.DEPTH_COLUMN] == level + 1).all()
            kernels.set_new_corner(pieces, 0, corner, 7.0, 5)
            assert (
                pieces[0, kernels.DISTANCE_COLUMNS + corner]
                == pieces[1, kernels.DISTANCE_COLUMNS + (corner + 2) % 3]
                == 7.0
            )
            assert (
                pieces[0, kernels.NEAREST_COLUMNS + corner]
                == pieces[1, kernels.NEAREST_COLUMNS + (corner + 2) % 3]
                == 5
            )


def test_compiled_and_original_agree():
    rng = np.random.default_rng(6)
    for name in MESHES:
        vertices, faces, tree = TREES[name]
        triangle = vertices[faces[3]] + 0.05 * rng.normal(size=(3, 3))
        limit = 1.05 * sampled(triangle, vertices, faces)
        bounds = [
            bounded(triangle, limit, tree, 0, b) for b in (kernels.triangle_bound, kernels.triangle_bound.py_func)
        ]
        assert bounds[0] == pytest.approx(bounds[1], rel=1e-6) and bounds[0] <= limit
        pair = [
            directed(triangle[None], tree, bounds=b)
            for b in (kernels.directed_bounds, kernels.directed_bounds.py_func)
        ]
        assert pair[0] == pytest.approx(pair[1], rel=1e-6)
