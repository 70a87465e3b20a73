"""An exploration: takes trials in, says what to try next, and gives parameters for a wanted outcome [T 4.4]."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.exploration.arguments import (
    Tolerance,
    checked_alpha,
    checked_budget,
    checked_names,
    checked_outcomes,
    checked_reason,
    checked_retry,
    checked_seed,
    checked_target,
    checked_text,
    checked_tolerance,
    checked_units,
    checked_validity,
    out_of_range,
    too_far,
)
from kabo.exploration.asking import case_order, caution, first_parameters, next_point, nothing_valid, safest_point
from kabo.exploration.errors import ExplorationError, NoParametersError
from kabo.exploration.inverse import InverseProblem
from kabo.exploration.limits import INFERRED_ALPHA
from kabo.exploration.models import CaseModel, Fits
from kabo.exploration.records import Case, Inferred, Parameters, Question, Target, Trial, Validity
from kabo.exploration.space import Space
from kabo.exploration.text import FORMAT, line_of, trial_to_json
from kabo.exploration.values import shown
from kabo.streams import stream_key
from kabo.whole_files import write_atomically

Key = tuple[str, ...]  # the values of a case


class Exploration:
    """The trials made in a space, and what they say about its parameters, case by case."""

    def __init__(
        self,
        space: Space,
        outcomes: Iterable[str],
        *,
        seed: int = 0,
        validity: Validity = Validity(),  # noqa: B008 - frozen
        invalid_budget: float | None = None,
        start: Parameters | None = None,
        retry: Mapping[str, Mapping[str, float]] | None = None,
        units: Mapping[str, str] | None = None,
        name: str = "",
    ) -> None:
        """An exploration without trials.

        Args:
            space: the parameters, and the cases.
            outcomes: the names of what is observed in a valid trial.
            seed: of all random candidates.
            validity: how the validity of parameters is modelled.
            invalid_budget: the share of trials that may be invalid; it steers α from trial to trial. None: α is fixed.
            start: parameters to begin each case with.
            retry: reason: parameter: by how much to change it after a trial that was invalid for that reason, while
                no trial of the case is valid.
            units: outcome: its unit, for people.
            name: of the exploration, for people.

        Raises:
            ExplorationError: a name is unknown, or a number is outside its bounds.
        """
        if not isinstance(space, Space):
            raise ExplorationError(f"the space of an exploration must be a Space, this is {shown(space)}")
        self.space, self.seed, self.name = space, checked_seed(seed), checked_text(name, "the name")
        self.outcomes = checked_names(outcomes)
        self.units = checked_units({} if units is None else units, self.outcomes)
        self.validity_options = checked_validity(validity)
        self.invalid_budget = checked_budget(invalid_budget)
        self.start = None if start is None else space.checked(start)
        self.retry = checked_retry(space, {} if retry is None else retry)
        self._trials: list[Trial] = []
        self._by_case: dict[Key, list[Trial]] = {tuple(case.values()): [] for case in space.all_cases}
        self._models: dict[Key, CaseModel] = {}
        self._fits: dict[Key, Fits] = {key: {} for key in self._by_case}

    # -------------------------------------------------------------------------------------------------- trials
    @property
    def trials(self) -> tuple[Trial, ...]:
        """All trials, in the order in which they were added."""
        return tuple(self._trials)

    def trials_of(self, case: Case | None) -> tuple[Trial, ...]:
        """The trials of one case; raises ExplorationError for an unknown case."""
        return tuple(self._by_case[self._key(case)])

    def tell(
        self,
        case: Case | None,
        parameters: Parameters,
        valid: bool,
        outcomes: Mapping[str, float] | None = None,
        reason: str = "",
    ) -> Trial:
        """Adds a trial, and returns it as it is kept.

        Args:
            case: the value of each variable.
            parameters: what was tried, within the bounds.
            valid: whether it was valid.
            outcomes: the value of every outcome of the exploration; only of a valid trial.
            reason: a word for why it was not valid; only of an invalid trial.

        Raises:
            ExplorationError: a name is unknown, a number is outside its bounds or not finite, a valid trial has no
                outcome or a reason, an invalid one has outcomes. The exploration is as before.
        """
        trial = self.checked_trial(case, parameters, valid, outcomes, reason)
        key = tuple(trial.case.values())
        self._trials.append(trial)
        self._by_case[key].append(trial)
        self._models.pop(key, None)
        return trial

    def checked_trial(
        self,
        case: Case | None,
        parameters: Parameters,
        valid: bool,
        outcomes: Mapping[str, float] | None = None,
        reason: str = "",
    ) -> Trial:
        """The trial that `tell` would add; raises ExplorationError as it does."""
        if not isinstance(valid, (bool, np.bool_)):
            raise ExplorationError(f"a trial is valid or not: True or False, this is {shown(valid)}")
        checked_reason(reason)
        if valid and reason:
            raise ExplorationError(f"a valid trial has no reason, this one has {shown(reason)}")
        if not valid and outcomes is not None and not (isinstance(outcomes, Mapping) and not outcomes):
            raise ExplorationError("an invalid trial has no outcome: nothing comes of it that a model may learn")
        known = checked_outcomes({} if outcomes is None else outcomes, self.outcomes) if valid else {}
        return Trial(self.space.case(case), self.space.checked(parameters), bool(valid), known, reason)

    # ----------------------------------------------------------------------------------------------- questions
    def ask(self, case: Case | None = None, alpha: float | None = None) -> Question:
        """What to try next: the parameters of greatest entropy among those with V > alpha [T e10].

        While no trial of the case is valid: the start, and parameters around it. The answer depends on the options, the
        arguments and the trials alone.

        Args:
            case: the case to try; None: one is chosen, near the last and with few trials [T 4.3.1].
            alpha: the probability above which parameters may be tried. None: `self.alpha(case)`; where a budget of
                invalid trials has raised that beyond the V of all candidates, the one of greatest V is offered.

        Raises:
            NoParametersError: there is nothing to try: `not_explored`, or `nothing_valid`.
            ExplorationError: the case is unknown, or alpha is no probability.
        """
        if alpha is not None:
            alpha = checked_alpha(alpha)
        if case is not None or not self.space.cases:
            return self._ask(self.space.case(case), alpha)
        cases = self.space.all_cases
        counts = [len(self._by_case[tuple(each.values())]) for each in cases]
        last = self._trials[-1].case if self._trials else None
        key = stream_key(self.seed, "case", len(self._trials))
        reasons = []
        for index in case_order(self.space, cases, counts, last, key):
            try:
                return self._ask(cases[index], alpha)
            except NoParametersError as error:
                reasons.append(error)
        raise next((each for each in reasons if each.reason == "nothing_valid"), reasons[0])

    def _ask(self, case: dict[str, str], alpha: float | None) -> Question:
        key = tuple(case.values())
        trials, model = self._by_case[key], self._model(key)
        stream = stream_key(self.seed, "ask", *key, len(trials))
        if not len(model.valid_points):
            parameters = first_parameters(
                self.space, trials, self.start, self.retry, self.validity_options.scale, stream
            )
            return Question(case, parameters, float(model.validity(self.space.scaled([parameters]))[0]))
        level = self.alpha(case) if alpha is None else alpha
        point = next_point(model, self.space, stream, level)
        if point is None and alpha is None and self.invalid_budget is not None:
            point = safest_point(model, self.space, stream)
        if point is None:
            raise NoParametersError("nothing_valid", f"{_none_above(level)}, or a smaller scale of validity")
        return Question(case, self.space.parameters_at(point), float(model.validity(point[None])[0]))

    def alpha(self, case: Case | None = None) -> float:
        """α, the V above which parameters of the case may be tried now; a budget of invalid trials moves it."""
        if self.invalid_budget is None:
            return self.validity_options.alpha
        known = [each.valid for each in self._by_case[self._key(case)]]
        return caution(known, self.validity_options.alpha, self.invalid_budget)

    # ------------------------------------------------------------------------------------------------- answers
    def validity(self, case: Case | None, points: Sequence[Parameters]) -> Array:
        """V, the probability that a trial with each of the n parameters is valid, as (n,) [T e9].

        Raises:
            ExplorationError: the case or a parameter is unknown, or outside its bounds.
        """
        key = self._key(case)
        return self._model(key).validity(self.space.scaled(points))

    def predict(self, case: Case | None, points: Sequence[Parameters]) -> dict[str, tuple[Array, Array]]:
        """D: each outcome's expected values for n parameters, and the deviations of the next observation; (n,) each [T e4].

        Raises:
            NoParametersError: no trial of the case is valid yet.
            ExplorationError: the case or a parameter is unknown, or outside its bounds.
        """
        key = self._key(case)
        self._require_valid([self._model(key)])
        scaled = self.space.scaled(points)
        return {name: model.predict(scaled) for name, model in self._model(key).outcomes.items()}

    def infer(
        self,
        target: Target,
        where: Case | None = None,
        alpha: float = INFERRED_ALPHA,
        tolerance: Tolerance = None,
    ) -> Inferred:
        """The parameters with V > alpha whose expected outcomes are the nearest to the target [T e5].

        Args:
            target: outcome: its value, or `least` or `most`; of several, the sum of normalised squares counts.
            where: case variables with their values; all cases that have these values are searched.
            alpha: the probability above which parameters may be used [T 4.4.1].
            tolerance: how far from the target the expected outcomes may be: one number for all, or one for each (for
                others there is no limit); `deviation`: twice the deviation of the next observation; None: no limit.

        Raises:
            NoParametersError: `not_explored`, `nothing_valid`, or `out_of_range` with the nearest that can be had.
            ExplorationError: a name is unknown, or a number is not usable.
        """
        return self.alternatives(target, where, alpha, tolerance)[0]

    def alternatives(
        self,
        target: Target,
        where: Case | None = None,
        alpha: float = INFERRED_ALPHA,
        tolerance: Tolerance = None,
        count: int = 1,
    ) -> tuple[Inferred, ...]:
        """One to `count` sets of parameters like that of `infer`, the nearest first; within a case at least λ_v apart.

        Raises:
            NoParametersError: there is not even one.
            ExplorationError: as `infer`.
        """
        target = self.checked_target(target)
        alpha = checked_alpha(alpha)
        permitted = checked_tolerance(tolerance, self.outcomes, target)
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise ExplorationError(f"count must be a positive whole number, this is {shown(count)}")
        cases = self.space.matching(where)
        models = [self._model(tuple(case.values())) for case in cases]
        self._require_valid(models)
        found = InverseProblem(self.space, cases, models, target, alpha, self.seed).best(count)
        if not found:
            raise NoParametersError("nothing_valid", _none_above(alpha))
        near = tuple(each for each in found if not too_far(each, target, permitted))
        if not near:
            raise NoParametersError("out_of_range", out_of_range(found[0], target), found[0])
        return near

    def checked_target(self, target: Target) -> Target:
        """The target with plain numbers; raises ExplorationError for unknown outcomes and unusable values."""
        return checked_target(target, self.outcomes)

    def leave_one_out(self, case: Case | None) -> dict[str, float | None]:
        """Each outcome's mean absolute leave-one-out error over the valid trials; None if there are fewer than three."""
        model = self._model(self._key(case))
        if len(model.valid_points) < 3:  # noqa: PLR2004
            return dict.fromkeys(self.outcomes)
        return {name: each.error_left_out for name, each in model.outcomes.items()}

    @property
    def header(self) -> dict[str, Any]:
        """The first line of the journal: everything but the trials."""
        space, options = self.space, self.validity_options
        parameters = {
            name: {"from": low, "to": high} | _unit(space.units, name)
            for name, (low, high) in space.parameters.items()
        }
        return {
            "format": FORMAT,
            "name": self.name,
            "space": {"parameters": parameters, "cases": {name: list(each) for name, each in space.cases.items()}},
            "outcomes": {name: _unit(self.units, name) for name in self.outcomes},
            "validity": {"scale": options.scale, "noise": options.noise, "alpha": options.alpha},
            "invalid_budget": self.invalid_budget,
            "start": self.start,
            "retry": self.retry,
            "seed": self.seed,
        }

    @property
    def text(self) -> str:
        """The journal: the header and each trial, a line of JSON each."""
        return line_of(self.header) + "".join(line_of(trial_to_json(each)) for each in self._trials)

    @property
    def digest(self) -> str:
        """The SHA-256 sum of the journal, in hexadecimal; it tells models apart."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the journal, whole or not at all; raises OSError."""
        write_atomically(Path(path), self.text.encode())

    # ----------------------------------------------------------------------------------------------------------
    def _key(self, case: Case | None) -> Key:
        return tuple(self.space.case(case).values())

    def _model(self, key: Key) -> CaseModel:
        if key not in self._models:
            self._models[key] = CaseModel(
                self.space, self._by_case[key], self.outcomes, self.validity_options, self._fits[key]
            )
        return self._models[key]

    def _require_valid(self, models: Sequence[CaseModel]) -> None:
        if any(len(model.valid_points) for model in models):
            return
        trials = [trial for model in models for trial in model.trials]
        if not trials:
            raise NoParametersError("not_explored", "no trial has been made")
        raise NoParametersError("nothing_valid", nothing_valid(trials))


def _unit(units: Mapping[str, str], name: str) -> dict[str, str]:
    return {"unit": units[name]} if name in units else {}


def _none_above(alpha: float) -> str:
    return f"no parameters are valid with a probability above {alpha}: try a smaller alpha"
