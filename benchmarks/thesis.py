"""The thesis' tables for its five scenarios: time, calls and sizes by scenario and search strategy.

    python benchmarks/thesis.py [--trials 12] [--only SCENARIO] [--seconds 120] [--output thesis.json]

Columns as in [K Tables 6.2, 6.4, 6.7], means over the trials with their deviations, each trial with a seed of its own;
the last table compares bounded with exact geometry on the same search and the same samples. Every plan is verified, by
its certificate and against the original meshes. The kernels are compiled before. Seconds are those of the processor,
in one process, without loading. A run that is not solved within its limits says so; after two of a row, the row ends.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import mean, stdev
from typing import Any

from table import Table, write

import kabo

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
SEARCHES = ("best", "breadth-first", "iterative-deepening", "depth-first")
FIGURES = {
    "symbolic s": "symbolic_s",
    "geometric s": "geometric_s",
    "IK calls": "inverse_kinematics_calls",
    "IK s": "inverse_kinematics_s",
    "collision checks": "collision_checks",
    "collision s": "collision_s",
    "states": "geometric_states",
    "actions": "plan_actions",
    "nodes": "plan_nodes",
}


def run(name: str, seed: int, seconds: float, **options: Any) -> tuple[str, dict[str, Any]]:
    """The status and the figures of one run; a plan that is not verified has the status `refused`."""
    problem = kabo.load_problem(DOMAINS / f"{name}.yaml")
    began = time.process_time()
    result = kabo.solve(problem, seed=seed, timeout=seconds, **options)
    figures = dict(result.statistics) | {"total s": time.process_time() - began - result.statistics["load_s"]}
    if result.plan is None:
        return result.status, figures
    from kabo.plan import plan_statistics

    report = kabo.verify(problem, result.plan)
    return "solved" if report.ok else "refused", figures | asdict(plan_statistics(result.plan))


def told(values: Sequence[float]) -> str:
    """`mean ± deviation`, in the digits that it deserves."""
    middle, spread = mean(values), stdev(values) if len(values) > 1 else 0.0
    digits = 0 if middle >= 100 else 1 if middle >= 10 else 2
    return f"{middle:.{digits}f} ± {spread:.{digits}f}"


Outcomes = list[tuple[str, dict[str, Any]]]


def outcomes(name: str, trials: int, seconds: float, **options: Any) -> Outcomes:
    """Status and figures of several runs, each with a seed of its own; two that run out of time are the last."""
    found: Outcomes = []
    for seed in range(trials):
        found.append(run(name, seed, seconds, **options))
        if [status for status, _ in found].count("exhausted") == 2:
            break
    return found


def row(found: Outcomes) -> dict[str, Any]:
    """The means and deviations of several runs, in the thesis' columns; the most checks and actions of any."""
    solved = [figures for status, figures in found if status == "solved"]
    figures: dict[str, Any] = {"solved and verified": f"{len(solved)} of {len(found)}"}
    others = sorted({status for status, _ in found} - {"solved"})
    if others:
        figures["else"] = ", ".join(others)
    if not solved:
        return figures
    figures["total s"] = told([each["total s"] for each in solved])
    for title, key in FIGURES.items():
        figures[title] = told([float(each.get(key) or 0.0) for each in solved])
    shares = [100.0 * each["positive_collision_checks"] / max(each["collision_checks"], 1) for each in solved]
    figures["positive %"] = told(shares)
    figures["most checks"] = max(each["collision_checks"] for each in solved)
    figures["most actions"] = max(each["plan_actions"] for each in solved)
    return figures


Sized = Callable[[int, float], Table]


def scenario(title: str, *problems: str, searches: Sequence[str] = SEARCHES[:1]) -> Sized:
    """A table of problems by search strategy."""

    def made(trials: int, seconds: float) -> Table:
        table = Table(title)
        run(problems[0], 0, 600.0)  # compiles what is not compiled yet
        for problem in problems:
            for search in searches:
                table.add(f"{problem}, {search}", **row(outcomes(problem, trials, seconds, search=search)))
        return table

    return made


def geometries(trials: int, seconds: float) -> Table:
    """Bounded against exact geometry, same search and samples [K Table 6.7]."""
    for geometry in ("bounding", "exact"):
        run("stacked/n2", 0, 600.0, geometry=geometry)  # compiles what is not compiled yet
    table = Table(
        "Bounded convex parts against the original meshes (python-fcl), both without overlooking anything"
    )
    for name in ("assembly/gearbox", "circular_rearrange/n3", "stacked/n3"):
        totals = []
        for geometry in ("bounding", "exact"):
            found = outcomes(name, min(trials, 3), 5 * seconds, geometry=geometry, certificate=False)
            totals.append([figures["total s"] for status, figures in found if status == "solved"])
            ratio = {"exact : bounding": mean(totals[1]) / mean(totals[0])} if all(totals) and totals[1:] else {}
            table.add(f"{name}, {geometry}", **row(found), **ratio)
    return table


TABLES: dict[str, Sized] = {
    "assembly": scenario("BIMANUAL ASSEMBLY [K Table 6.7]", "assembly/gearbox", searches=SEARCHES),
    "circular": scenario(
        "BIMANUAL CIRCULAR REARRANGE, n = 3 [K Table 6.2]", "circular_rearrange/n3", searches=SEARCHES
    ),
    "circular_more": scenario("BIMANUAL CIRCULAR REARRANGE", *(f"circular_rearrange/n{n}" for n in (2, 4, 5, 6))),
    "stacked": scenario(
        "STACKED n OBJECTS [K Table 6.4]", *(f"stacked/n{n}" for n in range(2, 5)), searches=SEARCHES
    ),
    "stacked_more": scenario("STACKED n OBJECTS", *(f"stacked/n{n}" for n in (5, 6, 8, 12, 20))),
    "bartender": scenario("BARTENDER, four bottles, sensing unknown [K Table 6.1]", "bartender/four_bottles"),
    "force_sensing": scenario(
        "FORCE SENSING [K Table 3.1]", *(f"force_sensing/n{n}" for n in (1, 2, 4, 6, 8, 10))
    ),
    "geometries": geometries,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs everything, prints the tables and writes the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=12)
    parser.add_argument("--only", choices=list(TABLES), nargs="+", default=list(TABLES))
    parser.add_argument("--seconds", type=float, default=120.0, help="of one run at most, on the clock")
    parser.add_argument("--output", type=Path, default=Path("thesis.json"))
    options = parser.parse_args(arguments)
    tables: list[Table] = []
    for name in options.only:  # each is kept as soon as it is there: all of them take hours
        tables.append(TABLES[name](options.trials, options.seconds))
        print(tables[-1], end="\n\n", flush=True)
        write(tables, options.output, trials=options.trials, seconds=options.seconds)


if __name__ == "__main__":
    main()
