"""Deviations bound the distance of every moment from the path, and are hardly larger, against dense sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from kabo.verify.motion.trajectories.curves import Curve
from kabo.verify.motion.trajectories.deviations import from_joined, from_path, from_rest_of_piece

numbers = st.integers(0, 2**32 - 1)


def splined(rng: np.random.Generator, count: int) -> tuple[Curve, np.ndarray, np.ndarray]:
    """A smooth curve through random way points, which it leaves between them; way points and times."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, count - 1))])
    waypoints = np.cumsum(rng.uniform(-1.0, 1.0, (count, 3)), axis=0)
    spline = make_interp_spline(times, waypoints, k=3)
    powers = np.zeros((count - 1, 3, 6))
    for k in range(count - 1):
        h = times[k + 1] - times[k]
        ends = [(spline(times[k], nu=i), spline(times[k + 1], nu=i)) for i in range(3)]
        powers[k] = quintic(ends, h)
    return Curve(times, powers), waypoints, times


def quintic(ends, h: float) -> np.ndarray:
    """The quintic with these positions, velocities and accelerations at both ends (n, 6)."""
    rows = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]]
    rows += [[h**k for k in range(6)], [k * h ** (k - 1) if k else 0 for k in range(6)]]
    rows += [[k * (k - 1) * h ** (k - 2) if k > 1 else 0 for k in range(6)]]
    right = np.array([ends[0][0], ends[1][0], ends[2][0], ends[0][1], ends[1][1], ends[2][1]])
    return np.linalg.solve(np.array(rows, float), right).T


def distances(curve: Curve, waypoints: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The sampled distances (m - 1, n) of all joints from the nearest point of the piece under way."""
    found = []
    for a, b, start, end in zip(waypoints, waypoints[1:], times, times[1:], strict=False):
        places, way = curve.at(np.linspace(start, end - 1e-9, 400)), b - a
        shares = np.clip((places - a) @ way / (way @ way), 0.0, 1.0)
        found.append(np.abs(places - a - shares[:, None] * way).max(axis=0))
    return np.array(found)


@given(seed=numbers)
def test_no_moment_is_farther_from_the_path_than_its_bound_and_the_bound_is_near(seed):
    curve, waypoints, times = splined(np.random.default_rng(seed), 6)
    bounds, sampled = from_path(curve, waypoints, times).bounds, distances(curve, waypoints, times)
    assert (bounds >= sampled - 1e-5).all()  # way points are passed up to 2 us earlier or later
    # A bound adds what the projection leaves the piece by, which sampling does not separate.
    assert bounds.max() <= 1.3 * sampled.max() + np.abs(np.diff(waypoints, axis=0)).max()


def test_a_straight_piece_that_is_followed_exactly_has_no_deviation_even_if_times_are_rounded():
    waypoints = np.array([[0.0, 0.0], [0.4, -0.2], [1.0, -0.5]])
    h = 1.0
    powers = np.array([[[0, 0, 0, 10, -15, 6], [0, 0, 0, -5, 7.5, -3]]], float)
    curve = Curve(np.array([0.0, h]), powers)
    grid = np.linspace(0, 1, 10**6 + 1)
    passed = grid[np.argmax(curve.at(grid)[:, 0] >= 0.4)]
    found = from_path(curve, waypoints, np.array([0.0, round(passed, 6), 1.0]))
    assert found.greatest < 1e-9
    wrong = from_path(curve, waypoints, np.array([0.0, round(passed, 6) + 1e-3, 1.0]))
    assert wrong.greatest == pytest.approx(1e-3 * curve.at(np.array([passed]), 1)[0, 0], rel=0.02)


def test_a_wanted_bound_is_shown_to_hold_where_it_does():
    curve, waypoints, times = splined(np.random.default_rng(3), 6)
    coarse = from_path(curve, waypoints, times).greatest
    nearly = from_path(curve, waypoints, times, wanted=coarse * 0.9999).greatest
    assert nearly <= coarse
    exact = from_path(curve, waypoints, times, wanted=nearly * (1.0 + 1e-6)).greatest
    assert exact <= nearly * (1.0 + 1e-6)


@given(seed=numbers)
def test_joined_pieces_are_left_by_no_more_than_their_bound(seed):
    rng = np.random.default_rng(seed)
    (one, _, times), (other, _, others) = splined(rng, 5), splined(rng, 4)
    inner = [t for t in (*times, *others) if t < min(times[-1], others[-1])]
    cuts = np.unique(np.concatenate([inner, rng.uniform(max(times[0], others[0]), max(inner), 8)]))
    cuts = cuts[cuts >= max(times[0], others[0])]
    bounds = from_joined([one, other], cuts)
    for k in range(len(cuts) - 1):
        at = cuts[k] + np.linspace(0.0, 1.0, 100) * (cuts[k + 1] - cuts[k]) * (1 - 1e-12)
        rows = np.hstack([one.at(cuts[k : k + 2]), other.at(cuts[k : k + 2])])
        here, way = np.hstack([one.at(at), other.at(at)]) - rows[0], rows[1] - rows[0]
        share = here @ way / (way @ way)
        off = np.abs(here - np.clip(share, 0.0, 1.0)[:, None] * way).max(axis=0)
        assert (bounds[k] >= off - 1e-9).all()
        rest = np.abs(here - share[:, None] * way).max(axis=0)
        beyond = max(0.0, share.max() - 1.0, -share.min()) * np.abs(way)
        scale = max(np.abs(one.powers).max(), np.abs(other.powers).max())
        assert (bounds[k] <= 1.5 * (rest + beyond) + 1e-3 * scale).all()


@pytest.mark.parametrize(("late", "least", "most"), [(0.0, 0.0, 1e-12), (0.001, 5e-4, 5e-3)])
def test_curves_with_one_law_follow_their_joined_path_exactly(late, least, most):
    """From rest to rest, the first by 1 rad and the second by 2 rad, so much later."""
    law = np.array([[[0, 0, 0, 10, -15, 6]]], float)
    curves = [Curve(np.array([0.0, 1.0]), law), Curve(np.array([late, 1.0 + late]), 2.0 * law)]
    assert least <= from_joined(curves, np.array([late, 0.5, 1.0])).max() <= most


def test_the_rest_of_a_piece_is_compared_with_what_is_left_of_it():
    curve = Curve(np.array([0.0, 1.0]), np.array([[[0, 0, 0, 10, -15, 6]]], float))
    now = curve.at(np.array([0.4]))
    ends = np.array([now[0], [1.0]])
    assert from_rest_of_piece(curve, ends, np.array([0.4, 1.0]))[0] < 1e-9
    late = np.array([now[0] + 0.1, [1.0]])
    assert from_rest_of_piece(curve, late, np.array([0.4, 1.0]))[0] == pytest.approx(0.1, rel=1e-3)
