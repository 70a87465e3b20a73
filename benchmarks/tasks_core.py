"""The core of tasks without robots: what scheduling costs where stages cost nothing, and the law of pruning.

Must: 60 x 60 pairs of a connector in 50 microseconds each; thirteen places with three ways each before a stage that
always fails in 0.05 s (all 3^13 paths would take seconds); with pruning the same solutions as without, and at least
10 % fewer calls of stages, over 10,000 random trees.
"""

import sys
from collections import Counter
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from table import Table

from kabo.tasks import Failure, Fallbacks, Result, Task, connector, forward, generator

SIDE, PLACES, WAYS = 60, 13, 3
LIMIT = 1500  # jobs of a tree; some trees have very many solutions
SECONDS = 2.0  # of a tree: mergers of mergers make scenes that are long to write down


@generator(values=[1, 2, 3])
def numbers(scene: Any, properties: Any, seed: int) -> Any:
    """Numbers, each at a cost."""
    yield from (Result(value, cost=value) for value in properties["values"])


@connector()
def join(start: Any, end: Any, properties: Any, seed: int) -> Any:
    """Joins two numbers."""
    return Result(cost=abs(start - end))


@connector()
def even(start: Any, end: Any, properties: Any, seed: int) -> Any:
    """Joins two numbers whose difference is even."""
    return Failure("odd") if (start - end) % 2 else Result(cost=abs(start - end))


@forward()
def never(scene: Any, properties: Any, seed: int) -> Any:
    """Always fails."""
    return Failure("never")


def core_table(repeat: int) -> Table:
    """The grid of a connector and the alternation, the median of some runs."""
    table = Table("Core of tasks, processor time")
    made_by = {
        "grid 60 x 60": _grid,
        "13 places, 3 ways, all in vain": _alternation,
        "grid 60 x 60, fallbacks": _second_tries,
    }
    for name, made in made_by.items():
        rows = [_measured(made()) for _ in range(repeat + 1)][1:]
        seconds, calls = median(row[0] for row in rows), rows[0][1]
        table.add(name, s=seconds, calls=calls, solutions=rows[0][2], **{"us per call": 1e6 * seconds / calls})
    return table


def _grid() -> Task:
    ends = list(range(SIDE))
    return Task("grid", numbers("from", values=ends), join("join"), numbers("to", values=ends))


def _second_tries() -> Task:
    """Half of the pairs are refused by the first of two connectors."""
    ends = list(range(SIDE))
    ways = Fallbacks("ways", even("even"), join("join"))
    return Task("fallbacks", numbers("from", values=ends), ways, numbers("to", values=ends))


def _alternation() -> Task:
    stages: list[Any] = []
    for place in range(PLACES):
        stages += [numbers(f"place {place}"), join(f"join {place}")]
    return Task("alternation", *stages[:-1], never("in vain"))


def _measured(task: Task) -> tuple[float, int, int]:
    began = process_time()
    found = task.plan()
    seconds = process_time() - began
    calls = task.statistics["join"].calls if task.name == "grid" else _calls(task)
    return seconds, calls, len(found)


def _calls(task: Task) -> int:
    return sum(figures.calls for figures in task.statistics.values())


def law_table(trees: int) -> Table:
    """Random trees of all containers and kinds of stages, planned to the end with pruning and without."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    from tests.random_tasks import Trees

    table, total = Table("Pruning, random trees"), [0, 0]
    for monitors in (False, True):
        calls, differing, planned, solved = [0, 0], 0, 0, 0
        for seed in range(trees // 2):
            task = Trees(seed, monitors=monitors).task()
            pruned, less = _exhausted(task, True)
            if pruned is None:
                continue  # without pruning it takes longer still
            every, more = _exhausted(task, False)
            if every is None:
                continue
            planned += 1
            solved += bool(every)
            differing += pruned != every
            calls = [calls[0] + less, calls[1] + more]
        total = [total[0] + calls[0], total[1] + calls[1]]
        table.add(
            "with monitors" if monitors else "without monitors",
            **{"trees": trees // 2, "planned to the end": planned, "with solutions": solved},
            **{"other solutions": differing, "calls pruned": calls[0], "calls unpruned": calls[1]},
            fewer=_fewer(calls),
        )
    table.add("all", trees=2 * (trees // 2), fewer=_fewer(total))
    return table


def _fewer(calls: list[int]) -> str:
    return f"{100 * (1 - calls[0] / max(1, calls[1])):.3g} %"


def _exhausted(task: Task, pruning: bool) -> tuple[Counter[Any] | None, int]:
    from tests.random_tasks import canonical

    task.pruning = pruning
    task.reset()
    began = process_time()
    found = task.plan(jobs=LIMIT, stop=lambda: process_time() - began > SECONDS)
    return (Counter(map(canonical, found)) if task.exhausted else None), _calls(task)
