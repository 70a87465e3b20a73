"""From a wanted outcome to parameters: the inverse of the models, within what is believed valid [T e5]."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.exploration.candidates import around, spread_candidates
from kabo.exploration.models import CaseModel, normalised
from kabo.exploration.records import Case, Inferred, Target
from kabo.exploration.space import Space
from kabo.streams import Key, stream_key

CANDIDATES = 4_000
BEST = 20  # candidates around which closer ones are drawn
CLOSER = (0.25, 0.06, 0.015)  # how far around them, as shares of λ_v, one round after the other
# Share of the deviation: outcomes that differ by less count as equal, and the parameters of greatest V win.
NO_DIFFERENCE = 0.05


@dataclass(frozen=True)
class InverseProblem:
    """A wanted outcome, and the cases that may have it, each with its model."""

    space: Space
    cases: Sequence[Case]
    models: Sequence[CaseModel]
    target: Target
    alpha: float
    seed: int

    def best(self, count: int) -> list[Inferred]:
        """Up to `count` parameters with V > alpha, the nearest to the target first, in each case at least λ_v apart."""
        searches = [_Search(self, index) for index, model in enumerate(self.models) if len(model.valid_points)]
        found: list[Inferred] = []
        while len(found) < count:
            offers = [offer for each in searches if (offer := each.offer()) is not None]
            if not offers:
                break
            chosen = min(offers, key=lambda offer: offer.loss)
            found.append(chosen.inferred)
            chosen.search.taken.append(chosen.point)
            chosen.search.pool = None
        return found

    @cached_property
    def spreads(self) -> Mapping[str, float]:
        """The standard deviation of each wanted outcome over the valid trials of all cases."""
        trials = [trial for model in self.models for trial in model.trials if trial.valid]
        return {name: normalised([trial.outcomes[name] for trial in trials])[2] for name in self.target}

    def loss(self, model: CaseModel, points: Array) -> Array:
        """How far the expected outcomes at points (n, d) are from the target, as (n,): sums of normalised squares."""
        total = np.zeros(len(points))
        for name, wanted in self.target.items():
            outcome = model.outcomes[name]
            expected = (outcome.centre + outcome.spread * outcome.process.mean(points)) / self.spreads[name]
            if isinstance(wanted, str):
                total += expected if wanted == "least" else -expected
            else:
                total += (expected - wanted / self.spreads[name]) ** 2
        return total


@dataclass(frozen=True)
class _Offer:
    loss: float
    point: Array
    inferred: Inferred
    search: "_Search"


class _Search:
    """The search in one case; points near those that are taken are left out."""

    def __init__(self, problem: InverseProblem, index: int) -> None:
        self.problem, self.case, self.model = problem, problem.cases[index], problem.models[index]
        self.taken: list[Array] = []  # points of alternatives that were chosen before
        self.pool: tuple[Array, Array] | None = None  # points and losses; None: to be searched again
        # The same for candidates from everywhere, before those near `taken` are left out.
        self._first: tuple[Array, Array] | None = None

    def offer(self) -> _Offer | None:
        """The best parameters left; None if there are none."""
        points, losses = self._closest() if self.pool is None else self.pool
        self.pool = points, losses
        if not len(points):
            return None
        chosen = self._safest(points, losses)
        return _Offer(float(losses[chosen]), points[chosen], self._inferred(points[chosen]), self)

    def _closest(self) -> tuple[Array, Array]:
        """Admissible points and their losses: candidates from everywhere, then ever closer ones around the best."""
        if self._first is None:
            drawn = spread_candidates(
                self._stream(0), CANDIDATES, self.model.valid_points, self.model.options.scale
            )
            self._first = self._judged(np.vstack([self.model.valid_points, drawn]))
        points, losses = self._free(*self._first)
        for number, share in enumerate(CLOSER, 1):
            if not len(points):
                break
            best = points[np.argsort(losses, kind="stable")[:BEST]]
            key = self._stream(number + len(CLOSER) * len(self.taken))
            more = self._free(
                *self._judged(around(key, 0, CANDIDATES // 8, best, share * self.model.options.scale))
            )
            points, losses = np.vstack([points, more[0]]), np.concatenate([losses, more[1]])
        return points, losses

    def _safest(self, points: Array, losses: Array) -> int:
        """The index of the point of greatest validity among those whose outcomes are as good as the best."""
        order = np.argsort(losses, kind="stable")[:200]
        near = points[order]
        equal = np.ones(len(order), bool)
        for name in self.problem.target:
            mean, deviation = self.model.outcomes[name].predict(near)
            equal &= np.abs(mean - mean[0]) <= NO_DIFFERENCE * deviation[0]
        kept = np.flatnonzero(equal)
        return int(order[kept[int(np.argmax(self.model.validity(near[kept])))]])

    def _judged(self, drawn: Array) -> tuple[Array, Array]:
        points = self.problem.space.rounded(drawn)[1]
        points = points[self.model.admissible(points, self.problem.alpha)]
        return points, self.problem.loss(self.model, points) if len(points) else np.empty(0)

    def _free(self, points: Array, losses: Array) -> tuple[Array, Array]:
        """Points that are at least λ_v away from those taken."""
        for taken in self.taken:
            far = np.linalg.norm(points - taken, axis=1) >= self.model.options.scale
            points, losses = points[far], losses[far]
        return points, losses

    def _stream(self, number: int) -> Key:
        return stream_key(self.problem.seed, "infer", *self.case.values(), len(self.model.trials), number)

    def _inferred(self, point: Array) -> Inferred:
        row = point[None]
        predicted = {name: model.predict(row) for name, model in self.model.outcomes.items()}
        return Inferred(
            dict(self.case),
            self.problem.space.parameters_at(point),
            float(self.model.validity(row)[0]),
            {name: float(mean[0]) for name, (mean, _) in predicted.items()},
            {name: float(deviation[0]) for name, (_, deviation) in predicted.items()},
        )
