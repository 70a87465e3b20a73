"""Tests of the time law along paths with rounded corners, against solvers that nobody here wrote."""

import numpy as np
import pytest
from scipy.optimize import minimize
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from kabo.motion import Held, MotionLimits, blended, timed_path
from kabo.motion.s_curves import line_limits, phases
from kabo.motion.section import section
from tests.motion.test_timed_motion import judge

LIMITS = MotionLimits.of(*(np.full(3, limit) for limit in (2.0, 8.0, 160.0)))
CORNERS = np.array([[0.0, 0.0, 0.0], [0.5, 0.1, 0.0], [0.6, 0.7, -0.2], [1.4, 0.7, 0.3]])


def duration(corners, limits, deviation=0.05, **options):
    return timed_path(corners, limits, deviation=deviation, shares=[1.0] * len(corners), **options).duration


@pytest.mark.parametrize("seed", range(6))
def test_with_a_huge_limit_of_jerk_the_motion_takes_as_long_as_toppra_says(seed):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1.0, 1.0, (int(rng.integers(3, 7)), 7))
    limits = MotionLimits.of(np.full(7, 2.0), np.full(7, 8.0), np.full(7, 2e4))
    path = blended(corners, 0.05)

    class Path:
        dof, path_interval = 7, (0.0, path.length)

        def __call__(self, places, order=0):
            return path.at(places, order)

    bounds = [np.stack([-row, row], axis=1) for row in limits.rows[:2]]
    constraints = [
        JointVelocityConstraint(bounds[0]),
        JointAccelerationConstraint(bounds[1]),
    ]
    grid = np.unique([np.linspace(a, b, 60) for a, b in zip(path.borders, path.borders[1:], strict=False)])
    speeds = TOPPRA(constraints, Path(), gridpoints=grid).compute_parameterization(0, 0)[1]
    best = (2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])).sum()
    assert 0.995 * best <= duration(corners, limits) <= 1.01 * best


@pytest.mark.parametrize("way", [0.05, 0.3, 1.0, 3.0])
def test_along_a_line_the_law_is_almost_as_fast_as_the_closed_form(way):
    """The corner of the path does not turn, so the whole is one line; and what is sent keeps all limits."""
    corners = np.array([[0.0, 0.0, 0.0], [0.4, -0.2, 0.1], [1.0, -0.5, 0.25]]) * way
    best = phases(*line_limits(corners[-1] - corners[0], LIMITS)).ticks * 1e-6
    assert best <= duration(corners, LIMITS) <= 1.04 * best


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_law_of_jerks_in_equal_steps_of_time_is_much_faster(seed):
    """Against sequential quadratic programming of the speed along the path in time, on a coarse grid of time."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1.0, 1.0, (3, 2))
    limits = MotionLimits.of(np.full(2, 2.0), np.full(2, 8.0), np.full(2, 100.0))
    path, steps = blended(corners, 0.1), 40
    own = section(path, limits, 1e-3, 1e-4, None).ends[-1] * 1e-6

    def run(z):
        """Values at the ends of steps from constant third derivatives of the parameter."""
        dt, jerk = z[0] / steps, z[1:] * 100.0
        a = np.concatenate([[0.0], np.cumsum(jerk * dt)])
        v = np.concatenate([[0.0], np.cumsum(a[:-1] * dt + jerk * dt**2 / 2)])
        s = np.concatenate([[0.0], np.cumsum(v[:-1] * dt + a[:-1] * dt**2 / 2 + jerk * dt**3 / 6)])
        return s, v, a, jerk

    def room(z):
        s, v, a, jerk = run(z)
        p = [path.at(np.clip(s, 0.0, path.length), order) for order in range(4)]
        v, a = v[:, None], a[:, None]
        velocity, acceleration = p[1] * v, p[2] * v**2 + p[1] * a
        jerks = [
            (p[3] * v**3 + 3.0 * p[2] * v * a)[side] + p[1][side] * jerk[:, None]
            for side in (slice(None, -1), slice(1, None))
        ]
        shares = [velocity / 2.0, acceleration / 8.0, *(each / 100.0 for each in jerks)]
        return np.concatenate([np.concatenate([1.0 - each.ravel(), 1.0 + each.ravel()]) for each in shares])

    def ends(z):
        s, v, a, _ = run(z)
        return np.array([s[-1] - path.length, v[-1], a[-1]])

    third = np.repeat([1.0, -1.0, -1.0, 1.0], steps // 4)
    start = np.concatenate([[2.0 * own], third * path.length * 32.0 / (2.0 * own) ** 3 / 100.0])
    found = minimize(
        lambda z: z[0], start, method="SLSQP", options={"maxiter": 150, "ftol": 1e-5},
        constraints=[{"type": "ineq", "fun": room}, {"type": "eq", "fun": ends}],
    )  # fmt: skip
    assert room(found.x).min() >= -2e-3
    assert 0.9 * found.x[0] <= own <= 1.03 * found.x[0]


@pytest.mark.parametrize("seed", range(4))
def test_at_nearly_all_times_some_joint_is_at_one_of_its_limits(seed):
    """A necessary condition of motions that are as fast as possible [Bobrow 1985, for jerk Shiller 1994]."""
    rng = np.random.default_rng(seed)
    limits = MotionLimits.of(*(np.full(7, limit) for limit in (2.0, 8.0, 160.0)))
    motion = timed_path(rng.uniform(-1.0, 1.0, (4, 7)), limits, deviation=0.05, shares=[1.0] * 4).trajectory(
        "abcdefg"
    )
    times = np.linspace(*motion.times[:: len(motion.times) - 1], 2001)[1:-1]
    used = [np.abs(motion.at(times, order)) / limit for order, limit in enumerate(limits.rows, 1)]
    busy = np.max(used, axis=(0, 2))
    assert (busy > 0.9).mean() > 0.9
    assert np.median(busy) > 0.95


def test_a_blend_saves_time_and_a_wider_one_saves_more():
    stopping = timed_path(CORNERS, LIMITS).duration
    assert duration(CORNERS, LIMITS) < 0.97 * stopping
    assert duration(CORNERS, LIMITS, 0.1) < duration(CORNERS, LIMITS)


def test_where_blends_cost_time_the_motion_stops():
    corners = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.02, 0.0]])
    made = timed_path(corners, LIMITS, deviation=1e-5, shares=[1.0] * 3)
    assert made.duration == timed_path(corners, LIMITS).duration


def test_straights_are_followed_exactly_and_blends_within_the_tolerance_of_chords():
    made = timed_path(CORNERS, LIMITS, deviation=0.05, shares=[1.0] * 4, chord=5e-4, tolerance=1e-5)
    steps = np.linalg.norm(np.diff(made.waypoints, axis=0), axis=1)
    straight = made.deviations.max(axis=1) <= 2e-9
    assert steps[straight].sum() > 0.5 * steps.sum()
    assert 1e-5 < made.deviations.max() < 1e-3
    coarse = timed_path(CORNERS, LIMITS, deviation=0.05, shares=[1.0] * 4, chord=5e-3)
    assert len(coarse.waypoints) < len(made.waypoints)


def test_there_and_back_stops_where_the_path_turns_back():
    corners = [[0.0, 0.0, 0.0], [0.5, 0.2, 0.1], [0.0, 0.0, 0.0]]
    made = timed_path(corners, LIMITS, deviation=0.1, shares=[1.0] * 3)
    assert made.duration == timed_path(corners, LIMITS).duration
    judge(made, LIMITS)


def test_a_corner_that_is_given_twice_is_a_stop():
    corners = np.insert(CORNERS, 2, CORNERS[2], axis=0)
    made = timed_path(corners, LIMITS, deviation=0.05, shares=[1.0] * 5)
    assert made.corners[2] == made.corners[3]
    when = made.passing[made.corners[2]]
    assert np.abs(made.trajectory(("a", "b", "c")).at(when, 1)).max() < 1e-9


def test_thousands_of_way_points_take_memory_and_time_in_proportion():
    angles = np.linspace(0.0, 60.0, 2000)
    corners = np.stack([np.cos(angles), np.sin(angles), 0.05 * angles], axis=1)
    made = timed_path(corners, LIMITS, deviation=1e-3, shares=[1.0] * len(corners))
    assert made.duration < 0.2 * timed_path(corners, LIMITS).duration
    judge(made, LIMITS)


def swung(q):
    """The places of a body at the end of an arm of three joints in the plane."""
    angles = np.cumsum(q, axis=-1)
    zero = np.zeros(len(q))
    return np.stack([np.cos(angles).sum(axis=1), zero, np.sin(angles).sum(axis=1)], axis=1) * 0.4


@pytest.mark.parametrize("shares", [[0.0] * 4, [1.0] * 4])
def test_what_is_held_is_not_accelerated_more_than_its_bound(shares):
    held = Held(swung, 11.0)
    made = timed_path(CORNERS, LIMITS, deviation=0.05, shares=shares, held=held)
    motion, step = judge(made, LIMITS), 1e-4
    times = np.arange(step, motion.duration - step, 7e-4)
    before, here, after = (swung(motion.at(times + d)) for d in (-step, 0.0, step))
    loads = np.linalg.norm((before - 2.0 * here + after) / step**2 - np.array(held.gravity), axis=1)
    assert loads.max() <= 11.0
    assert loads.max() >= 10.3
    assert made.duration > timed_path(CORNERS, LIMITS, deviation=0.05, shares=shares).duration


def test_what_slips_at_rest_is_refused():
    with pytest.raises(ValueError, match="slips even at rest"):
        timed_path(CORNERS, LIMITS, held=Held(swung, 9.0))


def test_the_same_path_gives_the_same_bytes():
    first, second = (timed_path(CORNERS, LIMITS, deviation=0.05, shares=[1.0] * 4) for _ in range(2))
    assert first.trajectory(("a", "b", "c")) == second.trajectory(("a", "b", "c"))
    assert first.waypoints.tobytes() == second.waypoints.tobytes()
