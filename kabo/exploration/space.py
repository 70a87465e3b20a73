"""The space of an exploration: parameters with bounds, and the cases, each of which is learned on its own."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.errors import did_you_mean
from kabo.exploration.errors import ExplorationError
from kabo.exploration.limits import MOST_CASES, MOST_PARAMETERS
from kabo.exploration.records import Case, Parameters
from kabo.exploration.values import A_NUMBER, finite, is_text, shown

LONGEST = 80  # characters of an unknown name that a message repeats
DIGITS = 6  # of proposed parameters, as a share of their range: journals stay readable, and no robot is more exact


@dataclass(frozen=True)
class Space:
    """Parameters with lower and upper bounds, and variables with finitely many values, whose combinations are the cases.

    Attributes:
        parameters: name: (lower, upper), one to six of them, in order.
        cases: variable: its values; without variables there is one case, `{}`.
        units: parameter: its unit, for people.

    Raises:
        ExplorationError: bounds or names are unusable; the message lists all findings.
    """

    parameters: Mapping[str, tuple[float, float]]
    cases: Mapping[str, Sequence[str]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Checks bounds and names, and keeps them as plain numbers and texts."""
        faults = [*_faults_of_parameters(self.parameters), *_faults_of_cases(self.cases)]
        faults = faults or faults_of_units(self.units, "parameter", self.parameters)
        if faults:
            raise ExplorationError("; ".join(faults))
        bounds = {name: (float(low), float(high)) for name, (low, high) in self.parameters.items()}
        object.__setattr__(self, "parameters", bounds)
        object.__setattr__(self, "cases", {name: tuple(values) for name, values in self.cases.items()})
        object.__setattr__(self, "units", dict(self.units))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters, in order."""
        return tuple(self.parameters)

    @property
    def all_cases(self) -> tuple[dict[str, str], ...]:
        """Every case; the last variable changes first. Without variables the only one is `{}`."""
        return tuple(dict(zip(self.cases, values, strict=True)) for values in product(*self.cases.values()))

    def case(self, given: Case | None) -> dict[str, str]:
        """The case with its variables in order.

        Raises:
            ExplorationError: variables or values are unknown, or a variable is missing.
        """
        where = self.part_of_case(given)
        missing = [name for name in self.cases if name not in where]
        if missing:
            told = ", ".join(f"{name} ({' or '.join(self.cases[name])})" for name in missing)
            raise ExplorationError(f"the case must say {told}")
        return where

    def part_of_case(self, given: Case | None) -> dict[str, str]:
        """Some variables of a case with their values, in order.

        Raises:
            ExplorationError: variables or values are unknown.
        """
        given = _mapping(given, "a case")
        faults = []
        for name, value in given.items():
            if name not in self.cases:
                faults.append(unknown("case variable", name, self.cases))
            elif value not in self.cases[name]:
                faults.append(unknown(f"value of {name}", value, self.cases[name]))
        if faults:
            raise ExplorationError("; ".join(faults))
        return {name: given[name] for name in self.cases if name in given}

    def matching(self, where: Case | None) -> tuple[dict[str, str], ...]:
        """The cases in which the variables of `where` have these values.

        Raises:
            ExplorationError: variables or values are unknown.
        """
        wanted = self.part_of_case(where).items()
        return tuple(case for case in self.all_cases if wanted <= case.items())

    def checked(self, parameters: Parameters) -> dict[str, float]:
        """The parameters in order, as plain numbers.

        Raises:
            ExplorationError: parameters are unknown, missing, not finite or outside their bounds; lists all of them.
        """
        parameters = _mapping(parameters, "parameters")
        faults = [
            unknown("parameter", name, self.parameters) for name in parameters if name not in self.parameters
        ]
        faults += [f"the parameter {name} is missing" for name in self.parameters if name not in parameters]
        numbers = {}
        for name, (low, high) in self.parameters.items():
            if name in parameters:
                number = finite(parameters[name])
                if number is None:
                    faults.append(f"{name} must be {A_NUMBER}, this is {shown(parameters[name])}")
                elif not low <= number <= high:
                    faults.append(f"{name} is {number:g}, outside its bounds {low:g} to {high:g}")
                else:
                    numbers[name] = number
        if faults:
            raise ExplorationError("; ".join(faults))
        return numbers

    def scaled(self, points: Iterable[Parameters]) -> Array:
        """Parameters as points of the unit cube, (n, d).

        Raises:
            ExplorationError: as `checked`.
        """
        if isinstance(points, (Mapping, str)) or not isinstance(points, Iterable):
            raise ExplorationError(f"points must be a list of parameters, this is {shown(points)}")
        rows = [list(self.checked(each).values()) for each in points]
        low, high = self._bounds()
        return (np.array(rows, float).reshape(len(rows), len(self.parameters)) - low) / (high - low)

    def rounded(self, cube: Array) -> tuple[Array, Array]:
        """Points of the unit cube (n, d) rounded to DIGITS digits of the bounds: (parameters, points), (n, d) each.

        Points outside the cube are moved to its surface.
        """
        low, high = self._bounds()
        span = high - low
        wanted = low + np.clip(cube, 0.0, 1.0) * span
        digits = [DIGITS - 1 - math.floor(math.log10(each)) for each in span]
        columns = [_rounded(wanted[:, k], digits[k]) for k in range(len(span))]
        parameters = np.clip(np.stack(columns, axis=1), low, high)  # low + span may be above high, by rounding
        return parameters, (parameters - low) / span

    def named(self, values: Array) -> dict[str, float]:
        """A row of parameters (d,) by name."""
        return {name: float(value) for name, value in zip(self.parameters, values, strict=True)}

    def parameters_at(self, point: Array) -> dict[str, float]:
        """The rounded parameters, by name, at a point (d,) of the unit cube."""
        return self.named(self.rounded(point[None])[0][0])

    def _bounds(self) -> tuple[Array, Array]:
        bounds = np.array(list(self.parameters.values()), float)
        return bounds[:, 0], bounds[:, 1]


def unknown(kind: str, name: object, known: Iterable[str]) -> str:
    """The sentence about an unknown name, with the nearest known one, else all of them."""
    names = list(known)
    text = name if isinstance(name, str) and len(name) <= LONGEST and name.isprintable() else shown(name)
    hint = did_you_mean(text, names) or f"there is {', '.join(names) or 'none'}"
    return f'unknown {kind} "{text}": {hint}'


def faults_of_units(units: Any, kind: str, names: Iterable[str]) -> list[str]:
    """What is wrong with the units of parameters or outcomes, a sentence each."""
    if not isinstance(units, Mapping):
        return [f"units must map names to texts, this is {shown(units)}"]
    faults = [unknown(kind, name, names) for name in units if name not in names]
    return faults + [
        f"the unit of {name} must be a text, this is {shown(unit)}"
        for name, unit in units.items()
        if not is_text(unit)
    ]


def _is_name(value: Any) -> bool:
    return is_text(value) and value != ""


def _rounded(values: Array, digits: int) -> Array:
    """Rounded values without negative zeros; numpy takes up to 300 digits only, and ranges may be tiny."""
    return values if digits > 300 else np.round(values, digits) + 0.0


def _mapping(given: Any, what: str) -> Mapping[str, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise ExplorationError(f"{what} must map names to values, this is {shown(given)}")
    return given


def _faults_of_parameters(parameters: Any) -> list[str]:
    if not isinstance(parameters, Mapping) or not 1 <= len(parameters) <= MOST_PARAMETERS:
        return [f"a space has 1 to {MOST_PARAMETERS} parameters, each with its bounds"]
    return [fault for name, bounds in parameters.items() for fault in _faults_of_bounds(name, bounds)]


def _faults_of_bounds(name: Any, bounds: Any) -> list[str]:
    if not _is_name(name):
        return [f"a parameter must have a name, this is {shown(name)}"]
    if not isinstance(bounds, Sequence) or isinstance(bounds, str) or len(bounds) != 2:  # noqa: PLR2004
        return [f"the bounds of {name} must be two numbers, this is {shown(bounds)}"]
    low, high = map(finite, bounds)
    if low is None or high is None:
        return [f"each bound of {name} must be {A_NUMBER}, these are {shown(bounds[0])} and {shown(bounds[1])}"]
    if low == high:
        return [f"the bounds of {name} are equal: {low:g}; a parameter that does not vary is none"]
    if low > high:
        return [f"the bounds of {name} are the wrong way round: from {low:g} to {high:g}"]
    return []


def _faults_of_cases(cases: Any) -> list[str]:
    if not isinstance(cases, Mapping):
        return [f"cases must map variables to their values, this is {shown(cases)}"]
    faults = []
    for name, values in cases.items():
        if not _is_name(name):
            faults.append(f"a variable of the cases must have a name, this is {shown(name)}")
        elif isinstance(values, str) or not isinstance(values, Sequence) or not values:
            faults.append(f"the values of {name} must be a list of names, this is {shown(values)}")
        elif not all(map(_is_name, values)):
            faults.append(f"the values of {name} must be names, these are {shown(list(values))}")
        elif len(set(values)) < len(values):
            faults.append(f"the values of {name} must differ, these are {shown(list(values))}")
    if not faults and (count := math.prod(map(len, cases.values()))) > MOST_CASES:
        faults.append(f"there are {count} cases, and at most {MOST_CASES} are possible")
    return faults
