"""Families of poses: all that rows leave free, written down as parameters; judged by the rows themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.kinematics import FrameFeature, rows_of, stacked
from kabo.kinematics.families import _null, family_of
from kabo.kinematics.kernels import families as kernels
from kabo.kinematics.kernels import rows as columns
from kabo.streams import stream_key, uniforms

TIP, APPROACH, CLOSING, SIDE = (
    FrameFeature(1, "point", (0.02, 0.0, 0.13)),
    FrameFeature(1, "line", (0.02, 0.0, 0.13), (0.0, 0.0, 1.0)),
    FrameFeature(1, "line", (0.02, 0.0, 0.13), (0.0, 1.0, 0.0)),
    FrameFeature(1, "plane", (0.02, 0.0, 0.13), (1.0, 0.0, 0.0)),
)
TABLE = FrameFeature(0, "plane", (0.3, 0.1, 0.2), (0.0, 0.0, 1.0))
WALL = FrameFeature(0, "plane", (0.3, 0.1, 0.2), (0.6, 0.8, 0.0))
AXIS = FrameFeature(0, "line", (0.3, 0.1, 0.2), (0.0, 0.0, 1.0))
POST = FrameFeature(0, "point", (0.3, 0.1, 0.2))
ON_TABLE = [rows_of("height", TIP, TABLE, 0.1, 0.1), rows_of("opposed", APPROACH, TABLE)]
FROM_THE_SIDE = [
    rows_of("coincident", TIP, AXIS),
    rows_of("perpendicular", APPROACH, AXIS),
    rows_of("perpendicular", CLOSING, AXIS),
]
AT_THE_RIM = [
    *ON_TABLE,
    rows_of("distance", TIP, AXIS, 0.05, 0.05),
    rows_of("coincident", POST, SIDE),
]
AZIMUTH = rows_of("azimuth", CLOSING, AXIS)
CASES = {  # rows; how many components, what turn, how many heights aimed at, translations loose
    "on a table": (ON_TABLE, 1, kernels.ONE_TURN, 0, 2),
    "on a table, between walls": ([*ON_TABLE, rows_of("height", TIP, WALL, -0.1, 0.3)], 1, kernels.ONE_TURN, 1, 1),
    "from the side": (FROM_THE_SIDE, 2, kernels.ONE_TURN, 0, 1),
    "at the rim": (AT_THE_RIM, 2, kernels.ONE_TURN, 0, 0),
    "at a point": ([rows_of("coincident", TIP, POST)], 1, kernels.ANY_TURN, 0, 0),
    "along a line": ([rows_of("coincident", TIP, AXIS)], 1, kernels.ANY_TURN, 0, 1),
    "upright": ([rows_of("aligned", APPROACH, AXIS)], 1, kernels.ONE_TURN, 0, 3),
    "nowhere": ([], 1, kernels.ANY_TURN, 0, 3),
    "one pose": (
        [rows_of("coincident", TIP, POST), rows_of("aligned", APPROACH, AXIS), rows_of("aligned", SIDE, WALL)],
        1, kernels.FIXED, 0, 0,
    ),
}  # fmt: skip


def poses_of(family, count, reach=1.0):
    """Poses that evenly random parameters choose, and their components."""
    shares = uniforms(stream_key("poses"), 0, count, kernels.MOST_SHARES)
    which = np.arange(count) % len(family.starts)
    return kernels.poses_drawn(family, which, shares, np.zeros(3), reach)[0]


@pytest.mark.parametrize("case", CASES)
def test_what_rows_leave_free_is_found_and_rows_hold_all_over_it(case):
    parts, components, turn, aimed, loose = CASES[case]
    rows = stacked(parts)
    family = family_of(rows)
    assert family is not None
    assert len(family.starts) == components
    assert (family.turn, len(family.aimed), len(family.loose)) == (turn, aimed, loose)
    values, _ = kernels.rows_at(rows, poses_of(family, 200))
    assert np.all(values >= rows[:, columns.LOWER] - 1e-9)
    assert np.all(values <= rows[:, columns.UPPER] + 1e-9)


@pytest.mark.parametrize(
    "parts",
    [
        [rows_of("coincident", TIP, AXIS), rows_of("perpendicular", APPROACH, AXIS)],  # turns about two lines
        [*ON_TABLE, rows_of("distance", TIP, AXIS, 0.05, 0.05)],  # goes round the axis, and turns on the spot
    ],
)
def test_what_is_more_than_one_turn_has_no_family(parts):
    assert family_of(stacked(parts)) is None


def test_contradictions_have_no_family():
    assert family_of(stacked([*ON_TABLE, rows_of("height", TIP, TABLE, 0.2, 0.2)])) is None


def test_the_turn_aims_at_an_azimuth():
    family = family_of(stacked(AT_THE_RIM), AZIMUTH)
    assert family is not None and len(family.azimuths) == 1
    shares = np.zeros((40, kernels.MOST_SHARES))
    shares[:, 0] = (np.arange(40) + 0.5) / 40
    for component in range(len(family.starts)):
        poses, _ = kernels.poses_drawn(family, np.full(40, component), shares, np.zeros(3), 1.0)
        angles = kernels.rows_at(AZIMUTH, poses)[0][:, 0]
        assert np.allclose(angles, -np.pi + 2 * np.pi * shares[:, 0], atol=1e-9)


@given(low=st.floats(-0.4, 0.3), width=st.floats(0.01, 0.5), share=st.floats(0.0, 0.999))
def test_translations_aim_at_heights(low, width, share):
    row = rows_of("height", TIP, WALL, low, low + width)
    family = family_of(stacked([*ON_TABLE, row]))
    assert family is not None
    shares = uniforms(stream_key("aims"), 0, 5, kernels.MOST_SHARES)
    shares[:, 0] = share
    poses, _ = kernels.poses_drawn(family, np.zeros(5, np.int64), shares, np.zeros(3), 2.0)
    assert np.allclose(kernels.rows_at(row, poses)[0], low + share * width, atol=1e-9)


def test_any_turn_is_even_over_rotations():
    """The direction of an axis of random rotations is even over the sphere: each coordinate over [-1, 1]."""
    family = family_of(stacked([rows_of("coincident", TIP, POST)]))
    assert family is not None
    poses = poses_of(family, 20_000)
    for axis in range(3):
        for coordinate in range(3):
            counts, _ = np.histogram(poses[:, 3 * coordinate + axis], bins=10, range=(-1.0, 1.0))
            assert np.abs(counts / 2000 - 1.0).max() < 0.1


def test_kernels_run_as_plain_python_with_the_same_result():
    rows = stacked(CASES["on a table, between walls"][0])
    family = family_of(rows, AZIMUTH)
    assert family is not None
    shares = uniforms(stream_key("plain"), 0, 6, kernels.MOST_SHARES)
    arguments = family, np.zeros(6, np.int64), shares, np.zeros(3), 1.0
    (poses, good), (same, too) = kernels.poses_drawn(*arguments), kernels.poses_drawn.py_func(*arguments)
    assert np.allclose(poses, same, atol=1e-12) and np.array_equal(good, too)
    for compiled, plain in zip(kernels.rows_at(rows, poses), kernels.rows_at.py_func(rows, poses), strict=True):
        assert np.allclose(compiled, plain, atol=1e-12)


def test_a_null_space_has_one_basis_however_lapack_finds_it() -> None:
    """Rows that are mixed, scaled and repeated have the same null space, and lead LAPACK to another of its bases."""
    numbers = np.random.default_rng(11)
    for _ in range(200):
        rank, columns = int(numbers.integers(0, 6)), 6
        rows = np.round(numbers.normal(size=(rank, columns)), int(numbers.integers(0, 3)))
        mixed = np.concatenate([numbers.normal(size=(rank, rank)) @ rows, numbers.uniform(1.0, 3.0) * rows])
        if rank and np.linalg.svd(rows, compute_uv=False)[-1] < 0.05:
            continue  # rows that hardly differ
        basis = _null(rows)
        assert basis.shape == (columns - rank, columns)
        assert np.allclose(basis @ basis.T, np.eye(columns - rank), atol=1e-12)
        assert np.allclose(basis @ rows.T, 0.0, atol=1e-11)
        assert np.allclose(basis, _null(mixed), atol=1e-9)
