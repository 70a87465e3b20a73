"""Where the object of examples/pick_and_place can be put down: told from 70 trials, and judged by planning anew."""

import argparse
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
from exploration_must import must
from table import Table

from kabo.exploration import Exploration, Journal
from kabo.streams import stream_key, uniforms
from kabo.trials import TrialFunction, Valid, exploration_of, load_exploration_file, run_exploration, trial_of

FILE = Path(__file__).resolve().parents[1] / "examples" / "pick_and_place" / "reach.yaml"
TRIALS, PLACES, CALLS = 70, 20, 5


@dataclass(frozen=True)
class Told:
    """A place that was drawn anew: what is believed, what planning says, and how long both took [s of processor]."""

    validity: float
    valid: bool
    duration_error: float | None  # None: there is no duration [s]
    asked: float
    planned: float

    @property
    def right(self) -> bool:
        """Whether validity above one half is what planning says."""
        return (self.validity > 0.5) == self.valid


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each exploration, and the figures that must be reached."""
    trials, places = (6, 2) if options.small else (options.trials or TRIALS, PLACES)
    trial = trial_of(load_exploration_file(FILE))
    table = Table(f"Places told after {trials} trials")
    every: list[list[Told]] = []
    for seed in range(1 if options.small else options.seeds):
        exploration = explored(trial, trials, seed)
        here = told(exploration, trial, places, seed)
        every.append(here)
        errors = [each.duration_error for each in here if each.duration_error is not None]
        table.add(
            f"seed {seed}",
            right=sum(each.right for each in here),
            of=len(here),
            valid=sum(each.valid for each in here),
            invalid_trials=float(np.mean([not each.valid for each in exploration.trials])),
            duration_error_s=float(np.mean(errors)) if errors else None,
            told_ms=1e3 * float(np.mean([each.asked for each in here])),
            planned_s=float(np.mean([each.planned for each in here])),
        )
    judged = Table("Reach: must reach")
    enough = None if options.small else 18
    must(judged, f"fewest right of {places}", min(sum(e.right for e in here) for here in every), at_least=enough)
    must(judged, f"mean right of {places}", float(np.mean([sum(e.right for e in here) for here in every])))
    asked = [each.asked for here in every for each in here]
    must(
        judged,
        "longest to tell a place [ms of processor]",
        1e3 * max(asked),
        at_most=None if options.small else 1.0,
    )
    must(
        judged,
        "mean to plan it [s of processor]",
        float(np.mean([each.planned for here in every for each in here])),
    )
    return [table, judged]


def explored(trial: TrialFunction, trials: int, seed: int) -> Exploration:
    """An exploration of the example with so many trials."""
    with TemporaryDirectory() as folder:
        journal = Journal.create(
            Path(folder) / "reach.jsonl", exploration_of(load_exploration_file(FILE), seed=seed)
        )
        run_exploration(journal, trial, trials)
    return journal.exploration


def told(exploration: Exploration, trial: TrialFunction, places: int, seed: int) -> list[Told]:
    """What is believed of places drawn uniformly within the bounds, and what planning says."""
    low, high = np.array(list(exploration.space.parameters.values())).T
    shares = uniforms(stream_key(seed, "places"), 0, places, len(low))
    exploration.validity({}, [exploration.space.named(low)])  # the model is made with the first question
    found = []
    for place in low + shares * (high - low):
        parameters = exploration.space.named(place)
        validity, asked = _asked(exploration, parameters)
        began = process_time()
        result = trial({}, parameters, int(stream_key(seed, "plan", len(found)) >> np.uint64(11)))
        planned = process_time() - began
        error = None
        if isinstance(result, Valid):
            expected = float(exploration.predict({}, [parameters])["duration"][0][0])
            error = abs(expected - result.outcomes["duration"])
        found.append(Told(validity, error is not None, error, asked, planned))
    return found


def _asked(exploration: Exploration, parameters: dict[str, float]) -> tuple[float, float]:
    """The validity of a place, and how long it takes to tell [s of processor]: the least of some calls."""
    least = float("inf")
    for _ in range(CALLS):
        began = process_time()
        validity = float(exploration.validity({}, [parameters])[0])
        least = min(least, process_time() - began)
    return validity, least
