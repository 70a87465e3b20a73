"""Checks of what an exploration is given: names, probabilities, outcomes, targets."""

from collections.abc import Iterable, Mapping
from typing import Any

from kabo.exploration.errors import ExplorationError
from kabo.exploration.records import Inferred, Target, Validity
from kabo.exploration.space import Space, finite, unknown

Tolerance = float | Mapping[str, float] | str | None  # a number for all outcomes, one for each, or `deviation`
EXTREMES = ("least", "most")


def checked_names(outcomes: Iterable[str]) -> tuple[str, ...]:
    """The names of outcomes; raises ExplorationError if there are none, or not only different texts."""
    names = (outcomes,) if isinstance(outcomes, str) else tuple(outcomes)
    if not names or any(not isinstance(each, str) or not each for each in names):
        raise ExplorationError(
            f"an exploration has one outcome or more, each with a name, these are {list(names)!r}"
        )
    if len(set(names)) < len(names):
        raise ExplorationError(f"outcomes must differ, these are {', '.join(names)}")
    return names


def checked_units(units: Mapping[str, str], outcomes: Iterable[str]) -> dict[str, str]:
    """The units of outcomes; raises ExplorationError for an unknown outcome."""
    for name in units:
        if name not in outcomes:
            raise ExplorationError(unknown("outcome", name, outcomes))
    return dict(units)


def checked_validity(options: Validity) -> Validity:
    """The options with plain numbers; raises ExplorationError for numbers that are no scale, noise or probability."""
    scale, noise, alpha = map(finite, (options.scale, options.noise, options.alpha))
    if scale is None or not 0.01 <= scale <= 10:
        raise ExplorationError(f"the scale of validity must be between 0.01 and 10, this is {options.scale!r}")
    if noise is None or not 0.01 <= noise <= 10:
        raise ExplorationError(f"the noise of validity must be between 0.01 and 10, this is {options.noise!r}")
    return Validity(scale, noise, checked_alpha(options.alpha if alpha is None else alpha))


def checked_alpha(alpha: Any) -> float:
    """The probability; raises ExplorationError if it is not above 0 and below 1."""
    number = finite(alpha)
    if number is None or not 0 < number < 1:
        raise ExplorationError(f"alpha must be a probability above 0 and below 1, this is {alpha!r}")
    return number


def checked_budget(budget: Any) -> float | None:
    """The share of trials that may be invalid; raises ExplorationError if it is not above 0 and below 1."""
    if budget is None:
        return None
    number = finite(budget)
    if number is None or not 0 < number < 1:
        raise ExplorationError(f"the budget of invalid trials must be above 0 and below 1, this is {budget!r}")
    return number


def checked_change(space: Space, reason: str, change: Mapping[str, float]) -> dict[str, float]:
    """By how much parameters change after a reason; raises ExplorationError for unknown ones, or no finite numbers."""
    known = {}
    for name, value in change.items():
        number = finite(value)
        if name not in space.parameters:
            raise ExplorationError(f"retry after {reason}: {unknown('parameter', name, space.parameters)}")
        if number is None:
            raise ExplorationError(
                f"retry after {reason}: {name} must change by a finite number, this is {value!r}"
            )
        known[name] = number
    return known


def checked_outcomes(given: Any, outcomes: Iterable[str]) -> dict[str, float]:
    """Every outcome of a valid trial; raises ExplorationError if one is unknown, missing or not finite."""
    if not isinstance(given, Mapping):
        raise ExplorationError(f"outcomes must map names to numbers, this is {given!r}")
    numbers = {name: finite(given[name]) for name in outcomes if name in given}
    faults = [unknown("outcome", name, outcomes) for name in given if name not in numbers]
    faults += [f"a valid trial has an outcome, {name} is missing" for name in outcomes if name not in given]
    faults += [
        f"{name} must be a finite number, this is {given[name]!r}" for name in numbers if numbers[name] is None
    ]
    if faults:
        raise ExplorationError("; ".join(faults))
    return {name: number for name, number in numbers.items() if number is not None}


def checked_target(target: Any, outcomes: Iterable[str]) -> Target:
    """What is wanted; raises ExplorationError for unknown outcomes, and for values that are no number, least or most."""
    if not isinstance(target, Mapping) or not target:
        raise ExplorationError(f"a target maps one outcome or more to the wanted values, this is {target!r}")
    wanted: dict[str, Any] = {}
    for name, value in target.items():
        if name not in outcomes:
            raise ExplorationError(unknown("outcome", name, outcomes))
        wanted[name] = value if isinstance(value, str) and value in EXTREMES else finite(value)
        if wanted[name] is None:
            raise ExplorationError(f"{name} must be a finite number, least or most, this is {value!r}")
    return wanted


def checked_tolerance(tolerance: Tolerance, outcomes: Iterable[str]) -> Tolerance:
    """The tolerance; raises ExplorationError for unknown outcomes and negative or infinite numbers."""
    if tolerance is None or (isinstance(tolerance, str) and tolerance == "deviation"):
        return tolerance
    given = tolerance if isinstance(tolerance, Mapping) else {"tolerance": tolerance}
    numbers = {}
    for name, value in given.items():
        number = finite(value)
        if isinstance(tolerance, Mapping) and name not in outcomes:
            raise ExplorationError(unknown("outcome", name, outcomes))
        if number is None or number < 0:
            raise ExplorationError(f"the tolerance must be a number from 0 on, this is {value!r}")
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
