"""The cheapest point outside some planes, against all subsets of planes that may hold it, and against linear programs."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st
from scipy.optimize import linprog

from kabo.geometry.bounding.kernels import contraction_point as kernels
from kabo.geometry.bounding.kernels.quadrics import add_plane, add_point, cost_at

REGULAR, SLACK = 1e-5, 1e-12
SEEDS = st.integers(0, 2**32 - 1)


def unit(rng, spread=1.0):
    """A random direction; a small spread keeps it near the z axis."""
    normal = np.array([0.0, 0.0, 1.0]) * (spread < 1.0) + rng.normal(size=3) * spread
    return normal / np.linalg.norm(normal)


def solved(quadric, planes, regular=REGULAR, slack=SLACK, solve=kernels.cheapest_outside):
    planes = np.asarray(planes, float).reshape(-1, 4)
    room = max(1, len(planes))
    scratch = np.full(6, np.nan), np.full((room, 5), np.nan), np.full(4, -9)
    good, *point = solve(quadric, planes, len(planes), regular, slack, *scratch)
    return good, np.array(point)


def matrix(quadric, regular=REGULAR):
    a, b, c, d, e, f = quadric[:6]
    return np.array([[a, b, c], [b, d, e], [c, e, f]]) + regular * (a + d + f) * np.eye(3)


def regularised(quadric, point):
    return point @ matrix(quadric) @ point + 2 * quadric[6:9] @ point + quadric[9]


def best_of_all_subsets(quadric, planes, slack=1e-9):
    """The oracle [K Algorithm 1]: the cheapest feasible point that at most three planes hold; None if there is none."""
    square, linear, best = matrix(quadric), quadric[6:9], None
    for many in range(4):
        for chosen in combinations(range(len(planes)), many):
            normals, offsets = planes[list(chosen), :3], planes[list(chosen), 3]
            if many and np.linalg.svd(normals, compute_uv=False)[-1] < 1e-7:
                continue
            whole = np.block([[square, normals.T], [normals, np.zeros((many, many))]])
            point = np.linalg.solve(whole, np.concatenate([-linear, offsets]))[:3]
            if (planes[:, :3] @ point >= planes[:, 3] - slack).all():
                cost = regularised(quadric, point)
                best = cost if best is None else min(best, cost)
    return best


@st.composite
def tasks(draw):
    """A quadric of rank 1 to 3, and planes: any, of one side (a smooth star), parallel, doubled, or nearly so."""
    rng, kind = (
        np.random.default_rng(draw(SEEDS)),
        draw(st.sampled_from(["any", "smooth", "flat", "doubled", "near"])),
    )
    spread = {"any": 1.0, "smooth": 0.2, "flat": 0.0, "doubled": 0.5, "near": 1e-4}[kind]
    count = draw(st.integers(1, 9))
    planes = np.array(
        [[*unit(rng, spread), rng.uniform(-0.5, 0.5 if kind == "any" else 0.05)] for _ in range(count)]
    )
    if kind == "doubled":
        planes = np.concatenate([planes, planes[rng.integers(0, count, 3)]])
    quadric = np.zeros(10)
    for number in range(draw(st.integers(1, 6))):
        if draw(st.booleans()):  # the planes' own distances, as in contractions; or those of others
            normal, offset = planes[number % count, :3], planes[number % count, 3]
        else:
            normal, offset = unit(rng), rng.uniform(-0.3, 0.3)
        add_plane(quadric, *normal, offset, 1.0)
    if draw(st.booleans()):
        add_point(quadric, *rng.uniform(-0.3, 0.3, 3), 0.2)
    event(f"{kind}, rank {np.linalg.matrix_rank(matrix(quadric, 0.0), 1e-6)}")
    return quadric, planes


def margin(planes):
    """How far inside all half-spaces a point within 100 m can be [m]; negative if none is in all."""
    rows = np.column_stack([-planes[:, :3], np.ones(len(planes))])
    found = linprog([0, 0, 0, -1], rows, -planes[:, 3], bounds=[(-100, 100)] * 3 + [(None, 1.0)])
    assert found.status == 0
    return -found.fun


@given(task=tasks())
def test_the_point_lies_outside_all_planes(task):
    quadric, planes = task
    good, point = solved(quadric, planes)
    if good:
        # Heights are compared in coordinates in which the quadric is a sphere: stretched at most by its free axes.
        stretch = np.sqrt(np.linalg.eigvalsh(np.linalg.inv(matrix(quadric))).max())
        allowed = SLACK * max(1.0, stretch) + 1e-13 * (1.0 + np.abs(point).max()) * max(1.0, stretch)
        assert (planes[:, :3] @ point - planes[:, 3]).min() >= -allowed


@given(task=tasks())
def test_no_point_that_planes_hold_is_cheaper(task):
    quadric, planes = task
    good, point = solved(quadric, planes)
    best = best_of_all_subsets(quadric, planes)
    assume(good and best is not None)
    least = regularised(quadric, -np.linalg.solve(matrix(quadric), quadric[6:9]))
    assert regularised(quadric, point) - least <= (best - least) * (1.0 + 1e-6) + 1e-8 * (1.0 + abs(best))


@given(task=tasks())
def test_a_point_is_found_where_there_is_room_and_none_where_there_is_not(task):
    quadric, planes = task
    room = margin(planes)
    good, _ = solved(quadric, planes)
    event("room" if room > 1e-6 else "no room" if room < -1e-6 else "hardly any")
    assert good if room > 1e-3 else not good if room < -1e-6 else True


@pytest.mark.parametrize("gap", [1e-9, 1e-3, 1.0])
def test_between_planes_that_face_each_other_there_is_nothing(gap):
    quadric = np.zeros(10)
    add_point(quadric, 0.0, 0.0, 0.0, 1.0)
    up, down = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
    assert not solved(quadric, [[*up, gap], [*down, gap]])[0]
    assert solved(quadric, [[*up, -gap], [*down, -gap]])[0]


def test_four_planes_that_leave_nothing_are_noticed():
    quadric = np.zeros(10)
    add_point(quadric, 0.2, 0.1, 0.0, 1.0)
    normals = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
    assert not solved(quadric, np.column_stack([normals, np.full(4, 0.1)]))[0]
    good, point = solved(quadric, np.column_stack([normals, np.full(4, -0.1)]))
    assert good and (normals @ point >= -0.1).all()


def test_without_planes_the_cheapest_point_is_the_minimum():
    quadric, place = np.zeros(10), np.array([0.3, -0.2, 0.7])
    add_point(quadric, *place, 2.0)
    good, point = solved(quadric, np.empty((0, 4)), regular=0.0)
    assert good and point == pytest.approx(place, abs=1e-12)


def test_a_corner_of_three_planes_is_where_they_meet():
    quadric, corner = np.zeros(10), np.array([0.1, -0.2, 0.3])
    add_point(quadric, *(corner - 1.0), 1.0)
    good, point = solved(quadric, np.column_stack([np.eye(3), corner]))
    assert good and point == pytest.approx(corner, abs=1e-11)


def test_free_directions_stay_near_the_origin_that_the_edge_gives():
    """A flat star: nothing but the regularisation says where on the plane."""
    quadric = np.zeros(10)
    plane = [0.6, 0.0, 0.8, 1e-3]
    for _ in range(6):
        add_plane(quadric, *plane, 1.0)
    good, point = solved(quadric, [plane] * 6)
    assert good and np.linalg.norm(point) < 1.1e-3


@pytest.mark.parametrize("degree", [6, 100, 1000])
def test_a_star_of_many_faces_is_held_by_its_cone(degree):
    angle = 2 * np.pi * np.arange(degree) / degree
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle + 1.0], axis=1) / np.sqrt(2.0)
    planes = np.column_stack([normals, np.full(degree, 0.5)])
    quadric = np.zeros(10)
    for plane in planes:
        add_plane(quadric, *plane, 1.0)
    good, point = solved(quadric, planes)
    assert good and (planes[:, :3] @ point - planes[:, 3]).min() >= 0.0
    assert point == pytest.approx([0.0, 0.0, 0.5 * np.sqrt(2.0)], abs=1e-6)


@given(task=tasks(), power=st.integers(-20, 20))
def test_the_size_of_the_task_changes_nothing(task, power):
    """Scaled by a power of two, slack and all, the answer is the same number but for its exponent."""
    quadric, planes = task
    size = 2.0**power
    scaled, larger = quadric.copy(), planes * [1.0, 1.0, 1.0, size]
    scaled[6:9] *= size
    scaled[9] *= size * size
    good, point = solved(quadric, planes)
    assert solved(scaled, larger, slack=SLACK * size)[0] == good
    assert not good or np.array_equal(solved(scaled, larger, slack=SLACK * size)[1], point * size)


def test_compiled_and_original_agree():
    rng = np.random.default_rng(5)
    for count in (1, 3, 5):
        quadric, planes = np.zeros(10), np.array([[*unit(rng, 0.4), 0.02 * rng.normal()] for _ in range(count)])
        for plane in planes:
            add_plane(quadric, *plane, 1.0)
        add_point(quadric, 0.0, 0.0, -0.5, 0.1)
        good, point = solved(quadric, planes)
        other, twin = solved(quadric, planes, solve=kernels.cheapest_outside.py_func)
        assert good == other and point == pytest.approx(twin, rel=1e-9)
        assert cost_at(quadric, *point) == pytest.approx(cost_at(quadric, *twin), rel=1e-9)
