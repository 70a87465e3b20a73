"""The core of tasks without robots: what scheduling costs where stages cost nothing, and the law of scheduling.

Must: 60 x 60 pairs of a connector in 50 microseconds each; thirteen places with three ways each before a stage that
always fails in 0.05 s (all 3^13 paths would take seconds); by every strategy, with pruning and without, all solutions
that there are by definition and no others, over 20,000 random trees, and with pruning at least 10 % fewer calls.
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
STRATEGIES: dict[str, dict[str, Any]] = {
    "rounds": {},
    "lazily": {"lazy": True},
    "depth first at first": {"depth_first": 30},
    "with workers (inline)": {"workers": 3},
}
COUNTED = ("enumerated", "with solutions", "not to the end", "both ways", "lost", "too much", "solutions lost")
LIMIT = 400  # jobs of a tree; some trees have very many solutions


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
    """Random trees of all containers and kinds of stages: each strategy against definition, and each by turns unpruned."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    from tests.support.oracles_tasks import by_definition
    from tests.support.random_tasks import Rich, Trees

    table = Table("Every strategy finds all that is a solution by definition, random trees")
    rows = {name: Counter() for name in STRATEGIES}
    for seed in range(trees):
        kind = Trees if seed % 4 == 0 else Rich
        task = kind(seed, monitors=seed % 2 == 1, depth=2 + (seed % 5 > 1) + (seed % 20 == 19)).task()
        truth = by_definition(task)
        for turn, (name, how) in enumerate(STRATEGIES.items() if truth is not None else ()):
            row, both = rows[name], (seed // 4) % len(STRATEGIES) == turn
            row["enumerated"] += 1
            row["with solutions"] += bool(truth)
            for pruning in (True, False) if both else (True,):
                found, calls = _exhausted(task, pruning, how)
                if found is None:
                    row["not to the end"] += 1
                    break
                if both:
                    row["both ways"] += not pruning
                    row["calls pruned" if pruning else "calls unpruned"] += calls
                row["lost"] += bool(truth - found)
                row["too much"] += bool(found - truth)
                row["solutions lost"] += sum((truth - found).values())
        if seed % 500 == 499:
            print(seed + 1, {name: dict(row) for name, row in rows.items()}, flush=True)
    for name, row in rows.items():
        figures = {key: row[key] for key in (*COUNTED, "calls pruned", "calls unpruned")}
        table.add(name, trees=trees, **figures, fewer=_fewer([row["calls pruned"], row["calls unpruned"]]))
    return table


def _fewer(calls: list[int]) -> str:
    return f"{100 * (1 - calls[0] / max(1, calls[1])):.3g} %"


def _exhausted(task: Task, pruning: bool, how: dict[str, Any]) -> tuple[Counter[Any] | None, int]:
    from tests.support.inline_workers import InlineWorkers
    from tests.support.random_tasks import canonical

    task.reset()
    task.pruning, task.lazy, task.depth_first = pruning, how.get("lazy", False), how.get("depth_first", 0)
    workers = how.get("workers")
    if workers is not None:
        task._workers = InlineWorkers(task._run(None), workers, min_seconds=0.0)  # noqa: SLF001 no door leads there
    found = task.plan(jobs=LIMIT, workers=workers)
    return (Counter(map(canonical, found)) if task.exhausted else None), _calls(task)
