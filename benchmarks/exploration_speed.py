"""What the next trial and an answer cost, in processor time of one thread."""

import argparse
from time import process_time

import numpy as np
from exploration_must import must
from table import Table

from kabo.exploration import Exploration, Space, Validity

MOST = {100: 15.0, 1_000: 200.0}  # trials: milliseconds that the next one may cost
SCALES = {2: 0.12, 6: 0.4}


def explored(dimensions: int, outcomes: int, trials: int, seed: int) -> Exploration:
    """An exploration told trials from all over the cube, of which seven in ten are valid: more than questions find."""
    space = Space({f"p{k}": (0.0, 1.0) for k in range(dimensions)})
    names = [f"outcome {k}" for k in range(outcomes)]
    found = Exploration(space, names, seed=seed, validity=Validity(scale=SCALES[dimensions]))
    rng = np.random.default_rng(seed)
    for _ in range(trials):
        at, valid = rng.random(dimensions), bool(rng.random() < 0.7)
        values = {name: float(np.sin((3 + k) * at.sum()) + 0.1 * rng.normal()) for k, name in enumerate(names)}
        found.tell({}, space.named(at), valid, values if valid else None)
    return found


def milliseconds(dimensions: int, outcomes: int, trials: int, seeds: int) -> dict[str, float]:
    """Means over explorations: the next trial, the first after loading, an answer; 2,000 and 4,000 candidates."""
    seen: dict[str, list[float]] = {"next": [], "first": [], "infer": []}
    for seed in range(seeds):
        found = explored(dimensions, outcomes, trials, seed)
        repeated = found.trials[-1]
        seen["first"].append(_spent(found))
        for _ in range(4):
            found.tell(repeated.case, repeated.parameters, False)
            seen["next"].append(_spent(found))
        began = process_time()
        found.infer({found.outcomes[0]: 0.3}, alpha=0.6)
        seen["infer"].append(process_time() - began)
    return {name: 1e3 * float(np.mean(each)) for name, each in seen.items()}


def _spent(found: Exploration) -> float:
    began = process_time()
    found.ask(alpha=0.6)
    return process_time() - began


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each number of trials, parameters and outcomes, and the figures that must be reached."""
    shown = Table("Processor time [ms]: the next trial of 2,000 candidates, the first with its fits, an answer")
    judged = Table("Speed: must reach")
    explored(2, 1, 5, 0).ask(alpha=0.1)  # imports
    for trials in (100,) if options.small else (100, 300, 1_000):
        for dimensions in SCALES:
            for outcomes in (1, 3):
                seen = milliseconds(dimensions, outcomes, trials, 1 if options.small else options.seeds)
                name = f"{trials} trials, {dimensions} parameters, outcomes: {outcomes}"
                shown.add(name, **seen)
                if trials in MOST:
                    must(judged, f"next trial: {name} [ms]", seen["next"], at_most=MOST[trials])
    return [shown, judged]
