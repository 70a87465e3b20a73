"""The thesis' tables for the domains of this repository: time, calls and sizes by scenario and search strategy.

    python benchmarks/thesis.py [--trials 5] [--largest 6] [--output thesis.json]

Columns as in [K Tables 6.2, 6.4, 6.7]; the last table compares bounded with exact geometry on the same search and
the same samples. Medians over the trials, each with a seed of its own; the kernels are compiled before. A run that
is not solved within its limits says so.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from table import Table, finish

import kabo

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
SEARCHES = ("depth-first", "breadth-first", "iterative-deepening")
SECONDS = 120.0  # of one run


def run(problem: Path, seed: int, **options: Any) -> tuple[str, dict[str, Any]]:
    """The status and the statistics of one run."""
    result = kabo.solve(kabo.load_problem(problem), seed=seed, timeout=SECONDS, **options)
    actions = None
    if result.plan is not None:
        from kabo.planner.result import plan_figures

        actions = plan_figures(result.plan)
    return result.status, {**result.statistics, **(actions or {})}


def row(problem: Path, trials: int, **options: Any) -> dict[str, Any]:
    """The medians of several runs, in the thesis' columns."""
    outcomes = [run(problem, seed, **options) for seed in range(trials)]
    solved = [figures for status, figures in outcomes if status == "solved"]
    if not solved:
        return {"solved": f"0 of {trials}", "why": outcomes[0][0]}

    def middle(name: str) -> float:
        return median(float(figures.get(name) or 0.0) for figures in solved)

    checks = middle("collision_checks")
    return {
        "solved": f"{len(solved)} of {trials}",
        "total s": middle("total_s") - middle("load_s"),
        "symbolic s": middle("symbolic_s"),
        "geometric s": middle("geometric_s"),
        "IK calls": int(middle("inverse_kinematics_calls")),
        "IK s": middle("inverse_kinematics_s"),
        "collision checks": int(checks),
        "collision s": middle("collision_s"),
        "positive %": 100.0 * middle("positive_collision_checks") / max(checks, 1.0),
        "states": int(middle("geometric_states")),
        "actions": int(middle("plan_actions")),
        "nodes": int(middle("plan_nodes")),
    }


def bartender(trials: int) -> Table:
    """BARTENDER with four bottles [K Table 6.1], as [K Table 6.2] tells its sister scenario."""
    table = Table("BARTENDER, four bottles, sensing unknown")
    problem = DOMAINS / "bartender" / "four_bottles.yaml"
    for search in SEARCHES:
        table.add(f"{search}, lazy", **row(problem, trials, search=search))
    return table


def force_sensing(trials: int, largest: int) -> Table:
    """FORCE SENSING [K Table 3.1]."""
    table = Table("FORCE SENSING, n containers, breadth-first, lazy")
    for n in range(1, largest + 1):
        table.add(f"n = {n}", **row(DOMAINS / "force_sensing" / f"n{n}.yaml", trials, search="breadth-first"))
    return table


def stacked(largest: int) -> Table:
    """STACKED n OBJECTS [K Table 6.4]; deterministic, so one trial."""
    table = Table("STACKED n OBJECTS")
    for n in range(2, largest + 1):
        problem = DOMAINS / "stacked" / f"n{n}.yaml"
        for search in SEARCHES:
            table.add(f"n = {n}, {search}, lazy", **row(problem, 1, search=search))
        if n <= 4:
            table.add(
                f"n = {n}, breadth-first, eager", **row(problem, 1, search="breadth-first", geometry_order="eager")
            )
    return table


def geometries(trials: int) -> Table:
    """Bounded against exact geometry, same search and samples [K Table 6.7]."""
    table = Table(
        "Bounded convex parts against the original meshes (python-fcl, segments sampled every 2 epsilon)"
    )
    for name in ("stacked/n3", "force_sensing/n1", "bartender/four_bottles"):
        for geometry in ("bounding", "exact"):
            table.add(f"{name}, {geometry}", **row(DOMAINS / f"{name}.yaml", trials, geometry=geometry))
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs everything, prints the tables and writes the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=5)
    parser.add_argument("--largest", type=int, default=6, help="largest n of FORCE SENSING and STACKED")
    parser.add_argument("--only", choices=["bartender", "force_sensing", "stacked", "geometries"])
    parser.add_argument("--output", type=Path, default=Path("thesis.json"))
    options = parser.parse_args(arguments)
    for name in ("bartender/four_bottles", "force_sensing/n1", "stacked/n2"):
        run(DOMAINS / f"{name}.yaml", 0)  # compiles what is not compiled yet
    makers = {
        "bartender": lambda: bartender(options.trials),
        "force_sensing": lambda: force_sensing(options.trials, options.largest),
        "stacked": lambda: stacked(options.largest),
        "geometries": lambda: geometries(min(options.trials, 3)),
    }
    tables = [make() for name, make in makers.items() if options.only in (None, name)]
    finish(tables, options.output, trials=options.trials, largest=options.largest, seconds=SECONDS)


if __name__ == "__main__":
    main()
