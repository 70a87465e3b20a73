"""What to try next: first the start, then the most informative of the parameters believed valid [T 4.3.1, e10]."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.exploration.candidates import around, spread_candidates
from kabo.exploration.errors import NoParametersError
from kabo.exploration.models import CaseModel
from kabo.exploration.records import Case, Parameters, Trial
from kabo.exploration.space import Space
from kabo.streams import Key, stream_key, uniforms

CANDIDATES = 2_000
TRIES = 10  # invalid trials of a case without a valid one, after which the case is given up
MOST_CAUTIOUS = 4.0  # greatest z: Φ(4) = 0.99997 is as good as certain


def next_point(model: CaseModel, space: Space, key: Key, alpha: float) -> Array | None:
    """The point (d,) of greatest entropy among candidates with V > alpha [T e10]; None if there is none."""
    found = _admissible(
        model, space, spread_candidates(key, CANDIDATES, model.valid_points, model.options.scale), alpha
    )
    if not len(found):  # then a trial that was valid may be repeated
        found = _admissible(model, space, model.valid_points, alpha)
    return found[int(np.argmax(model.entropy(found)))] if len(found) else None


def safest_point(model: CaseModel, space: Space, key: Key) -> Array:
    """The point (d,) of greatest V among candidates and the valid trials."""
    drawn = spread_candidates(key, CANDIDATES, model.valid_points, model.options.scale)
    points = space.rounded(np.vstack([model.valid_points, drawn]))[1]
    best: Array = points[int(np.argmax(model.validity(points)))]
    return best


def first_parameters(
    space: Space,
    trials: Sequence[Trial],
    start: Parameters | None,
    retry: Mapping[str, Parameters],
    scale: float,
    key: Key,
) -> dict[str, float]:
    """Parameters to try while none of the `trials` of a case is valid [T 4.3.1].

    The first are `start`. After an invalid trial they change as `retry` says for its reason; if it says nothing, or the
    result has been tried already, they are drawn around the start.

    Raises:
        NoParametersError: `not_explored` without a start or trials; `nothing_valid` after too many invalid trials, or
            after any if there is no start.
    """
    if start is None and not trials:
        raise NoParametersError(
            "not_explored", "there are no trials, and no start is given: tell one that is valid"
        )
    if start is None or len(trials) >= TRIES:
        raise NoParametersError("nothing_valid", nothing_valid(trials))
    if not trials:
        return dict(start)
    last = trials[-1]
    change = retry.get(last.reason, {})
    changed = {
        name: min(max(last.parameters[name] + change.get(name, 0.0), low), high)
        for name, (low, high) in space.parameters.items()
    }
    if all(changed != dict(each.parameters) for each in trials):
        return changed
    drawn = around(key, 0, 1, space.scaled([start]), scale)
    return space.parameters_at(drawn[0])


def nothing_valid(trials: Sequence[Trial]) -> str:
    """The sentence that none of the trials was valid, with their reasons."""
    counts = Counter(each.reason or "without a reason" for each in trials).most_common()
    told = ", ".join(f"{count} × {reason}" for reason, count in counts)
    return f"none of {len(trials)} trials is valid: {told}; begin with other parameters"


def caution(validities: Sequence[bool], alpha: float, budget: float) -> float:
    """The probability α above which to try after trials of these validities, so that a share `budget` is invalid.

    The next parameters are sought at the border of the valid set, so the share of valid trials is not α. Therefore
    α = Φ(z), the cumulative normal distribution, and each trial adds ½ (i − budget) to z, where i is 1 if the trial is
    invalid, else 0. The first α is `alpha`, or 1 − budget if that is greater.
    """
    from scipy.special import ndtr, ndtri  # with scikit-learn

    level = _bounded(float(ndtri(max(alpha, 1.0 - budget))))
    for valid in validities:
        level = _bounded(level + 0.5 * ((not valid) - budget))
    return float(ndtr(level))


def case_order(
    space: Space, cases: Sequence[Case], trials: Sequence[int], last: Case | None, key: Key
) -> list[int]:
    """The indices of the cases in a random order, in which cases near the last one and with few trials tend to come first.

    Args:
        space: the space with the cases' variables.
        cases: all cases.
        trials: the number of trials of each.
        last: the case of the last trial, or None.
        key: the stream to draw from.
    """
    steps = np.array([0 if last is None else _steps(space, case, last) for case in cases])
    weights = 1.0 / ((1.0 + steps) * (1.0 + np.array(trials)) ** 2)
    # Exponential waiting times with the weights as rates: the first is drawn with probability proportional to its weight.
    waiting = -np.log1p(-uniforms(key, 0, 1, len(cases))[0]) / weights
    return [int(index) for index in np.argsort(waiting, kind="stable")]


def trial_seed(seed: int, case: Case, number: int) -> int:
    """The seed for the function of trial `number` (0, 1 …) of a case: below 2^53, so that JSON readers do not round it."""
    return int(
        stream_key(seed, "trial", *(each for item in case.items() for each in item), number) >> np.uint64(11)
    )


def _bounded(level: float) -> float:
    return min(max(level, 0.0), MOST_CAUTIOUS)


def _steps(space: Space, case: Case, other: Case) -> int:
    """How far two cases lie apart: steps along the values of their variables."""
    return sum(abs(values.index(case[name]) - values.index(other[name])) for name, values in space.cases.items())


def _admissible(model: CaseModel, space: Space, drawn: Array, alpha: float) -> Array:
    points = space.rounded(drawn)[1]
    found: Array = points[model.admissible(points, alpha)]
    return found
