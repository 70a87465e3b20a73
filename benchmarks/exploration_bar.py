"""A bar of unknown balance, lifted in MuJoCo: how near to its balance it is held after 60 trials, and whether it stays.

Bars are drawn, with the balance up to 4 cm from the middle; physics and errors of the robot are those of
examples/lifting_a_bar. Beside the exploration stands what as many trials tell with a budget of invalid ones, and what
they tell if they are drawn from the whole box.
"""

import argparse
import runpy
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from exploration_must import must
from table import Table

from kabo.exploration import Exploration, NoParametersError, Space, trial_seed
from kabo.streams import stream_key, uniforms
from kabo.trials import Valid

EXAMPLE = Path(__file__).resolve().parents[1] / "examples" / "lifting_a_bar" / "lifting_a_bar.py"
BARS, TRIALS, LIFTS = 5, 60, 5
BALANCE, MASS, FRICTION, BEARS = (-0.04, 0.04), (0.3, 0.8), (0.5, 0.9), (24.0, 32.0)  # of bars: [m], [kg], –, [N]
START = {"along": 0.0, "force": 12.0}
RETRY = {"dropped": {"force": 4.0}, "hanging": {"force": 3.0}, "crushed": {"force": -4.0}}
BUDGETS: dict[str, float | None] = {"explored": None, "budget": 0.2, "drawn": None}  # ways to choose trials
SPACE = Space({"along": (-0.08, 0.08), "force": (1.0, 40.0)}, units={"along": "m", "force": "N"})


@dataclass(frozen=True)
class Found:
    """What came of one exploration of one bar."""

    error: float | None  # how far from the balance it would be held; None: nothing was believed valid [mm]
    force: float | None  # how strongly [N]
    lifts: int  # how many of the lifts there were valid
    torque: float | None  # mean amount of the torque of these [Nm]
    invalid: float  # share of the trials


@cache
def example() -> dict[str, Any]:
    """The names of the example's file: physics, and errors of the robot."""
    return runpy.run_path(str(EXAMPLE))


def tables(options: argparse.Namespace) -> list[Table]:
    """How near bars are held to their balance, each bar's mean and that of all."""
    bars, trials = (1, 20) if options.small else (BARS, options.trials or TRIALS)
    seeds = range(1 if options.small else options.seeds)
    every = Table(f"Bars after {trials} trials")
    found: dict[str, list[Found]] = {way: [] for way in BUDGETS}
    for number in range(bars):
        bar = drawn_bar(number)
        for way, results in found.items():
            here = [lifted(bar, way, trials, seed) for seed in seeds]
            results += here
            told = {
                "balance mm": 1e3 * bar.balance,
                "mass kg": bar.mass,
                "friction": bar.friction,
                "bears N": bar.bears,
            }
            every.add(f"bar {number}, {way}", **told, **_row(here))
    return [every, _summary(found)]


def drawn_bar(number: int) -> Any:
    """The bar of a number."""
    spans = (MASS, BALANCE, FRICTION, BEARS)
    shares = uniforms(stream_key(0, "bar"), number, 1, len(spans))[0]
    values = (float(low + share * (high - low)) for (low, high), share in zip(spans, shares, strict=True))
    return example()["Bar"](*values)


def lifted(bar: Any, way: str, trials: int, seed: int) -> Found:
    """An exploration of a bar, and lifts where it says that the torque is zero."""
    exploration = Exploration(SPACE, ["torque"], seed=seed, start=START, retry=RETRY, invalid_budget=BUDGETS[way])
    drawn = _drawn(seed)
    for number in range(trials):
        parameters = exploration.ask().parameters if way != "drawn" else next(drawn)
        _tell(exploration, parameters, example()["trial"](bar, **parameters, seed=trial_seed(seed, {}, number)))
    invalid = sum(not each.valid for each in exploration.trials) / trials
    try:
        chosen = exploration.infer({"torque": 0.0}).parameters
    except NoParametersError:
        return Found(None, None, 0, None, invalid)
    again = [example()["trial"](bar, **chosen, seed=trial_seed(seed, {}, trials + i)) for i in range(LIFTS)]
    torques = [abs(each.outcomes["torque"]) for each in again if isinstance(each, Valid)]
    error = 1e3 * abs(chosen["along"] - bar.balance)
    return Found(error, chosen["force"], len(torques), float(np.mean(torques)) if torques else None, invalid)


def _tell(exploration: Exploration, parameters: dict[str, float], result: Any) -> None:
    if isinstance(result, Valid):
        exploration.tell({}, parameters, True, result.outcomes)
    else:
        exploration.tell({}, parameters, False, reason=result.reason)


def _drawn(seed: int) -> Iterator[dict[str, float]]:
    """Parameters from the whole box, the start first as in an exploration."""
    yield START
    key, number = stream_key(seed, "drawn"), 0
    while True:
        shares = uniforms(key, number, 1, len(SPACE.names))[0]
        yield {
            name: float(low + share * (high - low))
            for (name, (low, high)), share in zip(SPACE.parameters.items(), shares, strict=True)
        }
        number += 1


def _row(found: list[Found]) -> dict[str, Any]:
    errors = [each.error for each in found if each.error is not None]
    torques = [each.torque for each in found if each.torque is not None]
    return {
        "error mm": float(np.mean(errors)) if errors else None,
        "largest mm": max(errors, default=None),
        "torque Nm": float(np.mean(torques)) if torques else None,
        f"valid of {LIFTS}": float(np.mean([each.lifts for each in found])),
        "without parameters": len(found) - len(errors),
        "invalid trials": float(np.mean([each.invalid for each in found])),
    }


def _summary(found: dict[str, list[Found]]) -> Table:
    table = Table("What must be reached")
    rows = {way: _row(results) for way, results in found.items()}
    fewest = {way: min(each.lifts for each in results) for way, results in found.items()}

    def add(name: str, figures: dict[str, float | None], **bound: float) -> None:
        first, *others = figures
        must(table, name, figures[first], **bound, **{way: figures[way] for way in others})

    for name, figure in (("mean", "error mm"), ("largest", "largest mm")):
        add(f"{name} distance from the balance mm", {way: row[figure] for way, row in rows.items()}, at_most=3.0)
    add(f"fewest valid of {LIFTS} lifts", dict(fewest), at_least=LIFTS)
    add("share of invalid trials", {way: row["invalid trials"] for way, row in rows.items()}, at_most=0.4)
    return table
