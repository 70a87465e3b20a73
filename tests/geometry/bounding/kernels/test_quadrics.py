"""Quadric costs: sums of squared distances, and how far the approximations of their minimum may be trusted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.geometry.bounding.kernels import quadrics as kernels

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = st.sampled_from([1e-3, 0.1, 1.0, 30.0])  # metres: the free parameter of [K Eq. 4.7]
COUNTS = st.integers(1, 6)


def unit(rng):
    normal = rng.normal(size=3)
    return normal / np.linalg.norm(normal)


def of_planes(rng, count, size=1.0, constant=0.0, normals=()):
    """The quadric of some planes about a random point: with random normals, or with those given, again and again."""
    quadric, about = np.zeros(10), rng.normal(size=3) * size
    for number in range(count):
        normal = normals[number % len(normals)] if len(normals) else unit(rng)
        kernels.add_plane(quadric, *normal, normal @ about + 0.1 * size * rng.normal(), rng.uniform(0.1, 2.0))
    quadric[9] += constant * size**2
    return quadric


def values(quadric, points):
    return np.array([kernels.cost_at(quadric, *point) for point in points])


def combined(kind, first, second, length=1.0, combine=kernels.combine):
    result = np.full(10, np.nan)
    combine(kind, first, second, result, length, np.full((13, 10), np.nan))
    return result


def matrix(quadric):
    a, b, c, d, e, f = quadric[:6]
    return np.array([[a, b, c], [b, d, e], [c, e, f]])


@st.composite
def pairs(draw):
    """Two quadrics near each other or far apart, of rank 1 to 3, some of them with a cost everywhere."""
    rng, size = np.random.default_rng(draw(SEEDS)), draw(st.sampled_from([1e-3, 1.0, 100.0]))
    normals = [unit(rng) for _ in range(draw(st.sampled_from([0, 0, 1, 2])))]  # any, a plane, a prism
    first, second = (
        of_planes(rng, draw(COUNTS), size, draw(st.sampled_from([0.0, 0.0, 0.01, 2.0])), normals) for _ in range(2)
    )
    points = rng.normal(size=(200, 3)) * size * 10.0 ** rng.uniform(-4, 1, (200, 1))
    return first, second, np.concatenate([points, points[:20] + rng.normal(size=3) * size])


def rounding(points, *several):
    """What rounding may do to a value at these points."""
    reach = np.linalg.norm(points, axis=1)
    return 1e-13 * sum(
        np.linalg.norm(q[:6]) * reach**2 + 2 * np.linalg.norm(q[6:9]) * reach + abs(q[9]) for q in several
    )


@given(seed=SEEDS, count=COUNTS)
def test_a_value_is_the_sum_of_squared_distances(seed, count):
    rng = np.random.default_rng(seed)
    quadric, expected, points = np.zeros(10), np.zeros(20), rng.normal(size=(20, 3))
    for _ in range(count):
        normal, offset, weight = unit(rng), rng.normal(), rng.uniform(0.1, 3.0)
        kernels.add_plane(quadric, *normal, offset, weight)
        expected += weight * (points @ normal - offset) ** 2
        place, weight = rng.normal(size=3), rng.uniform(0.1, 3.0)
        kernels.add_point(quadric, *place, weight)
        expected += weight * ((points - place) ** 2).sum(axis=1)
    assert values(quadric, points) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@given(pair=pairs(), seed=SEEDS)
def test_a_moved_origin_changes_the_place_but_not_the_value(pair, seed):
    quadric, _, points = pair
    origin = np.random.default_rng(seed).normal(size=3)
    moved = quadric.copy()
    kernels.move_origin(moved, *origin)
    away = np.concatenate([points, points + origin])
    allowed = 10 * rounding(away, quadric)[: len(points)] + 10 * rounding(away, quadric)[len(points) :] + 1e-13
    assert (np.abs(values(moved, points) - values(quadric, points + origin)) <= allowed).all()


@given(pair=pairs())
def test_no_point_is_cheaper_than_the_minimiser(pair):
    quadric, _, points = pair
    least = kernels.minimiser(quadric)
    # It may lack what its regularisation takes: 1e-9 of the trace, over the distance to the nearest true minimiser.
    true = -np.linalg.pinv(matrix(quadric), rcond=1e-10, hermitian=True) @ quadric[6:9]
    lack = 1e-9 * np.trace(matrix(quadric)) * (true @ true)
    at = kernels.cost_at(quadric, *least)
    assert at <= kernels.cost_at(quadric, *true) + 2 * lack + 10 * rounding(np.array([true, least]), quadric).max()
    assert (values(quadric, points) >= at - 2 * lack - 10 * rounding(points, quadric)).all()


def test_the_minimiser_of_no_cost_at_all_is_the_origin():
    assert kernels.minimiser(np.zeros(10)) == (0.0, 0.0, 0.0)


def test_of_many_minimisers_the_one_nearest_to_the_origin_is_found():
    quadric = np.zeros(10)
    kernels.add_plane(quadric, 0.6, 0.0, 0.8, 5.0, 2.0)
    assert kernels.minimiser(quadric) == pytest.approx((3.0, 0.0, 4.0), rel=1e-6)


@given(pair=pairs(), kind=st.sampled_from([kernels.PLANES, kernels.TRIANGLES, kernels.MEMORYLESS]))
def test_sums_are_sums(pair, kind):
    first, second, _ = pair
    assert np.array_equal(combined(kind, first, second), first + second)


@given(pair=pairs())
def test_the_adapted_constant_touches_the_cheaper_one_where_the_sum_is_least(pair):
    """[K 4.3.3]: max(Q1, Q2) at the minimiser of the sum is taken off the constant."""
    first, second, _ = pair
    adapted, least = combined(kernels.ADAPTED, first, second), kernels.minimiser(first + second)
    touched = min(kernels.cost_at(first, *least), kernels.cost_at(second, *least))
    allowed = 20 * rounding(np.array([least]), first, second)[0]
    assert kernels.cost_at(adapted, *least) == pytest.approx(touched, rel=1e-12, abs=allowed)
    assert np.array_equal(adapted[:9], (first + second)[:9])


@given(pair=pairs())
def test_the_adapted_constant_is_short_of_the_minimum_by_half_of_what_both_differ_by_at_most(pair):
    """[K 4.3.3] says an upper bound; that holds where both cost the same at the minimiser m of their sum, not always.

    With D(x) the sum less its least value, adapted = min(m) + D(x), while min(x) <= (Q1(m) + Q2(m) + D(x)) / 2.
    """
    first, second, points = pair
    adapted, least = combined(kernels.ADAPTED, first, second), kernels.minimiser(first + second)
    short = 0.5 * abs(kernels.cost_at(first, *least) - kernels.cost_at(second, *least))
    true = -np.linalg.pinv(matrix(first + second), rcond=1e-10, hermitian=True) @ (first + second)[6:9]
    regularised = 1e-8 * np.trace(matrix(first + second)) * (true @ true)
    minimum = np.minimum(values(first, points), values(second, points))
    allowed = short + regularised + 20 * rounding(points, first, second)
    assert (values(adapted, points) >= minimum - allowed).all()


def test_the_adapted_constant_is_an_upper_bound_where_both_cost_the_same():
    rng = np.random.default_rng(0)
    for _ in range(100):
        first, second = of_planes(rng, 5), of_planes(rng, 5)
        least, points = kernels.minimiser(first + second), rng.normal(size=(100, 3)) * 3.0
        costs = [kernels.cost_at(q, *least) for q in (first, second)]
        (first if costs[0] < costs[1] else second)[9] += abs(costs[0] - costs[1])
        minimum = np.minimum(values(first, points), values(second, points))
        assert (values(combined(kernels.ADAPTED, first, second), points) >= minimum - 1e-7).all()


@given(pair=pairs(), length=LENGTHS)
def test_the_diagonal_quadric_is_nowhere_below_the_minimum(pair, length):
    """[K Eq. 4.6, 4.7]. Eq. 4.6 alone is no bound; the minimum of two stays below, as it is below their mean.

    The mean is diagonal in the axes of the sum and has no linear terms at its minimiser.
    """
    first, second, points = pair
    diagonal = combined(kernels.DIAGONAL, first, second, length)
    minimum = np.minimum(values(first, points), values(second, points))
    allowed = 50 * rounding(points, first, second) + 50 * rounding(points, diagonal)
    assert (values(diagonal, points) >= minimum - allowed).all()


@given(pair=pairs(), length=LENGTHS, quaternion=st.tuples(*[st.integers(-3, 3)] * 4).filter(any))
def test_the_diagonal_quadric_turns_with_the_mesh(pair, length, quaternion):
    """Invariance to rotation [K 4.3.3]; where two axes are alike, any choice of them is one, so those are left out."""
    first, second, points = pair
    axes = np.linalg.eigvalsh(matrix(first + second))
    if np.diff(axes).min() < 1e-2 * axes.max():
        return
    w, x, y, z = np.array(quaternion) / np.linalg.norm(quaternion)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + 2 * w * skew + 2 * skew @ skew

    def turned(quadric):
        square, made = turn @ matrix(quadric) @ turn.T, quadric.copy()
        made[:6] = square[[0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
        made[6:9] = turn @ quadric[6:9]
        return made

    there = values(combined(kernels.DIAGONAL, turned(first), turned(second), length), points @ turn.T)
    here = values(combined(kernels.DIAGONAL, first, second, length), points)
    assert there == pytest.approx(here, rel=1e-6, abs=1e-6 * np.abs(here).max())


def test_compiled_and_original_agree():
    rng = np.random.default_rng(3)
    for count in (1, 2, 3, 6):
        first, second = of_planes(rng, count), of_planes(rng, count, constant=0.1)
        place = rng.normal(size=3)
        assert kernels.cost_at(first, *place) == pytest.approx(kernels.cost_at.py_func(first, *place), rel=1e-12)
        assert kernels.minimiser(first) == pytest.approx(kernels.minimiser.py_func(first), rel=1e-6)
        for kind in (kernels.PLANES, kernels.ADAPTED, kernels.DIAGONAL):
            one = combined(kind, first, second)
            assert one == pytest.approx(combined(kind, first, second, combine=kernels.combine.py_func), rel=1e-9)
        for add in (kernels.add_plane, kernels.add_point):
            one, two = first.copy(), first.copy()
            arguments = (*unit(rng), 0.3, 2.0)[: 5 if add is kernels.add_plane else 4]
            add(one, *arguments)
            add.py_func(two, *arguments)
            assert one == pytest.approx(two, rel=1e-14)
