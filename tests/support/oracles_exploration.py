"""Judges of explorations: a plain Cholesky Gaussian process, the scaled space, integrals of densities."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from kabo.exploration import Exploration, Trial


class Gaussian:
    """A Gaussian process of zero mean and unit variance, given noisy values at points (n, d), as textbooks write it."""

    def __init__(self, points: np.ndarray, values: np.ndarray, scale: float, noise: float) -> None:
        self.points, self.values = np.array(points, float), np.array(values, float)
        self.scale, self.noise = scale, noise
        self.lower = np.linalg.cholesky(self.kernel(points, points) + noise**2 * np.eye(len(points)))

    def kernel(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """exp(−‖φ − φ′‖² / 2λ²), one by one."""
        return np.array(
            [[math.exp(-float(((a - b) ** 2).sum()) / (2 * self.scale**2)) for b in second] for a in first]
        )

    def mean_and_deviation(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the function, without noise, at points (m, d)."""
        covariance = self.kernel(at, self.points)
        weights = np.linalg.solve(self.lower.T, np.linalg.solve(self.lower, self.values))
        known = np.linalg.solve(self.lower, covariance.T)
        return covariance @ weights, np.sqrt(np.maximum(1.0 - (known**2).sum(axis=0), 0.0))

    def left_out(self) -> np.ndarray:
        """What is expected at each point from all others: each is left out in turn, and a process made anew."""
        found = []
        for k in range(len(self.points)):
            rest = np.arange(len(self.points)) != k
            without = Gaussian(self.points[rest], self.values[rest], self.scale, self.noise)
            found.append(float(without.mean_and_deviation(self.points[k : k + 1])[0][0]))
        return np.array(found)

    def log_likelihood(self) -> float:
        """The logarithm of the density of the values."""
        half = np.linalg.solve(self.lower, self.values)
        return float(
            -0.5 * half @ half - np.log(np.diag(self.lower)).sum() - 0.5 * len(half) * math.log(2 * math.pi)
        )


def scaled(exploration: Exploration, points: Sequence[Mapping[str, float]]) -> np.ndarray:
    """Parameters as points of the unit cube, (n, d)."""
    bounds = exploration.space.parameters.items()
    return np.array([[(point[name] - low) / (high - low) for name, (low, high) in bounds] for point in points])


def validity(trials: Sequence[Trial], exploration: Exploration, at: np.ndarray) -> np.ndarray:
    """V at points (m, d) of the unit cube: the integral of the next answer's density from 0 on [T e9, put right]."""
    options = exploration.validity_options
    answers = [1.0 if each.valid else -1.0 for each in trials]
    points = scaled(exploration, [each.parameters for each in trials])
    mean, deviation = Gaussian(points, answers, options.scale, options.noise).mean_and_deviation(at)
    return np.array([positive(m, math.hypot(s, options.noise)) for m, s in zip(mean, deviation, strict=True)])


def positive(mean: float, deviation: float) -> float:
    """The probability that a normal variable is positive, by Simpson's rule over its density."""
    from scipy.integrate import simpson

    x = np.linspace(0.0, max(mean, 0.0) + 40 * deviation, 40_001)
    density = np.exp(-0.5 * ((x - mean) / deviation) ** 2) / (deviation * math.sqrt(2 * math.pi))
    return float(simpson(density, x=x))


def outcome(
    trials: Sequence[Trial], exploration: Exploration, name: str, scale: float, noise: float, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """D at points (m, d) of the unit cube: expected values, and the deviations of the next observation [T e4, e8]."""
    valid = [each for each in trials if each.valid]
    values = np.array([each.outcomes[name] for each in valid])
    points = scaled(exploration, [each.parameters for each in valid])
    process = Gaussian(points, (values - values.mean()) / values.std(), scale, noise)
    mean, deviation = process.mean_and_deviation(at)
    return values.mean() + values.std() * mean, values.std() * np.hypot(deviation, noise)
