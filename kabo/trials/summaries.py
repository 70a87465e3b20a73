"""Summaries of the trials of an exploration, case by case, as data."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kabo.exploration import Case, Exploration


@dataclass(frozen=True)
class OutcomeSummary:
    """The range of an outcome over the valid trials, and its mean absolute leave-one-out error (None: too few trials)."""

    lowest: float
    highest: float
    error: float | None
    unit: str


@dataclass(frozen=True)
class CaseSummary:
    """The trials of one case.

    Attributes:
        trials, valid: the number of trials, and of valid ones.
        reasons: the number of invalid trials for each reason, the most frequent first.
        alpha: V must be greater than this for the next parameters.
        outcomes: of the valid trials; empty without any.
    """

    case: Case
    trials: int
    valid: int
    reasons: Mapping[str, int]
    alpha: float
    outcomes: Mapping[str, OutcomeSummary]


def summaries_of(exploration: Exploration) -> tuple[CaseSummary, ...]:
    """The summary of each case, in the order of the space, those without trials included."""
    return tuple(_summary(exploration, case) for case in exploration.space.all_cases)


def summary_to_json(summary: CaseSummary) -> dict[str, Any]:
    """A summary as plain data."""
    return {
        "case": dict(summary.case),
        "trials": summary.trials,
        "valid": summary.valid,
        "reasons": dict(summary.reasons),
        "alpha": summary.alpha,
        "outcomes": {
            name: {"lowest": each.lowest, "highest": each.highest, "error": each.error, "unit": each.unit}
            for name, each in summary.outcomes.items()
        },
    }


def _summary(exploration: Exploration, case: Case) -> CaseSummary:
    trials = exploration.trials_of(case)
    valid = [each for each in trials if each.valid]
    counts = Counter(each.reason for each in trials if not each.valid)
    reasons = dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))
    outcomes = {}
    if valid:
        errors = exploration.leave_one_out(case)
        for name in exploration.outcomes:
            values = [each.outcomes[name] for each in valid]
            unit = exploration.units.get(name, "")
            outcomes[name] = OutcomeSummary(min(values), max(values), errors[name], unit)
    return CaseSummary(dict(case), len(trials), len(valid), reasons, exploration.alpha(case), outcomes)
