"""Gaussian processes with a fixed squared exponential kernel, conditioned on data [T 4.4, e8, e9].

The regression is scikit-learn's. Its last bits depend on the number of BLAS threads, and so would the choice between
two candidates that are nearly equal: all linear algebra here runs in one thread.
"""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import cache
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.errors import KaboError

MISSING = 'exploration needs scikit-learn: install it with pip install "kabo[explore]"'


class GaussianProcess:
    """A Gaussian process with zero mean and unit variance, given values with noise at points of the unit cube."""

    def __init__(self, points: Array, values: Array, scale: float, noise: float) -> None:
        """Conditions the process on (n, d) points and their (n,) values.

        Args:
            points, values: the data.
            scale: the length λ of the kernel exp(−‖φ − φ′‖² / 2λ²).
            noise: the standard deviation of each value.

        Raises:
            KaboError: scikit-learn is not installed.
        """
        self.values, self.noise = values, noise
        with one_thread():
            self._regressor = _regressor(scale, noise).fit(points, values)

    def mean(self, points: Array) -> Array:
        """The expected values at points (n, d), as (n,)."""
        with one_thread():
            found: Array = self._regressor.predict(points)
        return found

    def mean_and_deviation(self, points: Array) -> tuple[Array, Array]:
        """Expected values at points (n, d), and the standard deviations of the function without noise; (n,) each."""
        if len(points) == 0:
            return np.empty(0), np.empty(0)
        with one_thread():
            mean, deviation = self._regressor.predict(points, return_std=True)
        return mean, deviation

    def left_out(self) -> Array:
        """The leave-one-out predictions (n,): each value as expected from all the others [Rasmussen, Williams 5.12]."""
        from scipy.linalg import cho_solve  # with scikit-learn

        lower, weights = self._regressor.L_, self._regressor.alpha_
        with one_thread():
            inverse = cho_solve((lower, True), np.eye(len(lower)))
        found: Array = self.values - weights / np.diag(inverse)
        return found


def log_likelihoods(points: Array, values: Array, scale: float, noises: Sequence[float]) -> list[float]:
    """The log marginal likelihood of the values (n,) for each of the noises [Rasmussen, Williams 2.30].

    Not by scikit-learn's regressor: one for each noise would compute the kernel matrix anew, and its factor twice.

    Args:
        points, values, scale: as for `GaussianProcess`.
        noises: the standard deviations of a value to compare.
    """
    from scipy.linalg import cholesky, solve_triangular  # with scikit-learn

    n, found = len(values), []
    with one_thread():
        kernel = _sklearn().kernels.RBF(scale)(points)
        for noise in noises:
            lower = cholesky(kernel + noise**2 * np.eye(n), lower=True, check_finite=False)
            white = solve_triangular(lower, values, lower=True, check_finite=False)
            found.append(float(-0.5 * (white @ white + n * np.log(2 * np.pi)) - np.log(np.diag(lower)).sum()))
    return found


def one_thread() -> AbstractContextManager[Any]:
    """A context in which linear algebra runs in one thread."""
    limited: AbstractContextManager[Any] = _libraries().limit(limits=1, user_api="blas")
    return limited


def require_scikit_learn() -> None:
    """Checks that scikit-learn is there: the first question of a case does without, the second does not.

    Raises:
        KaboError: it is not installed.
    """
    _sklearn()


@cache
def _libraries() -> Any:
    """The controller of BLAS threads; made once, since finding the libraries takes longer than an `ask`."""
    _sklearn()
    from threadpoolctl import ThreadpoolController  # comes with scikit-learn

    return ThreadpoolController()


@cache
def _sklearn() -> Any:
    try:
        from sklearn import gaussian_process  # 0.7 s: only explorations pay for it
    except ModuleNotFoundError as error:
        if error.name != "sklearn":
            raise
        raise KaboError(MISSING) from error
    return gaussian_process


def _regressor(scale: float, noise: float) -> Any:
    library = _sklearn()
    kernel = library.kernels.RBF(scale, "fixed")
    return library.GaussianProcessRegressor(kernel, alpha=noise**2, optimizer=None)
