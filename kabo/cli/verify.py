"""`kabo verify`: checks, without the planner's code, that a plan file is valid for its problem."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import whole
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_problem_argument
from kabo.cli.terminal import answer, clean_standard_output, print_json
from kabo.errors import Diagnostic, InputError

NAME = "verify"
HELP = "replay a plan over every branch and check every motion against the original meshes; or a task's solutions"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo verify` to the parser."""
    add_problem_argument(parser)
    plan = "the plan file; or a report of `kabo task plan -o`, with its scene file as PROBLEM"
    parser.add_argument("plan", type=Path, metavar="PLAN", help=plan)
    parser.add_argument(
        "--solution", type=whole(1), metavar="N", help="of a report: verify only this solution (default: all)"
    )
    parser.add_argument(
        "--knowledge-only", action="store_true", help="check only what is known when, and no motions"
    )
    parser.add_argument(
        "--after",
        type=Path,
        metavar="STATE",
        help="the file of the state of a run in which the plan is to begin (default: where the plan says)",
    )
    parser.add_argument("--paranoid", action="store_true", help="check the plan's certificate in exact arithmetic")
    parser.add_argument("--json", action="store_true", help="print the report as one JSON object")
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Prints the report and returns the exit code: 5 if the verification found a fault in the plan."""
    with clean_standard_output():
        if rooms.is_report(options.plan):
            return _verify_report(options)
        _require_report(options)
        report = rooms.verify_file(
            options.problem,
            options.plan,
            domain=options.domain,
            knowledge_only=options.knowledge_only,
            paranoid=options.paranoid,
            start=options.after,
        )
    if options.json:
        print_json(report.to_dict())
    else:
        answer(f"{options.plan}: {report}".rstrip("\n"))
    return exit_codes.DONE if report.ok else exit_codes.VERIFICATION_FAILED


def _verify_report(options: argparse.Namespace) -> int:
    """Verifies the solutions of a task's report, each by itself."""
    if options.knowledge_only:
        message = "a report of a task has no knowledge, only motions"
        raise InputError([Diagnostic("--knowledge-only", 1, 1, message, "leave it out")])
    found = []
    for number, report in rooms.verify_task_report(
        options.problem, options.plan, options.solution, paranoid=options.paranoid
    ):
        found.append((number, report))
        if not options.json:
            answer(f"{options.plan}, solution {number}: {report}".rstrip("\n"))
    ok = all(report.ok for _, report in found)
    if options.json:
        told = [{"solution": number, **report.to_dict()} for number, report in found]
        print_json({"verified": ok, "solutions": told})
    return exit_codes.DONE if ok else exit_codes.VERIFICATION_FAILED


def _require_report(options: argparse.Namespace) -> None:
    if options.solution is not None:
        message = f"{options.plan} is no report of a task: it has no solutions to choose from"
        raise InputError([Diagnostic("--solution", 1, 1, message, "leave it out")])
