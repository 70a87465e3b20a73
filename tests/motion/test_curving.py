"""Splines through way points of a curve, beside those of scipy; and motions along them."""

import numpy as np
from scipy.interpolate import CubicSpline

from kabo.motion import MotionLimits, blended, natural_slopes, smooth_knots, timed_path

TURNS = np.linspace(0.0, 1.2, 7)
ARC = np.stack([np.cos(TURNS), np.sin(TURNS), 0.2 * TURNS], axis=1)
LIMITS = MotionLimits(np.full(3, 2.0), np.full(3, 8.0), np.full(3, 160.0))


def slopes_through(knots: np.ndarray) -> np.ndarray:
    found = natural_slopes(knots)
    return np.stack([found[:-1], found[1:]], axis=1)


def test_natural_slopes_are_those_of_scipy() -> None:
    rows = np.cumsum(np.random.default_rng(1).normal(size=(8, 4)), axis=0)
    places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
    assert np.allclose(natural_slopes(rows), CubicSpline(places, rows, bc_type="natural")(places, 1), atol=1e-12)


def test_through_two_knots_the_spline_is_straight() -> None:
    ends = np.array([[0.0, 1.0], [3.0, 5.0]])
    assert np.allclose(natural_slopes(ends), [[0.6, 0.8], [0.6, 0.8]], atol=1e-15)


def test_knots_are_on_the_spline_of_scipy_and_keep_the_ends() -> None:
    for rows in (ARC, ARC[:3]):
        places = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
        dense = CubicSpline(places, rows)(np.linspace(0.0, places[-1], 20_001))
        found = smooth_knots(rows, 12)
        assert max(np.linalg.norm(dense - knot, axis=1).min() for knot in found) < 1e-4
        assert np.array_equal(found[[0, -1]], rows[[0, -1]])


def test_the_path_through_knots_is_nearer_to_the_curve_than_chords_are() -> None:
    knots = smooth_knots(ARC, 12)
    path = blended(knots, 0.0, [0.0] * len(knots), slopes_through(knots))
    found = path.at(np.linspace(0.0, path.length, 500))
    off = np.abs(np.linalg.norm(found[:, :2], axis=1) - 1.0).max()
    sagitta = 1.0 - np.cos(0.1)
    assert off < 0.05 * sagitta


def test_a_spline_is_passed_without_a_stop_and_as_fast_as_its_chords_would_be_without_corners() -> None:
    knots = smooth_knots(ARC, 12)
    smooth = timed_path(knots, LIMITS, slopes=slopes_through(knots))
    stopping = timed_path(ARC, LIMITS)
    line = timed_path([[0.0, 0.0, 0.0], [0.0, 1.2, 0.24]], LIMITS)
    assert smooth.duration < 0.6 * stopping.duration
    assert smooth.duration < 1.2 * line.duration
    assert np.allclose(smooth.waypoints[list(smooth.corners)], knots, atol=2e-4)


def test_a_corner_after_a_spline_is_rounded_and_continuous() -> None:
    knots = np.concatenate([smooth_knots(ARC, 8), [ARC[-1] + [0.5, 0.0, 0.0]]])
    steps = np.diff(knots, axis=0)
    units = steps / np.linalg.norm(steps, axis=1)[:, None]
    slopes = np.stack([units, units], axis=1)
    slopes[:-1] = slopes_through(knots[:-1])
    made = timed_path(knots, LIMITS, deviation=0.05, shares=[1.0] * len(knots), slopes=slopes)
    trajectory = made.trajectory(("a", "b", "c"))
    inner = np.array(trajectory.times[1:-1])
    for order in range(3):
        assert np.allclose(trajectory.at(inner, order), trajectory.at(inner - 1e-9, order), atol=1e-5)
    speeds = np.linalg.norm(trajectory.at(np.linspace(0.05, trajectory.duration - 0.05, 400), 1), axis=1)
    assert speeds.min() > 0.05
