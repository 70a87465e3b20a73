"""What kabo promises of the domains of this repository: solved for every seed, verified, how large, how long.

    python benchmarks/promises.py [--seeds 20] [--verify 3] [--output promises.json]

BARTENDER with sensing unknown for many seeds (how many plans differ, compared without options), the same seed
again (the same bytes), FORCE SENSING and STACKED with six objects; each plan of the first seeds is verified.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from time import perf_counter

from table import Table, finish

import kabo
from kabo.plan import plan_statistics, plan_to_json

DOMAINS = Path(__file__).resolve().parent.parent / "domains"


def without_options(plan: bytes) -> bytes:
    """The bytes of a plan but for the options, which name the seed."""
    content = json.loads(plan)
    del content["options"]
    return json.dumps(content, sort_keys=True).encode()


def bartender(seeds: int, verified: int) -> Table:
    """Every seed of BARTENDER."""
    table = Table("BARTENDER, four bottles, sensing unknown, default options")
    problem = kabo.load_problem(DOMAINS / "bartender" / "four_bottles.yaml")
    again = {plan_to_json(kabo.solve(problem, seed=0).plan)}  # compiles what is not compiled yet, too
    solved, seconds, plans, checks = 0, [], set(), []
    for seed in range(seeds):
        began = perf_counter()
        result = kabo.solve(problem, seed=seed)
        took = perf_counter() - began
        row: dict[str, object] = {"status": result.status, "s": took, "procedure calls": _calls(result)}
        if result.plan is not None:
            solved += 1
            seconds.append(took)
            plans.add(without_options(plan_to_json(result.plan)))
            if seed == 0:
                again.add(plan_to_json(result.plan))
            row |= asdict(plan_statistics(result.plan))
            if seed < verified:
                began = perf_counter()
                row["verified"] = kabo.verify(problem, result.plan).ok
                checks.append(perf_counter() - began)
                row["verification s"] = checks[-1]
        table.add(f"seed {seed}", **row)
    table.add(
        "all",
        status=f"{solved} of {seeds} solved",
        s=median(seconds),
        different=len(plans),
        repeated="same bytes" if len(again) == 1 else "DIFFERENT BYTES",
        **({"verification s": median(checks)} if checks else {}),
    )
    return table


def _calls(result: kabo.Result) -> int:
    return sum(row["calls"] for row in result.statistics["procedures"].values())


def six() -> Table:
    """FORCE SENSING and STACKED with six objects."""
    table = Table("Six objects")
    for name, options in (("force_sensing/n6", {}), ("stacked/n6", {"search": "breadth-first"})):
        problem = kabo.load_problem(DOMAINS / f"{name}.yaml")
        seconds = []
        for seed in range(3):
            began = perf_counter()
            result = kabo.solve(problem, seed=seed, **options)
            seconds.append(perf_counter() - began)
        if result.plan is None:
            table.add(name, status=result.status)
            continue
        began = perf_counter()
        ok = kabo.verify(problem, result.plan).ok
        figures = asdict(plan_statistics(result.plan))
        table.add(
            name,
            status=result.status,
            s=median(seconds),
            verified=ok,
            verification=perf_counter() - began,
            **figures,
        )
    return table


def start_up(starts: int) -> Table:
    """How long commands take that need no planning."""
    table = Table(f"Start-up, new process each, median of {starts}")
    for arguments in (["--help"], ["check", str(DOMAINS / "bartender" / "four_bottles.yaml")]):
        seconds = []
        for _ in range(starts):
            began = perf_counter()
            subprocess.run([sys.executable, "-m", "kabo.cli", *arguments], capture_output=True, check=False)
            seconds.append(perf_counter() - began)
        table.add(f"kabo {arguments[0]}", s=median(seconds))
    return table


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs everything, prints the tables and writes the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--verify", type=int, default=3, help="plans of so many seeds are verified")
    parser.add_argument("--starts", type=int, default=5, metavar="N", help="of each command")
    parser.add_argument("--only", nargs="+", choices=("start-up", "six", "bartender"), metavar="TABLE")
    parser.add_argument("--output", type=Path, default=Path("promises.json"))
    options = parser.parse_args(arguments)
    made = {
        "start-up": lambda: start_up(options.starts),
        "six": six,
        "bartender": lambda: bartender(options.seeds, options.verify),
    }
    tables = [table() for name, table in made.items() if not options.only or name in options.only]
    finish(tables, options.output, seeds=options.seeds, verified=options.verify)


if __name__ == "__main__":
    main()
