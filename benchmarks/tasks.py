"""What Task Construction costs and reaches: its core without robots, and the applications of the thesis [T 3.9].

    python benchmarks/tasks.py [SECTION …] [--seeds N] [--judged N] [--output FOLDER] …

Sections: `core` (connector grid, alternation of three ways in thirteen places), `law` (random trees with and without
pruning), `pick_and_place` [T 3.9.1], `padding` (retract, transit, approach with more air [T 3.9.3]), `pouring` [T 3.9.2],
`reparameterisation` [T 3.4.1; needs the extra `timing`], `stack` (the whole
stack over several runs as a report that `kabo task compare` takes [T 3.10]); without any, all of them. Each prints
tables and writes FOLDER/<section>.json.

Robots are generated ones, and the Panda of example-robot-data where the extra `robots` is installed. Solutions are
judged by `tasks_judge.py`, with pinocchio and coal on the original meshes.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from table import Table, finish

Section = Callable[[argparse.Namespace], list[Table]]


def core(options: argparse.Namespace) -> list[Table]:
    """What scheduling costs where stages cost nothing."""
    from tasks_core import core_table

    return [core_table(options.repeat)]


def law(options: argparse.Namespace) -> list[Table]:
    """Pruning keeps every solution."""
    from tasks_core import law_table

    return [law_table(options.trees)]


def pick_and_place(options: argparse.Namespace) -> list[Table]:
    """A cylinder from one place to another."""
    from tasks_pick_and_place import pick_and_place_tables

    return pick_and_place_tables(options.robots, options.seeds, options.solutions, options.judged)


def padding(options: argparse.Namespace) -> list[Table]:
    """More air on the way from one side of a thing to the other."""
    from tasks_padding import padding_tables

    return padding_tables(options.robots, options.judged)


def pouring(options: argparse.Namespace) -> list[Table]:
    """A bottle poured from, with three ways to choose configurations in three variants."""
    from tasks_pouring import pouring_tables

    return pouring_tables(options.robots, options.pourings, options.limit)


def reparameterisation(options: argparse.Namespace) -> list[Table]:
    """Phases of one scene without stops between them."""
    from tasks_reparameterisation import reparameterisation_tables

    return reparameterisation_tables(options.robots, options.seeds)


def stack(options: argparse.Namespace) -> list[Table]:
    """Every stage of pick and place over several runs."""
    from tasks_stack import stack_tables

    return stack_tables(options.robots, options.runs, options.output)


RUN: dict[str, Section] = {
    "core": core,
    "law": law,
    "pick_and_place": pick_and_place,
    "padding": padding,
    "pouring": pouring,
    "reparameterisation": reparameterisation,
    "stack": stack,
}


def main() -> None:
    """Measures what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"of {', '.join(RUN)}")
    parser.add_argument("--robots", nargs="+", choices=("generated", "public"), default=["generated", "public"])
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="core: how often each is measured")
    parser.add_argument("--trees", type=int, default=20_000, metavar="N", help="law: how many random trees")
    parser.add_argument("--seeds", type=int, default=15, metavar="N", help="pick_and_place: how many seeds")
    parser.add_argument("--solutions", type=int, default=10, metavar="N", help="pick_and_place: of each seed")
    parser.add_argument("--pourings", type=int, default=10, metavar="N", help="pouring: seeds of each cell")
    parser.add_argument("--limit", type=float, default=60.0, metavar="S", help="pouring: of each run")
    parser.add_argument("--judged", type=int, default=10, metavar="N", help="replayed solutions of each seed")
    parser.add_argument("--runs", type=int, default=25, metavar="N", help="stack: how many runs")
    parser.add_argument("--output", type=Path, default=Path("tasks"), metavar="FOLDER")
    options = parser.parse_args()
    unknown = set(options.sections) - set(RUN)
    if unknown:
        parser.error(f"no section {', '.join(sorted(unknown))}; there are {', '.join(RUN)}")
    options.output.mkdir(parents=True, exist_ok=True)
    settings = {name: value for name, value in vars(options).items() if name not in ("sections", "output")}
    for section, measured in RUN.items():
        if section in options.sections or not options.sections:
            load = [round(value, 2) for value in os.getloadavg()]
            tables = measured(options)
            finish(tables, options.output / f"{section}.json", section=section, load_before=load, **settings)


if __name__ == "__main__":
    main()
