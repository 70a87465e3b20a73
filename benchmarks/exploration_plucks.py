"""Explorations of the simulated strings of examples/plucked_string, and what is true of them."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

import numpy as np

from kabo.exploration import Exploration, NoParametersError, Space, halton, trial_seed
from kabo.trials import Valid, exploration_of, load_exploration_file

sys.path.append(str(Path(__file__).resolve().parents[1] / "examples" / "plucked_string"))

import plucked_string
from plucked_string import pluck_string

STRINGS, DIRECTIONS = ("a3", "d4", "fs4", "b4", "fs5"), ("in", "out")
Case = Mapping[str, str]


@cache
def described() -> Exploration:
    """The exploration of the example's file, without trials."""
    return exploration_of(load_exploration_file(Path(plucked_string.__file__).with_name("exploration.yaml")))


def deflection(share: float) -> float:
    """The deflection at a share of its bounds [m]."""
    low, high = described().space.parameters["deflection"]
    return float(low + share * (high - low))


def cases(strings: Sequence[str]) -> list[dict[str, str]]:
    """Every string in both directions."""
    return [{"string": string, "direction": direction} for string in strings for direction in DIRECTIONS]


def exploration(string: str, seed: int, budget: float | None = None) -> Exploration:
    """The example's exploration, but of one string, which the file need not name, in both directions; without trials."""
    whole = described()
    return Exploration(
        Space(whole.space.parameters, {"string": [string], "direction": DIRECTIONS}),
        whole.outcomes,
        seed=seed,
        validity=whole.validity_options,
        invalid_budget=budget,
        start=whole.start,
        retry=whole.retry,
    )


def explore(found: Exploration, case: Case, trials: int) -> None:
    """Explores one case until it has so many trials, or nothing is left to try."""
    for number in range(len(found.trials_of(case)), trials):
        try:
            parameters = found.ask(case).parameters
        except NoParametersError:
            return
        result = pluck_string(case, parameters, trial_seed(found.seed, case, number))
        if isinstance(result, Valid):
            found.tell(case, parameters, True, result.outcomes)
        else:
            found.tell(case, parameters, False, reason=result.reason)


@dataclass(frozen=True)
class Truth:
    """Plucks of a case, as many as it takes to say what is true."""

    points: list[dict[str, float]]
    share: np.ndarray  # (N,) of the plucks at each point that were valid
    loudness: np.ndarray  # (N,) of one valid pluck at each point [dB]; nan where none was

    @property
    def valid(self) -> np.ndarray:
        """Where most plucks are valid, (N,)."""
        return np.asarray(self.share > 0.5)


@lru_cache(maxsize=32)
def truth(string: str, direction: str, side: int, repeats: int) -> Truth:
    """What is true on a grid of `side` x `side`, by so many plucks at each point."""
    places = (np.arange(side) + 0.5) / side
    points = [{"eta": float(x), "deflection": deflection(y)} for x in places for y in places]
    case = {"string": string, "direction": direction}
    share, loudness = np.zeros(len(points)), np.full(len(points), np.nan)
    for index, point in enumerate(points):
        results = [
            pluck_string(case, point, trial_seed(-1, case, index * repeats + repeat)) for repeat in range(repeats)
        ]
        valid = [result.outcomes["loudness"] for result in results if isinstance(result, Valid)]
        share[index] = len(valid) / repeats
        loudness[index] = valid[0] if valid else np.nan
    return Truth(points, share, loudness)


def evenly_spread(count: int) -> list[dict[str, float]]:
    """Points by which volumes are measured."""
    drawn = np.array([halton(index, 2) for index in range(count)])
    return [{"eta": float(x), "deflection": deflection(y)} for x, y in drawn]


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """The intersection over the union of two sets of points, (N,) each; 0 where both are empty."""
    return float((one & other).sum() / max(1, (one | other).sum()))
