"""`kabo solve`: from a problem file to a branched plan with a motion for every action."""

import argparse

from kabo.cli import exit_codes
from kabo.cli.solving import add_search_arguments, chosen_options, finish, natural
from kabo.cli.terminal import clean_standard_output, print_json, shown_progress, tell

NAME = "solve"
HELP = "find a plan for a problem file, print it as a tree and write it as JSON"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `kabo solve`."""
    add_search_arguments(parser)
    parser.add_argument("--workers", type=natural, default=1, metavar="N", help="processes to use (default: 1)")


def run(options: argparse.Namespace) -> int:
    """Solves, shows the plan or why there is none, and writes the plan file only if there is one."""
    from kabo.service import SolveOptions, solve_file

    chosen = SolveOptions(**chosen_options(options))
    try:
        with clean_standard_output(), shown_progress() as report:
            answer = solve_file(
                options.problem, chosen, domain=options.domain, workers=max(1, options.workers), progress=report
            )
    except KeyboardInterrupt:
        return _interrupted(options)
    if answer.error is not None and not options.json:
        tell(str(answer.error))
    return finish(answer.body, answer.plan, options)


def _interrupted(options: argparse.Namespace) -> int:
    """Ctrl-C ends a search as a time limit does: without a plan, and without a file."""
    from kabo.planner.result import Reason, Result, result_to_json

    reason = Reason(None, "time", "interrupted by the user; no file was written")
    if options.json:
        print_json(result_to_json(Result("exhausted", None, {}, reason)))
    tell(f"kabo: {reason.message}")
    return exit_codes.NO_PLAN
