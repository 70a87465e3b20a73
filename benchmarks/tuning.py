"""What the tuned constants of the search are worth: each is halved and doubled, all else left as it is.

    python benchmarks/tuning.py [--rounds 1] [--only NAME] [--output tuning.json]

Every setting solves the same small problems in a process of its own. Rows are ratios to the constants as they are:
expansions, samples and processor time, each summed over the problems that the constant can concern, and how many of
their plans are others or missing.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from time import process_time
from typing import Any

from table import Table, finish

import kabo
from kabo import tuning
from kabo.plan import plan_hash

DOMAINS = Path(__file__).resolve().parent.parent / "domains"
Row = dict[str, Any]

# A problem is a file below domains/, and the options of its solve.
SENSING: list[tuple[str, Row]] = [
    ("wumpus/n5.yaml", {}),
    ("medicate/n5.yaml", {}),
    ("doors/n5.yaml", {}),
    ("painted_doors/n3.yaml", {}),
    ("coloured_balls/n4_2.yaml", {}),
    ("elogistics/n3.yaml", {}),
    ("poisonous_liquid/n2.yaml", {}),
    ("canadian_traveller/n3.yaml", {}),
    ("safes/n3.yaml", {}),
    ("bomb_in_the_toilet/n4_two_toilets.yaml", {}),
    ("grid/n3.yaml", {}),
    ("bartender/four_bottles.yaml", {"geometry": "none"}),
    ("wumpus/n4.yaml", {"search": "greedy"}),
    ("painted_doors/n3.yaml", {"search": "greedy"}),
    ("medicate/n5.yaml", {"search": "astar"}),
    ("grid/n3.yaml", {"search": "depth-first", "max_expansions": 20_000}),
]
CLASSICAL: list[tuple[str, Row]] = [
    ("rovers/n4.yaml", {}),
    ("rovers/n4.yaml", {"search": "greedy"}),
    ("logistics/n3.yaml", {}),
    ("logistics/n3.yaml", {"search": "astar"}),
    ("logistics/n3.yaml", {"search": "breadth-first", "max_expansions": 20_000}),
    ("unix/n2.yaml", {}),
    ("stacked/n10.yaml", {"geometry": "none"}),
    ("stacked/n20.yaml", {"geometry": "none"}),
]
GEOMETRIC: list[tuple[str, Row]] = [
    ("stacked/n2.yaml", {}),
    ("stacked/n6.yaml", {}),
    ("stacked/n10.yaml", {}),
    ("bartender/four_bottles.yaml", {}),
    ("force_sensing/n6.yaml", {}),
    ("circular_rearrange/n2.yaml", {}),
    ("circular_rearrange/n4.yaml", {}),
]
EAGER: list[tuple[str, Row]] = [
    ("stacked/n2.yaml", {"geometry_order": "eager"}),
    ("stacked/n6.yaml", {"geometry_order": "eager"}),
    ("force_sensing/n3.yaml", {"geometry_order": "eager"}),
    ("circular_rearrange/n3.yaml", {"geometry_order": "eager"}),
    ("bartender/four_bottles.yaml", {"geometry_order": "eager"}),
]
ASKED: list[tuple[str, Row]] = [("asking_bartender/n3.yaml", {"procedures": "a third fails"})]

GROUPS: dict[str, list[tuple[str, Row]]] = {
    "MAX_SERIAL_EXPANSIONS": SENSING + CLASSICAL,
    "PREFERRED_QUEUE_TURNS": SENSING + CLASSICAL,
    "EXPANSIONS_WITHOUT_BOUNDS": SENSING,
    "VISITS_GROWTH": SENSING,
    "MAX_REMEMBERED_ESTIMATES": SENSING + CLASSICAL,
    "SECOND_SEARCH_EXPANSIONS": SENSING,
    "MAX_FAILED_CHOICES": SENSING,
    "FAILED_CHOICES_BEFORE_FIXPOINT": SENSING,
    "FAILED_CHOICES_GROWTH": SENSING,
    "MIN_FIXPOINT_NODES": SENSING,
    "MAX_DEAD_STATES": SENSING,
    "MAX_ALTERNATIVES": CLASSICAL,
    "MAX_DISJUNCTIONS": CLASSICAL,
    "EAGER_EXPANSIONS": EAGER,
    "EAGER_EXPANSIONS_GROWTH": EAGER,
    "EAGER_ATTEMPTS_PER_EFFORT": EAGER,
    "MAX_SEEDS": ASKED,
    "MIN_EXTERNAL_CALLS": ASKED,
    "EXTERNAL_FAILURE_SHARE": ASKED,
    "PLAIN_BREADTH_FIRST_STATES": CLASSICAL,
    "PLAIN_ASTAR_STATES": CLASSICAL,
    "PLAIN_NOVELTY_STATES": CLASSICAL,
    "PLAIN_NOVELTY_PAIRS": CLASSICAL,
    "PLAIN_RELAXATION_VISITS": SENSING + CLASSICAL,
    "PLAIN_MUTEX_VARIANTS": CLASSICAL,
    "MAX_MUTEX_FACTS": CLASSICAL,
    "MAX_MUTEX_WORK": CLASSICAL,
    "NOVELTY_PAIR_BYTES": CLASSICAL,
}  # all others concern geometry that is asked lazily


def constants() -> dict[str, float]:
    """The tuned constants by name, in the order of the file."""
    return {name: value for name, value in vars(tuning).items() if name.isupper()}


def settings(value: float) -> tuple[float, float]:
    """Half of a constant and twice as much; shares stay below 1, counts above 0."""
    if isinstance(value, float):
        return value / 2.0, min(2.0 * value, 0.99)
    return max(1, value // 2), 2 * value


def solved(file: str, options: Row) -> Row:
    """What one solve took, and the hash of its plan."""
    asked: list[Any] = []
    options = dict(options)
    problem = kabo.load_problem(DOMAINS / file)
    if "procedures" in options:
        options["procedures"] = dict.fromkeys(problem.domain.procedures, _third_fails)
    began = process_time()
    result = kabo.solve(problem, **options, certificate=False, timeout=60.0, on_procedures=asked.append)
    took = process_time() - began
    return {
        "file": file,
        "status": result.status,
        "plan": None if result.plan is None else plan_hash(result.plan),
        "expanded": result.statistics["expanded"],
        "samples": asked[0].statistics.samples if asked else 0,
        "cpu_s": took,
    }


def _third_fails(*arguments: object, seed: int = 0) -> bool:
    """Fails for a third of all arguments and seeds; a pure function, as procedures have to be."""
    return sum(map(ord, repr((arguments, seed)))) % 3 != 0


def child(name: str | None, value: float | None, problems: list[tuple[str, Row]]) -> list[Row]:
    """What the problems take in a new process with one constant set to a value."""
    told = json.dumps([name, value, problems])
    command = [sys.executable, __file__, "--child", told]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: list[Row] = json.loads(done.stdout)
    return found


def ratios(rows: list[Row], base: list[Row]) -> Row:
    """Sums of a setting by those of the constants as they are; and the plans that are others or missing."""
    found: Row = {}
    for figure in ("expanded", "samples", "cpu_s"):
        whole = sum(row[figure] for row in base)
        found[figure] = sum(row[figure] for row in rows) / whole if whole else None
    pairs = list(zip(rows, base, strict=True))
    found["other"] = sum(row["plan"] != was["plan"] for row, was in pairs if row["plan"] and was["plan"])
    found["missing"] = sum(row["plan"] is None and was["plan"] is not None for row, was in pairs)
    return found


def main() -> None:
    """Runs every setting, prints the table, writes JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="constants whose name contains this")
    parser.add_argument("--rounds", type=int, default=1, help="runs of the constants as they are, for the noise")
    parser.add_argument("--output", type=Path)
    parser.add_argument("--child", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child is not None:
        name, value, problems = json.loads(options.child)
        if name is not None:
            assert name in constants()
            setattr(tuning, name, value)
        print(json.dumps([solved(file, given) for file, given in problems]))
        return
    chosen = {name: value for name, value in constants().items() if not options.only or options.only in name}
    every = {json.dumps(GROUPS.get(name, GEOMETRIC)): GROUPS.get(name, GEOMETRIC) for name in chosen}
    noise = Table("the constants as they are, twice: the noise")
    base: dict[str, list[Row]] = {}
    for key, problems in every.items():
        child(None, None, problems)  # compiles what is not compiled yet
        base[key] = child(None, None, problems)
        for _ in range(options.rounds):
            again = child(None, None, problems)
            noise.add(f"{len(problems)} problems, {problems[0][0]} …", **ratios(again, base[key]))
    table = Table("each constant halved and doubled: ratios to the constants as they are")
    for name, value in chosen.items():
        problems = GROUPS.get(name, GEOMETRIC)
        halved, doubled = (
            ratios(child(name, setting, problems), base[json.dumps(problems)]) for setting in settings(value)
        )
        row = {f"{figure} ½": halved[figure] for figure in halved}
        table.add(name, value=value, **row, **{f"{figure} 2×": doubled[figure] for figure in doubled})
    finish([noise, table], options.output, problems={name: GROUPS.get(name, GEOMETRIC) for name in chosen})


if __name__ == "__main__":
    main()
