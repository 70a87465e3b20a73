"""Tests of the trajectory as data, and of what can be done with it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.errors import ArgumentError
from kabo.motion import MotionLimits, Trajectory, timed_path

SEEDS = st.integers(0, 10**6)


def random_motion(seed):
    """A motion along random corners, from 0.25 s on, and its limits."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    limits = MotionLimits.of(*(rng.uniform(0.5, 1.5, n) * k for k in (1.0, 5.0, 60.0)))
    made = timed_path(rng.normal(size=(4, n)), limits)
    return made.trajectory([f"j{i}" for i in range(n)], start=0.25), limits


def everywhere(motion, count=500):
    return np.linspace(motion.times[0], motion.times[-1], count)


def test_a_linear_trajectory_passes_its_way_points_at_their_times():
    made = Trajectory.linear(("a", "b"), [(0.0, 1.0), (0.5, 1.0), (0.5, -1.0)], (0.0, 1.0, 3.0))
    assert np.allclose(
        made.at([0.0, 0.5, 1.0, 2.0, 3.0, 9.0]), [(0, 1), (0.25, 1), (0.5, 1), (0.5, 0), (0.5, -1), (0.5, -1)]
    )
    assert np.allclose(made.at([0.5, 2.0, 9.0], 1), [(0.5, 0), (0, -1), (0, 0)])
    assert made.duration == 3.0


def test_there_is_no_derivative_of_a_negative_order():
    whole, _ = random_motion(0)
    for asked in (whole.bounds, whole.piece_bounds, lambda order: whole.at(0.5, order)):
        with pytest.raises(ValueError, match="the order 0 or more, not -1"):
            asked(-1)


@given(SEEDS, st.floats(0.001, 0.999))
def test_both_parts_of_a_motion_joined_again_are_the_motion(seed, share):
    whole, _ = random_motion(seed)
    time = whole.times[0] + share * whole.duration
    first, second = whole.split(time)
    assert first.times[-1] == second.times[0] == time
    assert first.waypoints[-1] == second.waypoints[0]
    assert np.allclose(first.waypoints[-1], whole.at(time), atol=1e-8)
    for order in range(3):
        assert np.allclose(
            first.joined(second).at(everywhere(whole), order), whole.at(everywhere(whole), order), atol=1e-9
        )
    inner = [row for row in first.joined(second).waypoints if row != first.waypoints[-1]]
    assert inner == [row for row in whole.waypoints if row != first.waypoints[-1]]


@given(SEEDS)
def test_a_motion_reversed_is_where_the_motion_was_at_the_mirrored_time(seed):
    whole, _ = random_motion(seed)
    back, times = whole.reversed(), everywhere(whole)
    mirrored = whole.times[0] + whole.times[-1] - times
    assert np.allclose(back.at(times), whole.at(mirrored), atol=1e-9)
    inner = slice(3, -3)
    assert np.allclose(back.at(times[inner], 1), -whole.at(mirrored[inner], 1), atol=1e-8)
    assert back.waypoints == whole.waypoints[::-1]


@given(SEEDS, st.floats(0.3, 5.0))
def test_a_motion_slowed_down_is_at_the_same_places_later(seed, factor):
    whole, _ = random_motion(seed)
    slow, times = whole.scaled(factor), everywhere(whole)[3:-3]
    later = whole.times[0] + (times - whole.times[0]) * factor
    assert slow.duration == pytest.approx(factor * whole.duration)
    for order in range(3):
        assert np.allclose(slow.at(later, order) * factor**order, whole.at(times, order), atol=1e-7)


@given(SEEDS, st.floats(-5.0, 5.0))
def test_a_shifted_motion_is_at_the_same_places_later(seed, seconds):
    whole, _ = random_motion(seed)
    times = everywhere(whole)
    assert np.allclose(whole.shifted(seconds).at(times + seconds), whole.at(times), atol=1e-8)


@given(SEEDS)
def test_samples_are_within_the_bounds(seed):
    whole, limits = random_motion(seed)
    samples = whole.sampled(1000.0)
    assert samples.times[0] == whole.times[0]
    assert samples.times[-1] == whole.times[-1]
    assert np.all(np.diff(samples.times) <= 1e-3 + 1e-9)
    for order, found in enumerate((samples.positions, samples.velocities, samples.accelerations)):
        low, high = whole.bounds(order)
        assert np.all(low <= found.min(axis=0) + 1e-9)
        assert np.all(found.max(axis=0) <= high + 1e-9)
    assert np.all(np.abs(samples.velocities) <= limits.velocity)


@pytest.mark.parametrize("factor", [1.0, 40.0])
def test_rounded_coefficients_change_no_value_of_slow_motions_by_more_than_a_billionth(factor):
    slow = random_motion(3)[0].scaled(factor)
    kept, times = slow.rounded(), everywhere(slow)
    assert kept.rounded() == kept
    for order in range(3):
        assert np.allclose(kept.at(times, order), slow.at(times, order), atol=1e-9)


def test_motions_that_do_not_fit_together_are_not_joined():
    one = Trajectory.linear(("a",), [(0.0,), (1.0,)], (0.0, 1.0))
    for other, words in [
        (Trajectory.linear(("b",), [(1.0,), (2.0,)], (1.0, 2.0)), "different joints"),
        (Trajectory.linear(("a",), [(1.0,), (2.0,)], (2.0, 3.0)), "shifted"),
        (Trajectory.linear(("a",), [(1.5,), (2.0,)], (1.0, 2.0)), "away from the end"),
    ]:
        with pytest.raises(ValueError, match=words):
            one.joined(other)


def test_a_motion_is_split_only_inside_its_time_and_sampled_at_a_positive_rate():
    one = Trajectory.linear(("a",), [(0.0,), (1.0,)], (0.0, 1.0))
    for made in (lambda: one.split(1.0), lambda: one.sampled(0.0), lambda: one.scaled(0.0)):
        with pytest.raises(ValueError, match=r"time|rate|factor"):
            made()


def test_a_path_there_and_back_is_split_on_the_way_back():
    there = Trajectory.linear(("a",), [(0.0,), (1.0,), (0.0,)], (0.0, 1.0, 2.0))
    first, second = there.split(1.5)
    assert first.waypoints == ((0.0,), (1.0,), (0.5,))
    assert second.waypoints == ((0.5,), (0.0,))


@given(SEEDS, st.floats(0.3, 5.0))
def test_a_motion_that_begins_at_no_whole_nanosecond_is_reversed_exactly(seed, factor):
    """Times that were rounded would let the joints jump at borders of pieces, by velocity times half a nanosecond."""
    odd = random_motion(seed)[0].scaled(factor)
    twice, times = odd.reversed().reversed(), everywhere(odd)
    assert np.allclose(twice.at(times), odd.at(times), atol=1e-10)
    for made in (twice, odd.shifted(0.1 / 3.0)):
        assert np.allclose(made.spans, odd.spans, rtol=0.0, atol=1e-11)


LINE = Trajectory.linear(("a",), [(0.0,), (1.0,)], (0.0, 1.0))
NO_MOTIONS = [
    (lambda: Trajectory.linear(("a",), [(0.0,), (1.0,)], (0.0, 0.0)), "increase"),
    (lambda: Trajectory.linear(("a",), [(0.0,), (1.0,)], (0.0, float("nan"))), "finite"),
    (lambda: Trajectory.linear(("a",), [(0.0,), (1.0,), (2.0,)], (0.0, 1.0)), "2 times for 3 way points"),
    (lambda: Trajectory.linear((), [], ()), "0 times for 0 way points"),
    (lambda: Trajectory.linear(("a",), [(0.0, 1.0), (1.0, 1.0)], (0.0, 1.0)).at(0.5), "of 2 joints"),
    (lambda: Trajectory.linear(("a",), [(0.0,), (float("nan"),)], (0.0, 1.0)).at(0.5), "not a finite number"),
    (lambda: Trajectory.linear(("a",), [(0.0,)], (0.0,)).at(0.0), "one piece or more"),
    (lambda: replace(LINE, times=(1.0, 0.0)).at(0.5), "0.0 s follows 1.0 s"),
    (lambda: replace(LINE, times=(0.0, 1.0, 2.0)).sampled(10.0), "3 times for 1 pieces"),
    (lambda: replace(LINE, coefficients=(((0.0,) * 7,),)).bounds(), "degree 6"),
    (lambda: replace(LINE, joints=("a", "b")).split(0.5), "of 1 joints"),
    (lambda: replace(LINE, deviation=-1e-9).reversed(), "never -1e-09"),
    (lambda: LINE.at(0.5, -1), "not -1"),
    (lambda: LINE.scaled(float("inf")), "not inf"),
    (lambda: LINE.scaled(1e-300), "not 1e-300"),
    (lambda: LINE.shifted(float("nan")), "seconds must be a number, and finite, not nan"),
    (lambda: LINE.sampled(float("inf")), "more than 100000000 samples"),
]


@pytest.mark.parametrize(("made", "words"), NO_MOTIONS, ids=[words for _, words in NO_MOTIONS])
def test_what_is_no_motion_is_told_by_one_error(made, words):
    with pytest.raises(ValueError, match=words):
        made()


def test_what_is_of_another_kind_is_one_clear_error_when_it_is_given():
    """It was an error of Python or numpy when values were first asked for, or not at all."""
    for name, wrong in (
        ("joints", ["a", None, 3, (1,), (None,), b"a"]),
        ("waypoints", [None, 3, "ab", (0.0, 1.0), ((None,), (1,)), (("x",), (1.0,)), {}, np.zeros((2, 1))]),
        ("times", [None, 3, "01", ("0", "1"), (None, 1.0), (0.0, [1.0]), (0j, 1j), np.zeros(2)]),
        ("coefficients", [None, 3, "a", {}, np.zeros((1, 1, 2))]),
        ("deviation", [None, "0", 1j, (0.0,)]),
    ):
        for each in wrong:
            with pytest.raises(ArgumentError, match=name):
                replace(LINE, **{name: each})


def test_coefficients_that_are_no_numbers_are_one_clear_error_when_values_are_asked_for():
    for wrong in ((((0.0, 1j),),), ((("x", 1.0),),), ((([0.0], 1.0),),), ((0.0,),)):
        with pytest.raises(ArgumentError, match="coefficients must be"):
            replace(LINE, coefficients=wrong).at(0.5)


def test_arrays_of_other_kinds_are_one_clear_error():
    line, arrays = Trajectory.linear, Trajectory.of_arrays
    good, times, padded = [(0.0,), (1.0,)], (0.0, 1.0), np.zeros((1, 1, 2))
    for made, name in (
        (lambda: line(("a",), [[0], ["x"]], times), "waypoints"),
        (lambda: line(("a",), None, times), "waypoints"),
        (lambda: line(("a",), [[0], [1, 2]], times), "waypoints"),
        (lambda: line(("a",), [0, 1], times), "waypoints"),
        (lambda: line(("a",), good, None), "times"),
        (lambda: line(("a",), good, ["0", "x"]), "times"),
        (lambda: line(None, good, times), "joints"),
        (lambda: arrays(("a",), good, times, None), "coefficients"),
        (lambda: arrays(("a",), good, times, [1.0]), "coefficients"),
        (lambda: arrays(("a",), good, 3.0, padded), "times"),
        (lambda: arrays(("a",), good, times, padded, None), "deviation"),
    ):
        with pytest.raises(ArgumentError, match=name):
            made()


def test_a_motion_that_stands_still_may_have_constants_alone():
    """`of_arrays` takes up to six coefficients, and one of them was an error of numpy."""
    assert Trajectory.of_arrays(("a",), [(0.5,)], (0.0, 1.0), np.full((1, 1, 1), 0.5)).at(0.5) == [0.5]


@pytest.mark.parametrize("wrong", [1.5, "1", None, True])
def test_what_is_no_order_of_a_derivative_is_told(wrong):
    whole, _ = random_motion(0)
    for asked in (whole.bounds, whole.piece_bounds, lambda order: whole.at(0.5, order)):
        with pytest.raises(ArgumentError, match="derivatives have the order 0 or more"):
            asked(wrong)


def test_derivatives_of_any_order_are_found_at_once():
    assert np.all(random_motion(0)[0].at(0.5, 10**12) == 0.0)


@pytest.mark.parametrize("wrong", [-1, 13, 99, 1.5, "x"])
def test_pieces_are_halved_up_to_twelve_times(wrong):
    with pytest.raises(ArgumentError, match="halvings must be a whole number from 0 to 12"):
        random_motion(0)[0].bounds(halvings=wrong)


NO_PATHS = [((float("nan"),), (1.0,)), ((0.0,), (float("inf"),)), ((10**400,), (1.0,))]


@pytest.mark.parametrize("path", NO_PATHS, ids=["nan", "inf", "huge"])
def test_a_motion_along_no_path_is_refused(path):
    motion = Trajectory(("a",), path, (0.0, 1.0), (((0.0, 1.0),),))
    with pytest.raises(ValueError, match="way point"):
        motion.split(0.5)
    with pytest.raises(ValueError, match="way point"):
        motion.at(0.5)


def test_a_motion_without_a_path_is_split_and_joined_without_one():
    """Robots over a network are sent polynomials alone."""
    motion = Trajectory(("a",), (), (0.0, 1.0), (((0.0, 1.0),),))
    before, after = motion.split(0.25)
    assert before.waypoints == after.waypoints == ()
    assert before.at(0.25) == after.at(0.25) == motion.at(0.25) == 0.25
    whole = before.joined(after)
    assert (whole.waypoints, whole.times) == ((), (0.0, 0.25, 1.0))


def test_only_motions_are_joined():
    with pytest.raises(ArgumentError, match="other"):
        random_motion(0)[0].joined(None)


def test_a_motion_with_one_way_point_is_split_there():
    before, after = Trajectory(("a",), ((0.5,),), (0.0, 1.0), (((0.5,),),)).split(0.25)
    assert set(before.waypoints) == set(after.waypoints) == {(0.5,)}
    assert before.times == (0.0, 0.25) and after.times == (0.25, 1.0)
