"""`kabo replan`: finds a plan from the state that a run has come to, beginning with the rest of the former plan."""

import argparse
from pathlib import Path

from kabo.cli.solving import add_search_arguments, has_geometry, solve_and_finish

NAME = "replan"
HELP = "find a plan from the state that a run has come to; the rest of the former plan is tried first"
OUTPUT = Path("replanned.json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo replan` to the parser."""
    add_search_arguments(parser, "solve")
    parser.set_defaults(needs_kernels=has_geometry, output=OUTPUT)
    parser.add_argument("plan", type=Path, metavar="PLAN", help="the former plan")
    parser.add_argument(
        "--after",
        type=Path,
        required=True,
        metavar="STATE",
        help="the file of the state, as `kabo execute --state` writes it",
    )


def run(options: argparse.Namespace) -> int:
    """Solves the problem from the state, prints the plan or why there is none, and writes the plan file."""
    return solve_and_finish(options, start=options.after, former=options.plan)
