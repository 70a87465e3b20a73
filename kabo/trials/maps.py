"""Values to be drawn: validity V and outcomes D along one parameter, or over pairs of parameters.

With more than two parameters each map is a slice: the others are those of the valid trial with the greatest V.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from math import exp

import numpy as np

from kabo.arrays import Array
from kabo.exploration import Exploration, ExplorationError, Trial

CURVE_POINTS = 161
MAP_POINTS, SLICE_POINTS = 41, 27  # along a side of the only map, and of each of several
LEAST_NEARNESS = 0.15  # trials with a smaller `nearness` to a section are not drawn in it


@dataclass(frozen=True)
class Section:
    """V and D where one or two parameters vary and all others have the values of `through`."""

    names: tuple[str, ...]  # the one or two parameters that vary
    values: tuple[Array, ...]  # of each of them: (n,) [its unit]
    validity: Array  # (n,), or (rows, columns): rows are values of the second parameter
    outcomes: Mapping[str, tuple[Array, Array]]  # mean and deviation [unit of the outcome], of the same shape
    through: Mapping[str, float]  # the other parameters


def sections(exploration: Exploration, case: Mapping[str, str]) -> Iterator[Section]:
    """The sections of a case: one curve for one parameter, else a map for each pair of parameters."""
    names = exploration.space.names
    if len(names) == 1:
        yield _section(exploration, case, names, {}, CURVE_POINTS)
        return
    best = most_valid(exploration, case)
    points = MAP_POINTS if len(names) == 2 else SLICE_POINTS  # noqa: PLR2004 - two parameters
    for pair in combinations(names, 2):
        yield _section(exploration, case, pair, {name: best[name] for name in names if name not in pair}, points)


def most_valid(exploration: Exploration, case: Mapping[str, str]) -> dict[str, float]:
    """The parameters of the valid trial with the greatest V, of equals the first; the middle if no trial is valid."""
    tried = [dict(trial.parameters) for trial in exploration.trials_of(case) if trial.valid]
    if not tried:
        return {
            name: lower + 0.5 * (upper - lower) for name, (lower, upper) in exploration.space.parameters.items()
        }
    return tried[int(np.argmax(exploration.validity(case, tried)))]


def nearness(exploration: Exploration, trial: Trial, section: Section) -> float:
    """How near a trial is to a section: exp(−d²/2λ²), where d is its distance in the parameters that are held."""
    if not section.through:
        return 1.0
    space = exploration.space
    there, nearest = space.scaled([trial.parameters, {**trial.parameters, **section.through}])
    away = float(np.sum((there - nearest) ** 2))
    return exp(-away / (2.0 * exploration.validity_options.scale**2))


def _section(
    exploration: Exploration,
    case: Mapping[str, str],
    names: tuple[str, ...],
    through: Mapping[str, float],
    count: int,
) -> Section:
    values = tuple(_along(*exploration.space.parameters[name], count) for name in names)
    grid = np.meshgrid(*values)  # rows are values of the second one
    points = [
        {**through, **dict(zip(names, map(float, at), strict=True))}
        for at in zip(*(each.ravel() for each in grid), strict=True)
    ]
    shape = grid[0].shape
    try:
        found = exploration.predict(case, points)
    except ExplorationError:  # no trial is valid, so there is no D
        found = {}
    outcomes = {name: (mean.reshape(shape), spread.reshape(shape)) for name, (mean, spread) in found.items()}
    return Section(names, values, exploration.validity(case, points).reshape(shape), outcomes, through)


def _along(lower: float, upper: float, count: int) -> Array:
    """Evenly spaced values from one bound to the other, none beyond them."""
    return np.clip(np.linspace(lower, upper, count), lower, upper)
