"""What is known of strings after so many plucks, and whether they play as loudly as asked for [T Fig. 4.7, 4.8]."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from exploration_must import must
from exploration_plucks import (
    STRINGS,
    Truth,
    cases,
    evenly_spread,
    exploration,
    explore,
    overlap,
    truth,
)
from exploration_senses import senses
from plucked_string import pluck_string
from table import Table

from kabo.exploration import Exploration, Trial, trial_seed
from kabo.trials import Valid

LEVEL = 0.75  # of the sets that are compared [T Fig. 4.7]
TRIALS = 150  # of each case, after which its valid set is called final
TARGETS, REPEATS, NEAR = 20, 5, 3.0  # loudnesses asked for, how often each, and how near they must come [dB]


@dataclass(frozen=True)
class Curve:
    """A case as its trials come: figures for each number of trials in `after`."""

    after: list[int]
    final: list[float]  # overlap of the valid set with the final one
    true: list[float]  # overlap with what is true
    error: list[float]  # of the loudness of valid plucks anywhere [dB]

    def first_above(self, bound: float) -> float | None:
        """After how many trials the overlap with the final set stays above a bound; None: never."""
        above = np.array(self.final) > bound
        below = np.flatnonzero(~above)
        first = below[-1] + 1 if len(below) else 0
        return float(self.after[first]) if first < len(self.after) else None

    def at(self, figures: Sequence[float], trials: int) -> float:
        """A figure after so many trials."""
        return figures[self.after.index(trials)]

    def between(self, first: int, last: int) -> float:
        """The mean overlap with the final set over some numbers of trials."""
        return float(np.mean([each for n, each in zip(self.after, self.final, strict=True) if first <= n <= last]))


def curve(
    case: Mapping[str, str],
    trials: Sequence[Trial],
    true: Truth,
    blank: Exploration,
    after: list[int],
    points: int,
) -> Curve:
    """The figures of a case whose trials come in this order."""
    spread = evenly_spread(points)
    heard = np.flatnonzero(~np.isnan(true.loudness) & true.valid)
    sets, truths, errors = [], [], []
    for number, trial in enumerate(trials, start=1):
        blank.tell(trial.case, trial.parameters, trial.valid, trial.outcomes, trial.reason)
        if number not in after:
            continue
        sets.append(blank.validity(case, spread) > LEVEL)
        truths.append(overlap(blank.validity(case, true.points) > LEVEL, true.valid))
        if any(each.valid for each in trials[:number]):
            expected = blank.predict(case, [true.points[index] for index in heard])["loudness"][0]
            errors.append(float(np.abs(expected - true.loudness[heard]).mean()))
        else:
            errors.append(float("nan"))
    final = sets[-1]
    return Curve(after[: len(sets)], [overlap(each, final) for each in sets], truths, errors)


@dataclass(frozen=True)
class Played:
    """Targets of loudness and what was played for them."""

    low: float  # the least loud valid trial [dB]
    high: float  # the loudest
    target: np.ndarray  # (N,) [dB]
    heard: np.ndarray  # (N,) [dB]; nan: the pluck was invalid

    def near(self) -> float:
        """The share of plucks above the lowest fifth of the range that are within NEAR of their target."""
        upper = self.target >= self.low + 0.2 * (self.high - self.low)
        return float((np.abs(self.heard - self.target)[upper] <= NEAR).mean())

    def spread(self) -> float:
        """The standard deviation of plucks for the same target above the lowest fifth of the range [dB]."""
        upper = self.target >= self.low + 0.2 * (self.high - self.low)
        again = self.heard[upper].reshape(-1, REPEATS)
        known = np.isfinite(again).sum(1) > 1
        return float(np.mean([each[np.isfinite(each)].std(ddof=1) for each in again[known]]))

    def invalid(self) -> float:
        """The share of invalid plucks."""
        return float(np.isnan(self.heard).mean())


def played(known: Exploration, string: str) -> Played:
    """Loudnesses all over the range that trials have shown, each asked for and played a few times [T Fig. 4.8]."""
    loudness = [trial.outcomes["loudness"] for trial in known.trials if trial.valid]
    low, high = min(loudness), max(loudness)
    targets, heard = [], []
    for number, target in enumerate(np.linspace(low, high, TARGETS)):
        asked = known.infer({"loudness": float(target)}, {"string": string}, alpha=0.95)
        for repeat in range(REPEATS):
            seed = trial_seed(known.seed, {"played": string}, number * REPEATS + repeat)
            result = pluck_string(asked.case, asked.parameters, seed)
            targets.append(float(target))
            heard.append(result.outcomes["loudness"] if isinstance(result, Valid) else float("nan"))
    return Played(low, high, np.array(targets), np.array(heard))


@dataclass(frozen=True)
class Explored:
    """A string that was explored in both directions."""

    string: str
    active: list[Curve]
    shuffled: list[Curve]
    played: Played
    invalid: float  # the share of invalid trials


def explored(string: str, seed: int, options: argparse.Namespace) -> Explored:
    """Explores a string, and judges what became known."""
    trials, side, repeats, points = (60, 8, 2, 200) if options.small else (options.trials or TRIALS, 24, 5, 2000)
    after = sorted({*range(5, trials + 1, 5), trials})
    known = exploration(string, seed)
    active, shuffled = [], []
    for case in cases([string]):
        explore(known, case, trials)
        true, made = truth(string, case["direction"], side, repeats), known.trials_of(case)
        rng = np.random.default_rng([seed, len(active)])
        mixed = [made[index] for index in rng.permutation(len(made))]
        active.append(curve(case, made, true, exploration(string, seed), after, points))
        shuffled.append(curve(case, mixed, true, exploration(string, seed), after, points))
    invalid = float(np.mean([not trial.valid for trial in known.trials]))
    return Explored(string, active, shuffled, played(known, string), invalid)


def tables(options: argparse.Namespace) -> list[Table]:
    """The senses, a row for each string, the mean curves, and the figures that must be reached."""
    strings = STRINGS[:1] if options.small else STRINGS
    heard = senses(200 if options.small else 4000)
    found = [explored(string, seed, options) for string in strings for seed in range(options.seeds)]
    return [heard, _by_string(strings, found), _curves(found), _must(strings, found, options.small)]


def _by_string(strings: Sequence[str], found: Sequence[Explored]) -> Table:
    table = Table("Strings: means over seeds and directions")
    for string in strings:
        own = [each for each in found if each.string == string]
        active = [curve for each in own for curve in each.active]
        firsts = [curve.first_above(0.5) or float("inf") for curve in active]
        table.add(
            string,
            trials_to_half=float(np.mean(firsts)),
            most_trials_to_half=max(firsts),
            true_after_100=_mean(active, "true", 100),
            error_after_50=_mean(active, "error", 50),
            invalid=float(np.mean([each.invalid for each in own])),
            range=float(np.mean([each.played.high - each.played.low for each in own])),
            near=float(np.mean([each.played.near() for each in own])),
            spread=float(np.mean([each.played.spread() for each in own])),
            invalid_played=float(np.mean([each.played.invalid() for each in own])),
        )
    return table


def _curves(found: Sequence[Explored]) -> Table:
    table = Table("As trials come: means over all strings")
    active = [curve for each in found for curve in each.active]
    shuffled = [curve for each in found for curve in each.shuffled]
    for trials in (5, 10, 15, 20, 30, 50, 70, 100, 150):
        if trials <= min(curve.after[-1] for curve in active):
            table.add(
                f"{trials} trials",
                final=_mean(active, "final", trials),
                final_shuffled=_mean(shuffled, "final", trials),
                true=_mean(active, "true", trials),
                true_shuffled=_mean(shuffled, "true", trials),
                error=_mean(active, "error", trials),
                error_shuffled=_mean(shuffled, "error", trials),
            )
    return table


def _must(strings: Sequence[str], found: Sequence[Explored], small: bool) -> Table:
    table = Table("Strings: must reach [T Fig. 4.7, 4.8]")
    active = [curve for each in found for curve in each.active]
    shuffled = [curve for each in found for curve in each.shuffled]
    halves = [curve.first_above(0.5) or float("inf") for curve in active]
    must(table, "trials until IoU with the final set stays above 0.5, worst", max(halves), at_most=70)
    lower = np.mean([curve.between(20, 70) for curve in active]) - np.mean(
        [curve.between(20, 70) for curve in shuffled]
    )
    must(table, "random order: IoU lower over trials 20 to 70 by", float(lower), at_least=0.03)
    must(table, "error of D after 50 trials [dB]", _mean(active, "error", 50), at_most=3.0)
    must(
        table,
        "error of D after 50 trials, worst [dB]",
        max(curve.at(curve.error, 50) for curve in active),
        at_most=3.0,
    )
    if not small:
        must(table, "IoU with the true set after 100 trials", _mean(active, "true", 100), at_least=0.7)
    ranges = [np.mean([each.played.high - each.played.low for each in found if each.string == s]) for s in strings]
    must(table, "range of the least string [dB]", float(min(ranges)), at_least=20.0)
    near = float(np.mean([each.played.near() for each in found]))
    must(table, "targets within 3 dB above the lowest fifth", near, at_least=0.7)
    must(table, "invalid where asked for", float(np.mean([each.played.invalid() for each in found])), at_most=0.15)
    must(table, "invalid trials at alpha 0.7", float(np.mean([each.invalid for each in found])), at_most=0.4)
    return table


def _mean(curves: Sequence[Curve], figure: str, trials: int) -> float | None:
    known = [curve.at(getattr(curve, figure), trials) for curve in curves if trials in curve.after]
    return float(np.nanmean(known)) if known else None
