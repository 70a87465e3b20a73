"""`kabo task compare`: shows two reports stage by stage, and marks statistically significant differences."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json

NAME = "compare"
HELP = "compare two reports of runs: calls, seconds, costs and failures of every stage"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo task compare` to the parser."""
    parser.add_argument("first", type=Path, metavar="A.json", help="a report of `kabo task plan --repeat N -o`")
    parser.add_argument("second", type=Path, metavar="B.json", help="another one")
    parser.add_argument("--json", action="store_true", help="print the comparison as one JSON object")
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Prints the comparison and returns the exit code."""
    first, second = (rooms.read_report(path.read_bytes(), str(path)) for path in (options.first, options.second))
    found = rooms.compare(first, second)
    if options.json:
        print_json(found)
    else:
        print(rooms.describe_comparison(found))
    return exit_codes.DONE
