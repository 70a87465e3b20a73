"""What `--quality good` makes of the plans of the thesis' scenarios, and what it costs.

    python benchmarks/quality.py [--only WORD ...] [--seeds N] [--output FILE]

Each problem is solved with both qualities, the seeds in turn. *way* is the length of the longest branch [rad or m, L2
over the joints], *lasts* its duration [s], both before and after refinement under the same limits of velocity and
acceleration; *early* the sum of all overlaps of the plan [s]; *seconds* are of the processor, after one solve that
compiles. *verified*: plans that `kabo verify` accepts, fast and good ones.
"""

import argparse
from pathlib import Path
from statistics import mean
from time import process_time
from typing import Any

from table import Table, finish

import kabo

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
PROBLEMS = (
    "bartender/four_bottles",
    "force_sensing/n3",
    "stacked/n5",
    "stacked/n8",
    "circular_rearrange/n3",
)
FIGURES = ("path_length_found", "path_length", "duration_found", "duration", "overlap")


def solved(problem: Any, quality: str, seed: int) -> dict[str, Any]:
    """One plan: seconds of the processor, whether it is verified, and the figures of its refinement."""
    began = process_time()
    result = kabo.solve(problem, seed=seed, quality=quality)
    seconds = process_time() - began
    if result.plan is None:
        return {"seconds": seconds, "verified": False}
    figures = {name: result.statistics.get(name) for name in FIGURES}
    return {"seconds": seconds, "verified": kabo.verify(problem, result.plan).ok, **figures}


def row(name: str, seeds: int) -> dict[str, Any]:
    """The figures of one problem over all seeds."""
    problem = kabo.load_problem(DOMAINS / f"{name}.yaml")
    solved(problem, "good", 0)
    runs = {quality: [solved(problem, quality, seed) for seed in range(seeds)] for quality in ("fast", "good")}
    good = [run for run in runs["good"] if "overlap" in run]
    before = {name: mean(run[name] for run in good) if good else None for name in FIGURES}
    return {
        "way": before["path_length_found"],
        "way after": before["path_length"],
        "lasts": before["duration_found"],
        "lasts after": before["duration"],
        "early": before["overlap"],
        "seconds fast": mean(run["seconds"] for run in runs["fast"]),
        "seconds good": mean(run["seconds"] for run in runs["good"]),
        "verified": f"{sum(run['verified'] for each in runs.values() for run in each)}/{2 * seeds}",
    }


def main() -> None:
    """Prints the table, writes JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="WORD", help="problems with one of these in the name"
    )
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    table = Table("Plans as found and refined, means over the seeds")
    for name in PROBLEMS:
        if not options.only or any(word in name for word in options.only):
            table.add(name, **row(name, options.seeds))
    finish([table], options.output, seeds=options.seeds)


if __name__ == "__main__":
    main()
