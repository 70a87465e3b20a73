"""`kabo explain`: says why a problem has no plan, which changes would help, and which parts of it are useless."""

import argparse
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_options, add_problem_argument, chosen_options, has_geometry
from kabo.cli.terminal import clean_standard_output, interruptible, print_json, tell

NAME = "explain"
HELP = "say why a problem has no plan, what one change would do, and what in it is of no use"

MAX_SAMPLES = 40_000  # as in kabo.explain: samples, if neither the command line nor the problem limits them
REPORT_S = 0.1  # seconds of the time limit that are kept for writing the explanation
EXIT_CODES = {
    "solvable": exit_codes.DONE,
    "proved": exit_codes.PROVEN_NO_PLAN,
    "exhausted": exit_codes.NO_PLAN,
    "invalid": exit_codes.BAD_INPUT,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explain` to the parser."""
    add_problem_argument(parser)
    add_options(parser, NAME, max_samples=MAX_SAMPLES)
    parser.add_argument("--geometry", choices=("bounding", "none"), help="whether to look for motions, too")
    add_limits(parser, "60")
    parser.set_defaults(cut_off=_cut_off, needs_kernels=has_geometry)
    parser.add_argument(
        "--changes", type=natural, metavar="N", help="changes tried at most to see whether they help (default: 6)"
    )
    parser.add_argument("--json", action="store_true", help="print the explanation as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the explanation and returns an exit code with the same meaning as that of `kabo solve`."""
    given: dict[str, Any] = {**chosen_options(options)}
    given["geometry"] = options.geometry != "none"
    if options.changes is not None:
        given["changes"] = options.changes
    with clean_standard_output(), options.surrounding.reporting() as report, interruptible() as stop:
        if options.timeout is not None:
            given["timeout"] = max(0.0, given["timeout"] - REPORT_S)
        found, error = rooms.explain_file(
            options.problem, domain=options.domain, cancelled=stop, progress=report, **given
        )
    if error is not None:
        tell(str(error))
    if options.json:
        print_json(rooms.explanation_to_json(found))
    elif found.verdict != "invalid":
        print(found)
    return EXIT_CODES[found.verdict]


def _cut_off(options: argparse.Namespace, spent: str, message: str) -> int:
    """Reports that the command was ended by force, and returns the exit code."""
    said = f"Nothing is explained: {message}."
    if options.json:
        print_json(rooms.explanation_to_json(rooms.Explanation("exhausted", (said,))))
    else:
        print(said)
    return exit_codes.NO_PLAN
