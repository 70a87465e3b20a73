"""Checks of the arguments of an exploration: names, probabilities, outcomes, targets."""

from collections.abc import Iterable, Mapping
from typing import Any

from kabo.exploration.errors import ExplorationError
from kabo.exploration.limits import OPTION_BOUNDS
from kabo.exploration.records import Inferred, Target, Validity
from kabo.exploration.space import Space, faults_of_units, unknown
from kabo.exploration.values import A_NUMBER, A_SEED, finite, is_seed, is_text, shown

Tolerance = float | Mapping[str, float] | str | None  # a number for all outcomes, one for each, or `deviation`
EXTREMES = ("least", "most")
LONGEST_REASON = 200  # characters


def checked_names(outcomes: Any) -> tuple[str, ...]:
    """The names of outcomes; raises ExplorationError if there are none, or not only different texts."""
    given = (outcomes,) if isinstance(outcomes, str) else outcomes
    names = tuple(given) if isinstance(given, Iterable) else ()
    if not names or not all(is_text(each) and each for each in names):
        raise ExplorationError(
            f"an exploration has one outcome or more, each with a name, these are {shown(outcomes)}"
        )
    if len(set(names)) < len(names):
        raise ExplorationError(f"outcomes must differ, these are {shown(list(names))}")
    return names


def checked_units(units: Any, outcomes: Iterable[str]) -> dict[str, str]:
    """The units of outcomes; raises ExplorationError for an unknown outcome, or a unit that is no text."""
    if faults := faults_of_units(units, "outcome", outcomes):
        raise ExplorationError("; ".join(faults))
    return dict(units)


def checked_text(text: Any, what: str) -> str:
    """The text; raises ExplorationError if it is no text, or cannot be encoded in UTF-8."""
    if not is_text(text):
        raise ExplorationError(f"{what} must be a text, this is {shown(text)}")
    return str(text)


def checked_reason(reason: Any) -> str:
    """The reason; raises ExplorationError if it is not one short line of printable text."""
    text = checked_text(reason, "the reason")
    if not text.isprintable() or len(text) > LONGEST_REASON:
        raise ExplorationError(
            f"a reason is one line of at most {LONGEST_REASON} characters, this is {shown(text)}"
        )
    return text


def checked_seed(seed: Any) -> int:
    """The seed; raises ExplorationError if it is no whole number of 64 bits."""
    if not is_seed(seed):
        raise ExplorationError(f"the seed must be {A_SEED}, this is {shown(seed)}")
    return int(seed)


def checked_validity(options: Validity) -> Validity:
    """The options with plain numbers; raises ExplorationError for an unusable scale, noise or alpha."""
    if not isinstance(options, Validity):
        raise ExplorationError(f"validity must be a Validity, this is {shown(options)}")
    low, high = OPTION_BOUNDS
    numbers = []
    for name, given in (("scale", options.scale), ("noise", options.noise)):
        number = finite(given)
        if number is None or not low <= number <= high:
            raise ExplorationError(
                f"the {name} of validity must be between {low:g} and {high:g}, this is {shown(given)}"
            )
        numbers.append(number)
    return Validity(numbers[0], numbers[1], checked_alpha(options.alpha))


def checked_alpha(alpha: Any) -> float:
    """The probability; raises ExplorationError if it is not above 0 and below 1."""
    number = finite(alpha)
    if number is None or not 0 < number < 1:
        raise ExplorationError(f"alpha must be a probability above 0 and below 1, this is {shown(alpha)}")
    return number


def checked_budget(budget: Any) -> float | None:
    """The share of trials that may be invalid; raises ExplorationError if it is not above 0 and below 1."""
    if budget is None:
        return None
    number = finite(budget)
    if number is None or not 0 < number < 1:
        raise ExplorationError(
            f"the budget of invalid trials must be above 0 and below 1, this is {shown(budget)}"
        )
    return number


def checked_retry(space: Space, retry: Any) -> dict[str, dict[str, float]]:
    """The changes of parameters after each reason; raises ExplorationError for unknown parameters and unusable numbers."""
    if not isinstance(retry, Mapping):
        raise ExplorationError(f"retry must map reasons to changes, this is {shown(retry)}")
    return {checked_text(reason, "a reason"): _checked_change(space, reason, retry[reason]) for reason in retry}


def checked_outcomes(given: Any, outcomes: Iterable[str]) -> dict[str, float]:
    """Every outcome of a valid trial; raises ExplorationError if one is unknown, missing or not finite."""
    if not isinstance(given, Mapping):
        raise ExplorationError(f"outcomes must map names to numbers, this is {shown(given)}")
    numbers = {name: finite(given[name]) for name in outcomes if name in given}
    faults = [unknown("outcome", name, outcomes) for name in given if name not in numbers]
    faults += [f"a valid trial has an outcome, {name} is missing" for name in outcomes if name not in given]
    faults += [
        f"{name} must be {A_NUMBER}, this is {shown(given[name])}" for name in numbers if numbers[name] is None
    ]
    if faults:
        raise ExplorationError("; ".join(faults))
    return {name: number for name, number in numbers.items() if number is not None}


def checked_target(target: Any, outcomes: Iterable[str]) -> Target:
    """The target; raises ExplorationError for unknown outcomes, and for values that are no number, `least` or `most`."""
    if not isinstance(target, Mapping) or not target:
        raise ExplorationError(f"a target maps one outcome or more to the wanted values, this is {shown(target)}")
    wanted: dict[str, Any] = {}
    for name, value in target.items():
        if name not in outcomes:
            raise ExplorationError(unknown("outcome", name, outcomes))
        wanted[name] = value if isinstance(value, str) and value in EXTREMES else finite(value)
        if wanted[name] is None:
            raise ExplorationError(f"{name} must be {A_NUMBER}, least or most, this is {shown(value)}")
    return wanted


def checked_tolerance(tolerance: Tolerance, outcomes: Iterable[str], target: Target) -> Tolerance:
    """The tolerance; raises ExplorationError for outcomes that are unknown or not wanted, and for unusable numbers."""
    if tolerance is None or (isinstance(tolerance, str) and tolerance == "deviation"):
        return tolerance
    given = tolerance if isinstance(tolerance, Mapping) else {"tolerance": tolerance}
    numbers = {}
    for name, value in given.items():
        number = finite(value)
        if isinstance(tolerance, Mapping) and name not in outcomes:
            raise ExplorationError(unknown("outcome", name, outcomes))
        if isinstance(tolerance, Mapping) and name not in target:
            raise ExplorationError(f"there is a tolerance for {name}, which the target does not name")
        if number is None or number < 0:
            raise ExplorationError(f"the tolerance must be a number from 0 on, this is {shown(value)}")
        numbers[name] = number
    return numbers if isinstance(tolerance, Mapping) else numbers["tolerance"]


def too_far(found: Inferred, target: Target, tolerance: Tolerance) -> bool:
    """Whether an expected outcome is farther from the target than the tolerance permits."""
    if tolerance is None:
        return False
    for name, wanted in target.items():
        if isinstance(wanted, str):
            continue
        permitted: float | None
        if isinstance(tolerance, Mapping):
            permitted = tolerance.get(name)
        else:
            permitted = 2 * found.deviation[name] if isinstance(tolerance, str) else float(tolerance)
        if permitted is not None and abs(found.expected[name] - wanted) > permitted:
            return True
    return False


def out_of_range(nearest: Inferred, target: Target) -> str:
    """The sentence that the target cannot be had, with the nearest that can."""
    wanted = ", ".join(f"{name} {value:g}" for name, value in target.items() if not isinstance(value, str))
    near = ", ".join(
        f"{name} {nearest.expected[name]:.4g} ± {nearest.deviation[name]:.2g}"
        for name, value in target.items()
        if not isinstance(value, str)
    )
    at = ", ".join(f"{name} {value:g}" for name, value in nearest.parameters.items())
    return f"{wanted} cannot be had: the nearest is {near}, at {at}"


def _checked_change(space: Space, reason: str, change: Any) -> dict[str, float]:
    if not isinstance(change, Mapping):
        raise ExplorationError(
            f"retry after {reason}: a change maps parameters to numbers, this is {shown(change)}"
        )
    known = {}
    for name, value in change.items():
        number = finite(value)
        if name not in space.parameters:
            raise ExplorationError(f"retry after {reason}: {unknown('parameter', name, space.parameters)}")
        if number is None:
            raise ExplorationError(
                f"retry after {reason}: {name} must change by {A_NUMBER}, this is {shown(value)}"
            )
        known[name] = number
    return known
