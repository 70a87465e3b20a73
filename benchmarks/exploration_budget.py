"""Whether a budget of invalid trials is kept, and how much of the valid set is found with it."""

import argparse

import numpy as np
from exploration_must import must
from exploration_plucks import STRINGS, cases, exploration, explore, overlap, truth
from table import Table

TRIALS = 120
BUDGETS = (None, 0.1, 0.2, 0.3)
MORE, LEAST = (
    0.06,
    0.6,
)  # how much the share of invalid trials may exceed a budget, and the overlap there has to be
LEVEL = 0.75


def tables(options: argparse.Namespace) -> list[Table]:
    """A row for each budget, and the figures that must be reached."""
    strings = STRINGS[:1] if options.small else STRINGS
    trials, side, repeats = (30, 8, 2) if options.small else (options.trials or TRIALS, 24, 5)
    shares = Table(f"Invalid trials with a budget, after {trials}: means over strings, directions, seeds")
    judged = Table("Budgets: must reach")
    for budget in BUDGETS:
        invalid, found = [], []
        for string in strings:
            for seed in range(options.seeds):
                known = exploration(string, seed, budget=budget)
                for case in cases([string]):
                    explore(known, case, trials)
                    own, true = known.trials_of(case), truth(string, case["direction"], side, repeats)
                    invalid.append(float(np.mean([not trial.valid for trial in own])))
                    found.append(overlap(known.validity(case, true.points) > LEVEL, true.valid))
        name = "no budget, alpha 0.7" if budget is None else f"budget {budget:g}"
        shares.add(
            name,
            invalid=float(np.mean(invalid)),
            spread=float(np.std(invalid)),
            largest=max(invalid),
            true=float(np.mean(found)),
            least_true=min(found),
            explorations=len(found),
        )
        if budget is not None:
            must(judged, f"{name}: invalid", float(np.mean(invalid)), at_most=budget + MORE)
            must(judged, f"{name}: IoU with the true set", float(np.mean(found)), at_least=LEAST)
    return [shares, judged]
