"""What kernels find at once of paths and motions near them, compared with what is found step by step."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.motion import MotionLimits, Timed, blended, natural_slopes, rounded_path, timed_path
from kabo.motion.kernels.near_pieces import REFUSED, Whose, asked_of
from kabo.motion.section import way_points

SEEDS = st.integers(0, 10**6)
NEARNESS = np.array([0.01, 5e-6, 1e-8])
NOWHERE = -1.0


def corners_of(rng: np.random.Generator) -> np.ndarray:
    size = rng.choice([0.02, 0.3, 1.0])
    return np.round(np.cumsum(rng.normal(size=(rng.integers(3, 9), rng.integers(1, 8))) * size, axis=0), 9)


def motion(seed: int) -> Timed:
    rng = np.random.default_rng(seed)
    corners = corners_of(rng)
    limits = MotionLimits.of(*(np.full(corners.shape[1], k) for k in (1.0, 4.0, 80.0)))
    shares = rng.choice([0.0, 0.4, 1.0], len(corners))
    return timed_path(corners, limits, deviation=0.1, shares=shares.tolist(), chord=4e-3)


@given(SEEDS, st.booleans())
def test_a_path_that_is_made_at_once_is_the_blended_one(seed: int, curve: bool) -> None:
    rng = np.random.default_rng(seed)
    corners = corners_of(rng)
    shares = rng.choice([0.0, 0.3, 1.0], len(corners))
    at_knots = natural_slopes(corners)
    slopes = np.stack([at_knots[:-1], at_knots[1:]], axis=1) if curve else None
    found, trims = rounded_path(corners, deviation=0.1, shares=shares, chord=4e-3, slopes=slopes)
    units = np.diff(corners, axis=0) / np.linalg.norm(np.diff(corners, axis=0), axis=1)[:, None]
    back = np.linalg.norm(np.diff(units, axis=0), axis=1) > 1.99
    shares[1:-1] = np.where(back, 0.0, shares[1:-1])
    path = blended(corners, 0.1, shares, slopes)
    passing, indices = way_points(path, 4e-3)
    assert np.allclose(trims, path.trims, rtol=1e-12, atol=0.0)
    assert found.corners == tuple(indices) and np.allclose(found.passing, passing, rtol=0.0, atol=1e-12)
    assert np.abs(found.waypoints - path.at(passing)).max() < 1e-9
    again = replace(found)  # knows no deviations
    assert np.allclose(found.deviations, again.deviations, rtol=0.0, atol=1e-12)


@given(SEEDS)
def test_a_path_with_way_points_in_the_middle_of_pieces_is_of_the_same_motion(seed: int) -> None:
    made, rng = motion(seed), np.random.default_rng(seed)
    count = len(made.passing) - 1
    pieces = np.flatnonzero(rng.random(count) < 0.4)
    found, halves = made.with_middles(pieces, 6)
    old = np.setdiff1d(np.arange(len(found.passing)), halves[1::2])
    assert np.array_equal(found.passing[old], made.passing) and np.array_equal(
        found.waypoints[old], made.waypoints
    )
    assert np.array_equal(found.waypoints[list(found.corners)], made.waypoints[list(made.corners)])
    middles = halves[1::2]
    assert np.allclose(found.passing[middles], (made.passing[pieces] + made.passing[pieces + 1]) / 2, atol=6e-7)
    assert np.abs(found.waypoints[middles] - made.at(found.passing[middles])).max(initial=0.0) < 1e-9
    assert np.array_equal(found.deviations, replace(found).deviations)


def whose(made: Timed, touching: float = NOWHERE, curved: bool = False) -> Whose:
    """A route of one part along the corners of a motion; its robot has another joint before those that move."""
    corners, n = made.waypoints[list(made.corners)], made.waypoints.shape[1]
    rests = made.waypoints[:1]
    owners, first = np.zeros(len(corners) - 1, np.int64), np.zeros(1, np.int64)
    resting = np.linspace(1.0, 2.0, n + 1)
    return Whose(corners, owners, np.array([curved]), np.array([touching]), rests, first, resting, 1)


@given(SEEDS)
def test_what_leaves_the_path_is_asked_of(seed: int) -> None:
    made = motion(seed)
    pieces = np.arange(len(made.passing) - 1)
    chosen, owners, kinds, starts, ends, strays = asked_of(made.course, whose(made), pieces, 4.0, 1e-8, NEARNESS)
    assert np.array_equal(chosen, np.flatnonzero(made.deviations.max(axis=1) > 1e-8)) and not owners.any()
    assert np.array_equal(starts[:, 1:], made.waypoints[chosen]) and np.all(starts[:, 0] == 1.0)
    assert np.array_equal(ends[:, 1:], made.waypoints[chosen + 1]) and np.all(ends[:, 0] == 1.0)
    assert np.array_equal(strays[:, 1:], 4.0 * made.deviations[chosen]) and not strays[:, 0].any()
    away = [
        min(np.linalg.norm(made.waypoints[i + k] - made.waypoints[0]) for k in range(2)) for i in chosen.tolist()
    ]
    near = made.deviations[chosen].max(axis=1) <= NEARNESS[0] * np.array(away) + NEARNESS[2]
    assert np.array_equal(kinds == REFUSED, ~near)


def test_all_of_a_curve_is_asked_of_and_a_look_is_at_the_middles() -> None:
    made = motion(3)
    pieces = np.arange(len(made.passing) - 1)
    chosen, _, kinds, starts, ends, strays = asked_of(
        made.course, whose(made, curved=True), pieces, -1.0, 1e-8, NEARNESS
    )
    assert np.array_equal(chosen, pieces) and not kinds.any() and not strays.any()
    assert np.array_equal(starts, ends)
    assert np.abs(starts[:, 1:] - made.at((made.passing[:-1] + made.passing[1:]) / 2)).max() < 1e-9


@pytest.mark.parametrize(("touching", "kind"), [(10.0, 0), (0.0, 1), (NOWHERE, 0)])
def test_far_from_the_part_bodies_are_apart(touching: float, kind: int) -> None:
    """A blend leaves the straight pieces, where bodies may touch."""
    limits = MotionLimits.of([1.0, 1.0], [4.0, 4.0], [80.0, 80.0])
    made = timed_path([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], limits, deviation=0.1, shares=[1.0, 1.0, 1.0])
    off = np.flatnonzero(made.deviations.max(axis=1) > 1e-8)
    middle = off[len(off) // 2 : len(off) // 2 + 1]
    _, _, kinds, *_ = asked_of(made.course, whose(made, touching), middle, -1.0, 1e-8, NEARNESS)
    assert kinds.tolist() == [kind]
