"""What exploration reaches [T ch. 4]: lines, strings, budgets of invalid trials, the bar, the reach, the speed.

    python benchmarks/exploration.py [SECTION …] [--seeds N] [--trials N] [--output FOLDER] …

Sections: `line` (reference geometry from contacts [T Fig. 4.6]), `string` (plucks of five strings in both directions
[T Fig. 4.7, 4.8]), `budget` (the same with a budget of invalid trials), `bar` (a bar of unknown balance, lifted in
MuJoCo; extra `simulation`), `reach` (places of the task of examples/pick_and_place), `speed` (processor time of the
next trial), `journal` (a run that is resumed and killed again and again), `worlds` (synthetic ones of known
truth); without any, all of them. Each prints tables and writes FOLDER/<section>.json. Beside a figure stands what it must
reach, and whether it does.

Each section is a file of its own, `exploration_<section>.py`, whose function `tables` takes the options.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from table import Table, finish

Section = Callable[[argparse.Namespace], list[Table]]


def line(options: argparse.Namespace) -> list[Table]:
    """The error of a string's line after so many contacts."""
    from exploration_line import tables

    return tables(options)


def string(options: argparse.Namespace) -> list[Table]:
    """What is known of a string after so many plucks, and whether it can be played as loudly as asked for."""
    from exploration_string import tables

    return tables(options)


def budget(options: argparse.Namespace) -> list[Table]:
    """Whether a budget of invalid trials is kept, and what it costs."""
    from exploration_budget import tables

    return tables(options)


def bar(options: argparse.Namespace) -> list[Table]:
    """How near to its balance a bar is lifted."""
    from exploration_bar import tables

    return tables(options)


def reach(options: argparse.Namespace) -> list[Table]:
    """Whether a place can be reached is told without planning."""
    from exploration_reach import tables

    return tables(options)


def speed(options: argparse.Namespace) -> list[Table]:
    """What the next trial costs."""
    from exploration_speed import tables

    return tables(options)


def journal(options: argparse.Namespace) -> list[Table]:
    """Whether an interrupted run writes the same bytes."""
    from exploration_journal import tables

    return tables(options)


def worlds(options: argparse.Namespace) -> list[Table]:
    """What is found in worlds whose truth is known."""
    from exploration_worlds import tables

    return tables(options)


RUN: dict[str, Section] = {
    "line": line,
    "string": string,
    "budget": budget,
    "bar": bar,
    "reach": reach,
    "speed": speed,
    "journal": journal,
    "worlds": worlds,
}


def main() -> None:
    """Measures what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"of {', '.join(RUN)}")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="explorations of each case")
    parser.add_argument(
        "--trials", type=int, metavar="N", help="of each exploration; a section has its own default"
    )
    parser.add_argument("--small", action="store_true", help="as little as shows that a section runs")
    parser.add_argument("--output", type=Path, default=Path("exploration"), metavar="FOLDER")
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
