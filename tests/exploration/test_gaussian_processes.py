"""The Gaussian process is the textbook's: mean, deviation, likelihood and leaving one out agree with a plain Cholesky."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from kabo.exploration.gaussian_processes import GaussianProcess, log_likelihoods
from tests.support.oracles_exploration import Gaussian

DATA = [(1, 2, 0.12, 0.15), (7, 1, 0.3, 0.05), (40, 2, 0.12, 0.15), (60, 3, 0.4, 0.6), (90, 6, 0.8, 0.1)]


def drawn(count: int, dimensions: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    generator = np.random.default_rng(count)
    points = generator.random((count, dimensions))
    return points, generator.normal(size=count), generator.random((50, dimensions))


@pytest.mark.parametrize(("count", "dimensions", "scale", "noise"), DATA)
def test_mean_and_deviation_are_those_of_a_plain_cholesky(count, dimensions, scale, noise):
    points, values, at = drawn(count, dimensions)
    mean, deviation = GaussianProcess(points, values, scale, noise).mean_and_deviation(at)
    expected = Gaussian(points, values, scale, noise).mean_and_deviation(at)
    np.testing.assert_allclose(mean, expected[0], atol=1e-11)
    np.testing.assert_allclose(deviation**2, expected[1] ** 2, atol=1e-12)
    np.testing.assert_allclose(GaussianProcess(points, values, scale, noise).mean(at), expected[0], atol=1e-11)


@pytest.mark.parametrize(("count", "dimensions", "scale", "noise"), DATA[1:])
def test_leaving_one_out_is_that_of_processes_made_anew(count, dimensions, scale, noise):
    points, values, _ = drawn(count, dimensions)
    expected = Gaussian(points, values, scale, noise).left_out()
    np.testing.assert_allclose(GaussianProcess(points, values, scale, noise).left_out(), expected, atol=1e-10)


@pytest.mark.parametrize(("count", "dimensions", "scale", "noise"), DATA)
def test_the_likelihood_is_that_of_a_plain_cholesky(count, dimensions, scale, noise):
    points, values, _ = drawn(count, dimensions)
    noises = (noise, 0.5, 2 * noise)
    expected = [Gaussian(points, values, scale, each).log_likelihood() for each in noises]
    assert log_likelihoods(points, values, scale, noises) == pytest.approx(expected, abs=1e-9)


def test_no_points_have_no_values():
    points, values, _ = drawn(5, 2)
    mean, deviation = GaussianProcess(points, values, 0.12, 0.15).mean_and_deviation(np.empty((0, 2)))
    assert mean.shape == deviation.shape == (0,)


BYTES = """
import json
from tests.support.small_explorations import exploration, grid, run, tell_random
e = exploration(outcomes=("torque", "noise"))
tell_random(e, 400, spread=0.9)
run(e, 2)
points = grid(e.space, 9)
answers = [e.ask().parameters, e.infer({"torque": 2.0}).parameters, e.leave_one_out({}), list(e.validity({}, points))]
answers += [[list(array) for pair in e.predict({}, points).values() for array in pair], e.digest]
print(json.dumps(answers))
"""


@pytest.mark.slow
def test_one_and_two_threads_of_linear_algebra_give_the_same_bytes():
    answers = []
    for threads in ("1", "2"):
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        environment = {**os.environ, **dict.fromkeys(names, threads)}
        child = [sys.executable, "-c", BYTES]
        answers.append(subprocess.run(child, env=environment, capture_output=True, text=True, check=True).stdout)
    assert json.loads(answers[0])
    assert answers[0] == answers[1]
