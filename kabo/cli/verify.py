"""`kabo verify`: checks, without the planner's code, that a plan file is valid for its problem."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_problem_argument
from kabo.cli.terminal import answer, clean_standard_output, print_json

NAME = "verify"
HELP = "replay a plan over every branch and check every motion against the original meshes"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo verify` to the parser."""
    add_problem_argument(parser)
    parser.add_argument("plan", type=Path, metavar="PLAN", help="the plan file")
    parser.add_argument(
        "--knowledge-only", action="store_true", help="check only what is known when, and no motions"
    )
    parser.add_argument("--paranoid", action="store_true", help="check the plan's certificate in exact arithmetic")
    parser.add_argument("--json", action="store_true", help="print the report as one JSON object")
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Prints the report and returns the exit code: 5 if the verification found a fault in the plan."""
    with clean_standard_output():
        report = rooms.verify_file(
            options.problem,
            options.plan,
            domain=options.domain,
            knowledge_only=options.knowledge_only,
            paranoid=options.paranoid,
        )
    if options.json:
        print_json(report.to_dict())
    else:
        answer(f"{options.plan}: {report}".rstrip("\n"))
    return exit_codes.DONE if report.ok else exit_codes.VERIFICATION_FAILED
