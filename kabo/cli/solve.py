"""`kabo solve`: finds a branched plan for a problem file, with a motion for every action."""

import argparse

from kabo.cli.argument_types import natural
from kabo.cli.solving import add_search_arguments, has_geometry, solve_and_finish

NAME = "solve"
HELP = "find a plan for a problem file, print it as a tree and write it as JSON"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo solve` to the parser."""
    add_search_arguments(parser, NAME)
    parser.set_defaults(needs_kernels=has_geometry)
    parser.add_argument(
        "--workers",
        type=natural,
        default=1,
        metavar="N",
        help="processes; the plan does not depend on their number (default: 1)",
    )


def run(options: argparse.Namespace) -> int:
    """Solves the problem, prints the plan or why there is none, and writes the plan file if there is one."""
    return solve_and_finish(options, workers=max(1, options.workers))
