"""The proven interval of the Hausdorff distance: dense samples lie in it, and it is as narrow as asked for."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry import hausdorff_bound
from kabo.geometry.bounding import hausdorff
from kabo.geometry.bounding.kernels import triangle_bounds
from tests.geometry.surfaces import distances_to_surface

SEEDS = st.integers(0, 2**32 - 1)


def arrays(mesh):
    return np.array(mesh.vertices), np.array(mesh.faces, np.int64)


BALL, BOX = (
    arrays(trimesh.creation.icosphere(subdivisions=1)),
    arrays(trimesh.creation.box(extents=(1.6, 1.2, 1.0))),
)
CONE = arrays(trimesh.creation.cone(radius=0.8, height=1.5, sections=60))
SHAPES = {"ball": BALL, "box": BOX, "cone": CONE}


def samples(vertices, faces, most):
    """Points of the surface (P, 3): corners and a grid on every face, and the greatest gap between them [m]."""
    longest = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2).max()
    n = max(1, int(np.sqrt(2 * most / len(faces))) - 1)
    grid = np.array([(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]) / n
    return np.einsum("gk,fkr->fgr", grid, vertices[faces]).reshape(-1, 3), longest / n


def sampled(first, second, most=1500):
    """The two-sided distance of samples, and what it may lack at most [m]."""
    farthest, gap = 0.0, 0.0
    for one, other in ((first, second), (second, first)):
        points, between = samples(*one, most)
        farthest = max(farthest, distances_to_surface(points, *other).max())
        gap = max(gap, between)
    return farthest, gap


@given(names=st.tuples(*[st.sampled_from(sorted(SHAPES))] * 2), seed=SEEDS, rel=st.sampled_from([1e-3, 0.01, 0.1]))
def test_the_interval_contains_the_sampled_distance_and_is_narrow(names, seed, rel):
    rng = np.random.default_rng(seed)
    (vertices, faces), second = (SHAPES[name] for name in names)
    first = vertices + rng.normal(size=vertices.shape) * 10.0 ** rng.uniform(-5, -0.5), faces
    low, high = hausdorff_bound(*first, *second, rel)
    farthest, gap = sampled(first, second, 150)
    floor = 1e-4 * np.linalg.norm(np.ptp(first[0], axis=0))  # below that the two are not told apart
    assert low <= high <= max((1.0 + rel) * low, floor) * (1.0 + 1e-12)
    assert farthest <= high * (1.0 + 1e-12) + 1e-15
    assert low <= farthest + gap


@given(names=st.tuples(*[st.sampled_from(sorted(SHAPES))] * 2), seed=SEEDS)
def test_both_directions_count_whichever_mesh_is_named_first(names, seed):
    rng = np.random.default_rng(seed)
    (vertices, faces), second = (SHAPES[name] for name in names)
    first = vertices + rng.normal(size=3), faces
    one, two = hausdorff_bound(*first, *second), hausdorff_bound(*second, *first)
    assert max(one[0], two[0]) <= min(one[1], two[1]) * (1.0 + 1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_a_mesh_is_at_no_distance_from_itself_however_it_is_written(name):
    vertices, faces = SHAPES[name]
    smallest = 1e-4 * np.linalg.norm(np.ptp(vertices, axis=0))
    order = np.random.default_rng(0).permutation(len(vertices))
    again = np.argsort(order)[np.roll(faces[::-1], 1, axis=1)]
    for other in ((vertices, faces), (vertices[order], again)):
        low, high = hausdorff_bound(vertices, faces, *other)
        assert low <= 1e-12 and high <= smallest  # slivers are measured to within rounding


def test_a_moved_box_is_as_far_as_it_was_moved():
    vertices, faces = BOX
    for shift in (1e-3, 0.1, 7.0):
        low, high = hausdorff_bound(vertices, faces, vertices + [0.0, 0.0, shift], faces, 1e-3)
        assert low <= shift * (1.0 + 1e-9) and shift <= high * (1.0 + 1e-9) and high <= 1.001 * shift + 1e-9


def test_the_far_side_of_a_thin_spike_is_seen_from_one_mesh_only():
    vertices, faces = BALL
    spiked = vertices.copy()
    spiked[0] *= 3.0
    low, high = hausdorff_bound(vertices, faces, spiked, faces)
    assert low <= 2.0 * (1 + 1e-12) and 2.0 <= high <= 2.03
    farther = distances_to_surface(samples(vertices, faces, 500)[0], spiked, faces).max()
    assert farther < 1.0  # the other direction alone would miss it


def test_distances_between_corners_are_found():
    """The middle of a long face is farthest from a bent one: no corner of either mesh says so."""
    flat = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]])
    roof = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 0.5]])
    bent = roof, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    for pair in ((flat, bent), (bent, flat)):
        low, high = hausdorff_bound(*pair[0], *pair[1], 1e-3)
        assert low <= 0.5 <= high <= 0.5006


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_unit_of_length_does_not_matter(scale):
    first, second = BALL, CONE
    here = hausdorff_bound(*first, *second)
    there = hausdorff_bound(first[0] * scale, first[1], second[0] * scale, second[1])
    assert there == pytest.approx((here[0] * scale, here[1] * scale), rel=0.011)


def test_a_ceiling_that_holds_is_kept():
    loose = hausdorff_bound(*BALL, *BOX, 0.3)
    tight = hausdorff_bound(*BALL, *BOX, 1e-4)
    ceiling = 1.001 * tight[1]
    assert hausdorff_bound(*BALL, *BOX, 0.3, ceiling=ceiling)[1] <= ceiling
    assert tight[0] <= loose[1] and loose[1] <= 1.3 * tight[1]
    # One that does not hold changes nothing.
    assert hausdorff_bound(*BALL, *BOX, 0.3, ceiling=0.5 * tight[0])[1] >= tight[0]


def fans(sections, radius, height):
    """A cone: a fan around its foot, and one around its apex."""
    angles = 2 * np.pi * np.arange(sections) / sections
    rim = np.stack([radius * np.cos(angles), radius * np.sin(angles), 0 * angles], axis=1)
    i = np.arange(sections)
    j, apex, foot = (i + 1) % sections, 0 * i + sections, 0 * i + sections + 1
    faces = np.concatenate([np.stack([i, j, apex], 1), np.stack([j, i, foot], 1)])
    return np.concatenate([rim, [[0, 0, height], [0, 0, 0]]]), faces


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("sections", [40, 160])
def test_wide_fans_are_cut_no_finer_than_the_farthest_point_asks_for(monkeypatch, sections, order):
    """The feet lie in one plane, the apexes are apart: whichever is looked at first, cuts grow with the triangles."""
    cuts = []

    def counted(*arguments):
        cuts.append(1)
        return cut(*arguments)

    cut = triangle_bounds.cut
    monkeypatch.setattr(triangle_bounds, "cut", counted)
    monkeypatch.setattr(hausdorff, "directed_bounds", triangle_bounds.directed_bounds.py_func)
    (vertices, faces), (few, few_faces) = fans(sections, 1.0, 1.0), fans(20, 0.99, 0.9)
    low, high = hausdorff.hausdorff_bound(vertices, faces[::order], few, few_faces[::order])
    assert 0.1 * (1 - 1e-12) <= low <= high <= 1.01 * low
    assert 0 < len(cuts) <= 6 * sections + 300
