"""From which length of jobs on do worker processes pay, and what do they cost where they do not?

    python benchmarks/tasks_workers.py [--small] [--solutions N] [--output FOLDER]

Rounds of two sections with jobs of a given length, and the applications of the thesis, planned without workers and with
two and four processes: seconds by the wall and of all processors, and whether the solutions are the same, in order,
with their costs. `always` sends every job, `measured` is the rule of `kabo.tasks.core.run.workers`: jobs of stages are sent
whose mean job takes longer than `MIN_SECONDS_TO_SEND`. Each configuration takes its turn in every repetition.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median
from time import perf_counter, sleep
from typing import Any

from table import Table, finish
from tasks_applications import applications

from kabo.tasks.core import Result, Task, connector, forward, generator
from kabo.tasks.core.run import workers

SIZES = (None, 2, 4)
RULE = workers.MIN_SECONDS_TO_SEND
LENGTHS = (0.0002, 0.001, 0.003, 0.01, 0.03, 0.05, 0.1)  # seconds of a job
APPLICATIONS = (("pick_and_place", "panda.yaml"), ("retract_transit_approach", "panda.yaml"))
Made = Callable[[], tuple[Task, Any]]


def main() -> None:
    """Measures, prints rows as they come, and writes both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--small", action="store_true", help="a few rows, to see that it runs")
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="how often each is measured")
    parser.add_argument("--solutions", type=int, default=10, metavar="N", help="of the applications")
    parser.add_argument("--output", type=Path, default=Path("tasks"), metavar="FOLDER")
    options = parser.parse_args()
    if options.small:
        options.repeat, options.solutions = 1, 2
    options.output.mkdir(parents=True, exist_ok=True)
    lengths = LENGTHS[::4] if options.small else LENGTHS
    busy = Table("Jobs of one length, two sections")
    for length in lengths:
        for rule, pays in (("always", 0.0), ("measured", RULE)):
            rows = measured(lambda length=length: (busy_task(length), None), None, options.repeat, pays)
            add(busy, f"{1000 * length:g} ms, {rule}", rows)
    robots = Table("Applications")
    for name, public in APPLICATIONS[: 1 if options.small else None]:
        for application in applications(name, ["generated"], public):
            rows = measured(lambda a=application: a.start(0), options.solutions, options.repeat, RULE)
            add(robots, name, rows)
    finish([busy, robots], options.output / "workers.json", repeat=options.repeat, solutions=options.solutions)


def busy_task(length: float) -> Task:
    """Six states on either side of a connector, carried on twice: 60 jobs that take time and no processor.

    So the figures say what the order of jobs and the sending allow, however many processors are free.
    """

    @generator(count=6)
    def offer(scene: Any, properties: Any, seed: int) -> Any:
        yield from (Result(value) for value in range(properties["count"]))

    @forward()
    def carry(scene: Any, properties: Any, seed: int) -> Any:
        sleep(length)
        yield Result(scene + 1)

    @connector()
    def join(start: Any, end: Any, properties: Any, seed: int) -> Any:
        sleep(length)
        return Result(cost=float(abs(start - end)))

    return Task("t", offer("from"), carry("a"), carry("b"), join("join"), offer("to"), carry("c"), carry("d"))


def measured(made: Made, solutions: int | None, repeat: int, pays: float) -> dict[Any, tuple[float, float, Any]]:
    """Of every number of workers the median seconds by the wall and of the processors, and what was found."""
    task, scene = made()
    task.plan(scene, solutions)  # compiles, and fills what the scene remembers
    taken: dict[Any, list[tuple[float, float]]] = {size: [] for size in SIZES}
    found: dict[Any, Any] = {}
    workers.MIN_SECONDS_TO_SEND = pays
    for _ in range(repeat):
        for size in SIZES:
            task, scene = made()
            wall, processor = perf_counter(), used()
            plans = task.plan(scene, solutions, workers=size)
            task.close()
            taken[size].append((perf_counter() - wall, used() - processor))
            found[size] = [(s.cost, s.comment, [(p.cost, p.comment) for p in s.leaves]) for s in plans]
    return {s: (median(w for w, _ in each), median(p for _, p in each), found[s]) for s, each in taken.items()}


def used() -> float:
    """Seconds of the processors, of this process and of those that have ended."""
    return sum(each.ru_utime + each.ru_stime for each in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))


def add(table: Table, name: str, rows: dict[Any, tuple[float, float, Any]]) -> None:
    """One row."""
    figures: dict[str, Any] = {"solutions": len(rows[None][2])}
    for size in SIZES:
        figures[f"wall {size or 'none'}"], figures[f"processor {size or 'none'}"] = rows[size][:2]
    figures["same"] = "yes" if all(rows[size][2] == rows[None][2] for size in SIZES) else "NO"
    table.add(name, **figures)


if __name__ == "__main__":
    main()
