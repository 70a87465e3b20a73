"""`kabo explain`: why a problem has no plan, what would help, and what in it is of no use."""

import argparse

from kabo.cli import exit_codes
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_problem_argument, epsilon, natural
from kabo.cli.terminal import clean_standard_output, interruptible, print_json, tell
from kabo.errors import InputError
from kabo.options import SEARCHES

NAME = "explain"
HELP = "say why a problem has no plan, what one change would do, and what in it is of no use"

GIVEN = ("search", "seed", "epsilon", "max_expansions", "max_samples", "memory", "changes")
TELLING_S = 0.1  # of a time limit: for saying what was found
EXIT_CODES = {
    "solvable": exit_codes.DONE,
    "proved": exit_codes.PROVEN_NO_PLAN,
    "exhausted": exit_codes.NO_PLAN,
    "invalid": exit_codes.BAD_INPUT,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `kabo explain`."""
    add_problem_argument(parser)
    parser.add_argument("--search", choices=SEARCHES, help="how to search for a plan (default: best)")
    parser.add_argument("--seed", type=natural, metavar="N", help="of all random samples (default: 0)")
    parser.add_argument("--epsilon", type=epsilon, metavar="E", help="tolerance of geometric predicates in metres")
    parser.add_argument("--geometry", choices=("bounding", "none"), help="whether to look for motions, too")
    parser.add_argument("--max-expansions", type=natural, metavar="N", help="search nodes expanded at most")
    parser.add_argument("--max-samples", type=natural, metavar="N", help="samples of procedures at most")
    add_limits(parser, "60")
    parser.set_defaults(cut_off=_cut_off)
    parser.add_argument(
        "--changes", type=natural, metavar="N", help="changes tried at most to see whether they help (default: 6)"
    )
    parser.add_argument("--json", action="store_true", help="print the explanation as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the explanation; the exit codes are those of `solve`."""
    from kabo.imports import load_problem
    from kabo.planner.explaining import explain, explanation_to_json, invalid_explanation

    try:
        with clean_standard_output(), interruptible() as stop:
            problem = load_problem(options.problem, options.domain)
            given = {name: getattr(options, name) for name in GIVEN if getattr(options, name) is not None}
            if options.timeout is not None:
                given["timeout"] = max(0.0, options.door.left(options.timeout) - TELLING_S)
            found = explain(problem, geometry=options.geometry != "none", cancelled=stop, **given)
    except InputError as error:
        found = invalid_explanation(error)
        tell(str(error))
    if options.json:
        print_json(explanation_to_json(found))
    elif found.verdict != "invalid":
        print(found)
    return EXIT_CODES[found.verdict]


def _cut_off(options: argparse.Namespace, spent: str, message: str) -> int:
    """Shows that it was ended by force; the exit code."""
    said = f"Nothing is explained: {message}."
    if options.json:
        from kabo.planner.explaining import Explanation, explanation_to_json

        print_json(explanation_to_json(Explanation("exhausted", (said,))))
    else:
        print(said)
    return exit_codes.NO_PLAN
