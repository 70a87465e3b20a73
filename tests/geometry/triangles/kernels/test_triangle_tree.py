"""Distances to triangles, against rational arithmetic; and the nearest triangle in a tree, against all of them."""

from fractions import Fraction

import numpy as np
import pytest
import trimesh
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.geometry.triangles.kernels import triangle_tree as kernels
from kabo.geometry.triangles.triangle_trees import tree_of

SEEDS = st.integers(0, 2**32 - 1)
SHAPES = ("any", "needle", "cap", "segment", "point", "huge")


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def exact_squared(point, corners):
    """The oracle: the squared distance in rational numbers, the least over the plane (if it falls inside) and the edges."""
    p, *t = [[Fraction(float(x)) for x in row] for row in (point, *corners)]
    found = []
    for k in range(3):
        a, along, away = t[k], minus(t[(k + 1) % 3], t[k]), minus(p, t[k])
        length = dot(along, along)
        part = min(max(dot(away, along) / length, Fraction(0)), Fraction(1)) if length else Fraction(0)
        rest = minus(p, [x + part * y for x, y in zip(a, along, strict=True)])
        found.append(dot(rest, rest))
    u, v, w = minus(t[1], t[0]), minus(t[2], t[0]), minus(p, t[0])
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    area = uu * vv - uv * uv
    if area:
        s, r = (wu * vv - wv * uv) / area, (wv * uu - wu * uv) / area
        if s >= 0 and r >= 0 and s + r <= 1:
            rest = [x - s * y - r * z for x, y, z in zip(w, u, v, strict=True)]
            found.append(dot(rest, rest))
    return float(min(found))


def triangle(rng, kind):
    """Three corners (3, 3): fat, with a short side, with a flat corner, on a line, in a point, or of great size."""
    corners = rng.normal(size=(3, 3))
    tiny = 10.0 ** rng.uniform(-17, -3)
    if kind == "needle":
        corners[2] = corners[1] + tiny * rng.normal(size=3)
    elif kind == "cap":
        corners[2] = corners[0] + rng.random() * (corners[1] - corners[0]) + tiny * rng.normal(size=3)
    elif kind == "segment":
        corners = np.outer(rng.integers(-4, 5, 3), rng.integers(-3, 4, 3)) / 4.0
    elif kind == "point":
        corners[1] = corners[2] = corners[0]
    elif kind == "huge":
        corners *= 10.0 ** rng.uniform(1, 6)
    return corners


def asked(corners, rng):
    """A point anywhere, above the triangle, in it, at a corner, or far away."""
    within = rng.dirichlet(np.ones(3)) @ corners
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    choice = rng.integers(5)
    if choice == 0:
        return rng.normal(size=3)
    if choice == 1:
        return within + normal * rng.normal() * 10.0 ** rng.uniform(-6, 0)
    if choice == 2:
        return within
    return corners[rng.integers(3)].copy() if choice == 3 else 100.0 * rng.normal(size=3)


def measured(seed, kind):
    """For a few points: the distance by the kernel, by the oracle, and the size of it all [m]."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        corners = triangle(rng, kind)
        point = asked(corners, rng)
        squared = kernels.to_triangle_squared(*point, corners[None], 0)
        yield np.sqrt(squared), np.sqrt(exact_squared(point, corners)), np.abs(corners - point).max()


@given(seed=SEEDS, kind=st.sampled_from(SHAPES))
def test_distances_are_never_too_small_whatever_the_triangle(seed, kind):
    """Too small would undo proofs; too large only refuses."""
    for distance, exact, size in measured(seed, kind):
        assert distance >= exact - 2e-15 * size


@given(seed=SEEDS, kind=st.sampled_from(("any", "point", "huge")))
def test_distances_to_healthy_triangles_are_hardly_too_large(seed, kind):
    for distance, exact, size in measured(seed, kind):
        assert distance <= exact + 1e-10 * size


@given(seed=SEEDS, kind=st.sampled_from(("needle", "cap", "segment")))
def test_distances_to_slivers_are_hardly_too_large(seed, kind):
    for distance, exact, size in measured(seed, kind):
        assert distance <= exact + 1e-7 * size


def test_a_point_of_the_triangle_is_nowhere_else():
    triangles = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    for point in ([0, 0, 0], [0.25, 0.5, 0], [0.5, 0.5, 0], [0, 0.75, 0], [0, 1, 0]):
        assert kernels.to_triangle_squared(*map(float, point), triangles, 0) == 0.0
    assert kernels.to_triangle_squared(0.25, 0.25, -3.0, triangles, 0) == 9.0
    assert kernels.to_triangle_squared(2.0, -1.0, 2.0, triangles, 0) == 6.0


def mesh_of(name, rng):
    """Vertices and faces: some have many equal triangles, or many equal middles."""
    if name == "ball":
        made = trimesh.creation.icosphere(subdivisions=2)
    elif name == "box":
        made = trimesh.creation.box().subdivide()
    elif name == "one":
        return rng.normal(size=(3, 3)), np.array([[0, 1, 2]])
    elif name == "equal":
        return rng.normal(size=(4, 3)), np.array([[0, 1, 2]] * 9 + [[1, 2, 3]] * 8)
    elif name == "fan":
        angle = 2 * np.pi * np.arange(200) / 200
        vertices = np.concatenate([np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1), [[0, 0, 0.3]]])
        i = np.arange(200)
        return vertices, np.stack([i, (i + 1) % 200, 0 * i + 200], axis=1)
    else:
        return rng.normal(size=(60, 3)), rng.integers(0, 60, (int(rng.integers(2, 90)), 3))
    return np.array(made.vertices), np.array(made.faces, np.int64)


MESHES = ("ball", "box", "one", "equal", "fan", "soup")


@pytest.mark.parametrize("name", MESHES)
def test_a_tree_has_every_triangle_once_and_boxes_around_them(name):
    vertices, faces = mesh_of(name, np.random.default_rng(0))
    tree = tree_of(vertices, faces)
    assert sorted(tree.order) == list(range(len(faces)))
    assert np.array_equal(tree.triangles, vertices[faces[tree.order]])
    seen, pending = np.zeros(len(faces), int), [(0, np.array([-np.inf] * 3 + [np.inf] * 3))]
    visited = 0
    while pending:
        node, around = pending.pop()
        visited += 1
        box, (first, second) = tree.boxes[node], tree.children[node]
        assert (box[:3] >= around[:3]).all() and (box[3:] <= around[3:]).all()
        if first >= 0:
            pending += [(first, box), (second, box)]
            continue
        inside = tree.triangles[-1 - first : -1 - first + second].reshape(-1, 3)
        seen[-1 - first : -1 - first + second] += 1
        assert 1 <= second <= kernels.LEAF_TRIANGLES
        assert np.array_equal(box, np.concatenate([inside.min(axis=0), inside.max(axis=0)]))
    assert (seen == 1).all() and visited == len(tree.boxes)


@given(seed=SEEDS, name=st.sampled_from(MESHES))
def test_the_nearest_triangle_is_the_nearest_of_all(seed, name):
    rng = np.random.default_rng(seed)
    vertices, faces = mesh_of(name, rng)
    tree, stack = tree_of(vertices, faces), np.empty(64, np.int64)
    for point in (rng.normal(size=3), 1e-3 * rng.normal(size=3), vertices[rng.integers(len(vertices))]):
        hint = int(rng.integers(len(faces)))
        squared, found = kernels.nearest_triangle(tree, *point, hint, 0.0, stack)
        everyone = [kernels.to_triangle_squared(*point, tree.triangles, t) for t in range(len(faces))]
        assert squared == min(everyone) == everyone[found]


@given(seed=SEEDS, enough=st.sampled_from([1e-6, 0.01, 0.5]))
def test_any_triangle_that_is_near_enough_will_do_and_only_such(seed, enough):
    rng = np.random.default_rng(seed)
    vertices, faces = mesh_of("ball", rng)
    tree, stack = tree_of(vertices, faces), np.empty(64, np.int64)
    point, hint = rng.normal(size=3), int(rng.integers(len(faces)))
    nearest, _ = kernels.nearest_triangle(tree, *point, hint, 0.0, stack)
    squared, found = kernels.nearest_triangle(tree, *point, hint, enough, stack)
    event("near enough" if nearest <= enough else "too far")
    assert squared == kernels.to_triangle_squared(*point, tree.triangles, found)
    assert squared == nearest or nearest <= squared <= enough


def test_trimesh_measures_the_same():
    rng = np.random.default_rng(2)
    vertices, faces = mesh_of("box", rng)
    tree, stack, points = tree_of(vertices, faces), np.empty(64, np.int64), rng.normal(size=(200, 3))
    found = [kernels.nearest_triangle(tree, *point, 0, 0.0, stack)[0] for point in points]
    _, expected, _ = trimesh.proximity.closest_point_naive(trimesh.Trimesh(vertices, faces, process=False), points)
    assert np.sqrt(found) == pytest.approx(expected, abs=1e-12)


def test_faces_and_triangles_are_measured_alike():
    rng = np.random.default_rng(3)
    vertices, faces = mesh_of("soup", rng)
    triangles = np.ascontiguousarray(vertices[faces])
    for f in range(len(faces)):
        point = rng.normal(size=3)
        expected = kernels.origin_squared(*(triangles[f] - point).ravel())
        assert kernels.to_face_squared(*point, vertices, faces, f) == expected
        assert kernels.to_triangle_squared(*point, triangles, f) == expected


def test_a_tree_of_very_many_equal_triangles_stays_shallow():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    tree = tree_of(vertices, np.tile([[0, 1, 2]], (20_000, 1)))
    depth = np.zeros(len(tree.boxes), int)
    for node, (first, second) in enumerate(tree.children):
        if first >= 0:
            depth[[first, second]] = depth[node] + 1
    assert depth.max() <= 20


def test_compiled_and_original_agree():
    rng = np.random.default_rng(4)
    for kind in SHAPES:
        for _ in range(20):
            corners = triangle(rng, kind)
            numbers = (corners - asked(corners, rng)).ravel()
            compiled = kernels.origin_squared(*numbers)
            assert compiled == pytest.approx(kernels.origin_squared.py_func(*numbers), rel=1e-9, abs=1e-300)
    vertices, faces = mesh_of("soup", rng)
    triangles, made = vertices[faces], []
    for build in (kernels.build_tree, kernels.build_tree.py_func):
        count = len(triangles)
        boxes, children, order = np.zeros((2 * count, 6)), np.zeros((2 * count, 2), np.int64), np.arange(count)
        nodes = build(triangles, order, np.empty(count), boxes, children, np.empty((128, 3), np.int64))
        made.append((nodes, order.tolist(), boxes.tolist(), children.tolist()))
    assert made[0] == made[1]
