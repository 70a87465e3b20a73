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

MARGINS_TOLD = (
    "Displaced by less than these millimetres from a node on, bodies meet nothing that is not permitted: in any way (a",
    "turn counts as its angle times the body's radius), or along an axis of the world; + where more is not looked at.",
)


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
    parser.add_argument(
        "--margins",
        action="store_true",
        help="tell for each node how far each body may be displaced from there on, as the certificate proves",
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
        _require_motions(options)
        report = rooms.verify_file(
            options.problem,
            options.plan,
            domain=options.domain,
            knowledge_only=options.knowledge_only,
            paranoid=options.paranoid,
            start=options.after,
        )
    told = _margins(options, report) if options.margins and report.ok else None
    if options.json:
        print_json(report.to_dict() | ({} if told is None else {"margins": [each.to_dict() for each in told[1]]}))
    else:
        answer(f"{options.plan}: {report}".rstrip("\n"))
        if told is not None:
            answer("\n" + "\n".join([*MARGINS_TOLD, *rooms.table_of(*told)]))
    return exit_codes.DONE if report.ok else exit_codes.VERIFICATION_FAILED


def _margins(
    options: argparse.Namespace, report: "rooms.Report"
) -> "tuple[rooms.Margins, tuple[rooms.BodyMargin, ...]]":
    """What is proven of each body from each node on."""
    if report.certificate is None:
        message = f"{options.plan} has no certificate, and without one no margins are proven"
        raise InputError([Diagnostic("--margins", 1, 1, message, "solve without --no-certificate")])
    margins = rooms.Margins(rooms.load_plan(options.plan), report)
    return margins, rooms.body_margins(margins, [each.name for each in report.certificate.objects])


def _require_motions(options: argparse.Namespace) -> None:
    if options.margins and options.knowledge_only:
        message = "margins are of motions, which --knowledge-only leaves out"
        raise InputError([Diagnostic("--margins", 1, 1, message, "leave out one of both")])


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
