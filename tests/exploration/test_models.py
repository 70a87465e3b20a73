"""What is known of one case: V, Φ^α and D agree with plain Gaussian processes and numeric integrals [T e4, e8, e9]."""

import numpy as np
import pytest

from kabo.exploration import Validity
from kabo.exploration.models import FIT_AT, NOISE, NOISES, SCALE, SCALES, CaseModel, normalised
from tests.support import oracles_exploration as oracles
from tests.support.small_explorations import exploration, grid, tell_random


def model(explored) -> CaseModel:
    names, options = explored.outcomes, explored.validity_options
    return CaseModel(explored.space, explored.trials, names, options, {})


@pytest.mark.parametrize(
    ("dimensions", "count", "scale", "noise"), [(1, 12, 0.12, 0.15), (2, 60, 0.2, 0.4), (3, 40, 0.5, 0.6)]
)
def test_validity_is_the_probability_of_a_positive_answer(dimensions, count, scale, noise):
    explored = exploration(dimensions, validity=Validity(scale=scale, noise=noise))
    tell_random(explored, count)
    points = grid(explored.space, {1: 60, 2: 12, 3: 6}[dimensions])
    expected = oracles.validity(explored.trials, explored, oracles.scaled(explored, points))
    np.testing.assert_allclose(explored.validity({}, points), expected, atol=1e-10)
    assert expected.min() < 0.3
    assert expected.max() > 0.7


def test_validity_is_one_half_where_nothing_is_known():
    explored = exploration()
    np.testing.assert_array_equal(explored.validity({}, grid(explored.space, 4)), 0.5)
    tell_random(explored, 1)
    far = [{"a": 1.0, "b": -0.08}]
    assert explored.validity({}, far)[0] == pytest.approx(0.5, abs=1e-5)


@pytest.mark.parametrize("count", [3, 12, 18])
def test_outcomes_are_those_of_a_plain_cholesky_until_there_are_enough_to_fit(count):
    explored = exploration(outcomes=("torque", "noise"))
    tell_random(explored, count, spread=0.4)
    points = grid(explored.space, 10)
    at = oracles.scaled(explored, points)
    for name, (mean, deviation) in explored.predict({}, points).items():
        expected = oracles.outcome(explored.trials, explored, name, SCALE, NOISE, at)
        np.testing.assert_allclose(mean, expected[0], rtol=1e-12, atol=1e-11)
        np.testing.assert_allclose(deviation, expected[1], rtol=1e-10)


@pytest.mark.parametrize("count", [20, 39, 41])
def test_scale_and_noise_are_the_most_likely_of_those_tried(count):
    explored = exploration()
    tell_random(explored, count, spread=0.4)
    valid = [each for each in explored.trials if each.valid]
    assert len(valid) == count
    first = valid[: max(each for each in FIT_AT if each <= count)]
    values = np.array([each.outcomes["torque"] for each in first])
    points = oracles.scaled(explored, [each.parameters for each in first])
    normal = (values - values.mean()) / values.std()
    options = [(scale, noise) for scale in SCALES for noise in NOISES]
    likely = max(options, key=lambda option: oracles.Gaussian(points, normal, *option).log_likelihood())
    expected = oracles.outcome(
        explored.trials, explored, "torque", *likely, oracles.scaled(explored, grid(explored.space, 7))
    )
    mean, deviation = explored.predict({}, grid(explored.space, 7))["torque"]
    np.testing.assert_allclose(mean, expected[0], atol=1e-10)
    np.testing.assert_allclose(deviation, expected[1], atol=1e-10)


def test_the_mean_error_of_leaving_one_out_is_that_of_models_made_anew():
    explored = exploration()
    tell_random(explored, 15, spread=0.4)
    points = oracles.scaled(explored, [each.parameters for each in explored.trials])
    values = np.array([each.outcomes["torque"] for each in explored.trials])
    normal = (values - values.mean()) / values.std()
    error = np.abs(oracles.Gaussian(points, normal, SCALE, NOISE).left_out() - normal).mean() * values.std()
    assert explored.leave_one_out({})["torque"] == pytest.approx(error, abs=1e-11)


def test_nothing_is_left_out_of_two_trials():
    explored = exploration(outcomes=("torque", "noise"))
    tell_random(explored, 2, spread=0.1)
    assert explored.leave_one_out({}) == {"torque": None, "noise": None}


@pytest.mark.parametrize("alpha", [1e-9, 0.3, 0.5, 0.7, 0.95, 0.9999])
def test_the_valid_set_is_where_validity_is_strictly_greater_than_alpha(alpha):
    explored = exploration()
    tell_random(explored, 40)
    points = np.random.default_rng(1).random((3_000, 2))
    known = model(explored)
    np.testing.assert_array_equal(known.admissible(points, alpha), known.validity(points) > alpha)


def test_a_point_whose_validity_is_alpha_itself_is_not_in_the_valid_set():
    explored = exploration()
    tell_random(explored, 40)
    known = model(explored)
    for point in np.random.default_rng(2).random((50, 1, 2)):
        alpha = float(known.validity(point)[0])
        assert not known.admissible(point, np.nextafter(alpha, 1.0))[0]
        assert known.admissible(point, alpha - 1e-9)[0]


def test_far_from_all_trials_validity_is_one_half_and_not_greater():
    explored = exploration(1, validity=Validity(scale=0.0625, noise=1.0))
    explored.tell({}, {"a": 0.0}, True, {"torque": 1.0})
    points = np.linspace(0.0, 1.0, 400)[:, None]
    known = model(explored)
    assert (known.validity(points) == 0.5).any()
    np.testing.assert_array_equal(known.admissible(points, 0.5), known.validity(points) > 0.5)


@pytest.mark.parametrize("scale", [0.1, 0.12, 0.5])
def test_entropy_is_that_of_the_outcome_with_a_scale_of_at_most_that_of_validity(scale):
    explored = exploration(validity=Validity(scale=scale))
    tell_random(explored, 30)
    at = np.random.default_rng(3).random((200, 2))
    valid = [each for each in explored.trials if each.valid]
    assert len(valid) < FIT_AT[0]
    points = oracles.scaled(explored, [each.parameters for each in valid])
    process = oracles.Gaussian(points, np.zeros(len(valid)), min(SCALE, scale), NOISE)
    expected = process.mean_and_deviation(at)[1]
    np.testing.assert_allclose(model(explored).entropy(at), np.log(expected), atol=1e-6)


def test_the_entropy_of_several_outcomes_is_their_sum():
    explored = exploration(outcomes=("torque", "noise"), validity=Validity(scale=1.0))
    tell_random(explored, 60, spread=0.5)
    known = model(explored)
    at = np.random.default_rng(3).random((50, 2))
    deviations = [each.process.mean_and_deviation(at)[1] for each in known.outcomes.values()]
    assert not np.allclose(*deviations)
    np.testing.assert_allclose(known.entropy(at), np.log(deviations).sum(axis=0), atol=1e-12)


@pytest.mark.parametrize(
    "values", [[3.0], [0.0], [-1e100, 1e100], [7.0] * 9, [0.0] * 5, [1e-300, 2e-300], [1e9, 1e9 + 1e-2]]
)
def test_normalised_values_are_finite_and_lead_back(values):
    normal, centre, spread = normalised(values)
    assert np.isfinite(normal).all()
    assert spread > 0
    np.testing.assert_allclose(centre + spread * normal, values, rtol=1e-15)
    assert np.abs(normal).max() <= 1.0 + 1e-9


def test_an_offset_far_greater_than_the_variation_is_taken_out():
    normal, _, spread = normalised([1.7e9, 1.7e9 + 0.25, 1.7e9 + 0.5])
    assert spread == pytest.approx(0.2041, abs=1e-4)
    np.testing.assert_allclose(normal, [-1.2247, 0.0, 1.2247], atol=1e-4)
