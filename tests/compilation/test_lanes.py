"""Operations on several numbers at once are the same in kernels as in Python."""

import inspect

import numpy as np
import pytest

from kabo.compilation import lanes, lean_kernel
from kabo.compilation.lanes import (
    absolute,
    all_four,
    any_greater,
    farthest,
    four,
    fused,
    inner,
    minus,
    near_columns,
    plus,
    put_four,
    sums,
    times,
)

NUMBERS = np.random.default_rng(2).normal(size=(60, 12))


@lean_kernel
def all_operations(flat, results):
    """Writes the results of all operations on three fours, one after the other."""
    a, b, c = four(flat, 0), four(flat, 4), four(flat, 8)
    put_four(results, 0, times(a, b))
    put_four(results, 4, fused(a, b, c))
    put_four(results, 8, minus(a, b))
    put_four(results, 12, plus(a, b))
    put_four(results, 16, absolute(a))
    put_four(results, 20, sums(a, b, c))
    put_four(results, 24, all_four(a[2]))
    results[28] = inner((flat[0], flat[1], flat[2]), (flat[4], flat[5], flat[6]))
    return any_greater(a, b)


@lean_kernel
def near(rows, start, low, high):
    return near_columns(rows, start, (low[0], low[1], low[2]), (high[0], high[1], high[2]))


@lean_kernel
def key(blocks, row, count, x, y, z):
    return farthest(blocks, row, count, (x, y, z), 16.0)


@pytest.mark.parametrize("function", [all_operations, all_operations.py_func])
def test_fours_are_those_of_numpy(function):
    for row in NUMBERS:
        results, (a, b, c) = np.empty(29), row.reshape(3, 4)
        expected = [a * b, a * b + c, a - b, a + b, abs(a), [a.sum(), b.sum(), c.sum(), c.sum()], np.full(4, a[2])]
        assert function(row, results) == (a[:3] > b[:3]).any()
        assert np.allclose(results[:28].reshape(7, 4), expected, atol=1e-14, rtol=0.0)
        assert results[28] == pytest.approx(a[:3] @ b[:3], abs=1e-14)


@pytest.mark.parametrize("function", [all_operations, all_operations.py_func])
def test_a_nan_and_the_fourth_number_are_not_greater(function):
    row = np.zeros(12)
    row[3], row[1] = 1.0, np.nan
    assert not function(row, np.empty(29))
    row[2] = 1.0
    assert function(row, np.empty(29))


@pytest.mark.parametrize("function", [near, near.py_func])
def test_boxes_that_meet_have_their_bits(function):
    rng = np.random.default_rng(3)
    centre, half = rng.uniform(-1.0, 1.0, (2, 3, 64))
    rows = np.concatenate([centre - abs(half), centre + abs(half)]).astype(np.float32)
    for g in range(64):
        meets = (rows[:3, g, None] <= rows[3:]).all(axis=0) & (rows[3:, g, None] >= rows[:3]).all(axis=0)
        for start in (0, 32):
            bits = function(rows, start, rows[:3, g], rows[3:, g])
            assert [bits >> i & 1 for i in range(32)] == meets[start : start + 32].tolist()


@pytest.mark.parametrize("function", [key, key.py_func])
def test_the_farthest_corner_is_that_of_numpy(function):
    rng = np.random.default_rng(4)
    blocks = rng.uniform(-1.0, 1.0, (3, 3, 64))
    for count in (8, 24, 56, 64):
        for axis in rng.normal(size=(20, 3)):
            axis /= np.linalg.norm(axis)
            found = np.int64(function(blocks, 2, count, *axis))
            assert found & 63 == np.argmax(axis @ blocks[2, :, :count])
            height = (found & ~np.int64(63)).view(np.float64) - 16.0
            assert height == pytest.approx((axis @ blocks[2, :, :count]).max(), abs=16.0 * 2.0**-46)


@pytest.mark.parametrize("function", [key, key.py_func])
def test_of_equal_corners_the_last_is_the_farthest(function):
    assert function(np.ones((1, 3, 8)), 0, 8, 0.6, 0.8, 0.0) & 63 == 7


def test_every_operation_is_tested_here():
    made = {name for name, value in vars(lanes).items() if inspect.isfunction(value)}
    assert made <= set(globals())
