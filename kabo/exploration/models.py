"""The Gaussian processes of one case: V, which parameters are valid, and D, their outcomes [T e4, e8, e9]."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.exploration.gaussian_processes import GaussianProcess, log_likelihoods
from kabo.exploration.records import Trial, Validity
from kabo.exploration.space import Space

# Scale and noise of an outcome are fitted again at each of these numbers of valid trials, to that many first ones.
FIT_AT = (20, 40, 80, 160)
SCALES = (0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.57, 0.8)  # λ_d that are tried: shares of the bounds
NOISES = (0.05, 0.1, 0.2, 0.35, 0.6)  # deviations of an observation that are tried: shares of the outcome's own
SCALE, NOISE = 0.28, 0.2  # until there are enough trials to fit
ROUNDING = 1e-9  # more than the rounding error of a mean whose size is about 1
LEAST_SPREAD = 1e-30  # of an outcome: keeps the squares of values divided by it finite
Fits = dict[tuple[str, int], tuple[float, float]]  # (outcome, number of valid trials): scale and noise


@dataclass(frozen=True)
class OutcomeModel:
    """A Gaussian process of one outcome over the valid trials, whose values are normalised.

    Attributes:
        points: (m, d) of the valid trials.
        values: (m,) normalised.
        scale: λ_d, the length of the kernel.
        noise: the standard deviation of a normalised value.
        centre, spread: mean and standard deviation of the values, in the outcome's unit.
    """

    points: Array
    values: Array
    scale: float
    noise: float
    centre: float
    spread: float

    @cached_property
    def process(self) -> GaussianProcess:
        """The process over the normalised values."""
        return GaussianProcess(self.points, self.values, self.scale, self.noise)

    @cached_property
    def error_left_out(self) -> float:
        """The mean absolute error where each value is predicted from all others, in the outcome's unit."""
        return self.spread * float(np.mean(np.abs(self.process.left_out() - self.values)))

    def predict(self, points: Array) -> tuple[Array, Array]:
        """The expected outcome at points (n, d), and the standard deviation of the next observation; (n,) each [T e4]."""
        mean, deviation = self.process.mean_and_deviation(points)
        return self.centre + self.spread * mean, self.spread * np.hypot(deviation, self.noise)


class CaseModel:
    """V and D of one case after some trials: a process of the validity, one of each outcome. Cases share nothing [T 4.4].

    Attributes:
        points: (n, d) parameters of all trials in the unit cube.
        valid: (n,) whether they were valid.
    """

    def __init__(
        self, space: Space, trials: Sequence[Trial], outcomes: Sequence[str], options: Validity, fits: Fits
    ) -> None:
        """V and D after `trials` of one case; `fits` keeps scales and noises fitted to the same case before."""
        self.options, self._fits = options, fits
        self.trials = tuple(trials)
        self.points = space.scaled([each.parameters for each in trials])
        self.valid = np.array([each.valid for each in trials], bool)
        self._names = tuple(outcomes)

    @property
    def valid_points(self) -> Array:
        """The points of valid trials, (m, d)."""
        found: Array = self.points[self.valid]
        return found

    def validity(self, points: Array) -> Array:
        """V, the probability that a trial at each of the points (n, d) is valid, as (n,) [T e9].

        V = P(ν > 0), where ν is the answer of a single trial with its noise: +1 valid, −1 not. The thesis prints the
        probability of the opposite, and elsewhere P(E[ν] > 0).
        """
        from scipy.special import ndtr  # with scikit-learn

        if not len(self.points):
            return np.full(len(points), 0.5)
        mean, deviation = self._validity.mean_and_deviation(points)
        found: Array = ndtr(mean / np.hypot(deviation, self.options.noise))
        return found

    def admissible(self, points: Array, alpha: float) -> npt.NDArray[np.bool_]:
        """Which of the points (n, d) have V > alpha, as (n,) booleans: the valid set Φ^α."""
        from scipy.special import ndtri

        level = float(ndtri(alpha))
        mean = self._validity.mean(points)
        # The deviation lies between the noise and that of an unknown point: most points are decided without it.
        least, most = self.options.noise, float(np.hypot(1.0, self.options.noise))
        low, high = (least, most) if level >= 0 else (most, least)
        found: npt.NDArray[np.bool_] = mean > level * high + ROUNDING
        open_ = np.flatnonzero(~found & (mean > level * low - ROUNDING))
        found[open_] = self.validity(points[open_]) > alpha
        return found

    @cached_property
    def outcomes(self) -> Mapping[str, OutcomeModel]:
        """The model of each outcome; there are none before the first valid trial."""
        valid = [each for each in self.trials if each.valid]
        if not valid:
            return {}
        known = {name: [each.outcomes[name] for each in valid] for name in self._names}
        return {name: _outcome_model(self.valid_points, known[name], self._fits, name) for name in self._names}

    def entropy(self, points: Array) -> Array:
        """The differential entropy of all outcomes at points (n, d), up to a constant, as (n,) [T e10].

        The processes have their own scale λ_d, but at most λ_v. An outcome that varies slowly is well known everywhere
        between the trials; with its large λ_d nearly every next trial would lie at the border of the valid set.
        """
        known: dict[tuple[float, float], Array] = {}  # the deviation depends on scale and noise, not on the values
        total = np.zeros(len(points))
        for model in self.outcomes.values():
            options = min(model.scale, self.options.scale), model.noise
            if options not in known:
                process = GaussianProcess(model.points, model.values, *options)
                known[options] = np.log(np.maximum(process.mean_and_deviation(points)[1], 1e-12))
            total += known[options]
        return total

    @cached_property
    def _validity(self) -> GaussianProcess:
        return GaussianProcess(
            self.points, np.where(self.valid, 1.0, -1.0), self.options.scale, self.options.noise
        )


def normalised(values: Sequence[float]) -> tuple[Array, float, float]:
    """The values with zero mean and unit deviation, (n,), their mean, and their standard deviation (never zero)."""
    known = np.array(values, float)
    centre, spread = float(known.mean()), float(known.std())
    if len(known) == 1:  # how far the outcome varies is not known yet
        spread = abs(centre) or 1.0
    spread = max(spread, 1e-12 * float(np.abs(known).max()), LEAST_SPREAD)  # all may be equal but for rounding
    return (known - centre) / spread, centre, spread


def _outcome_model(points: Array, values: Sequence[float], fits: Fits, name: str) -> OutcomeModel:
    normal, centre, spread = normalised(values)
    return OutcomeModel(points, normal, *_fitted(points, values, fits, name), centre, spread)


def _fitted(points: Array, values: Sequence[float], fits: Fits, name: str) -> tuple[float, float]:
    """The scale and the noise of greatest marginal likelihood; they depend on the first FIT_AT values only."""
    count = max((each for each in FIT_AT if each <= len(values)), default=0)
    if not count:
        return SCALE, NOISE
    if (name, count) not in fits:
        first, known = points[:count], normalised(values[:count])[0]
        likelihoods = [log_likelihoods(first, known, scale, NOISES) for scale in SCALES]
        best = divmod(int(np.argmax(likelihoods)), len(NOISES))
        fits[name, count] = SCALES[best[0]], NOISES[best[1]]
    return fits[name, count]
