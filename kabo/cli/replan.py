"""`kabo replan`: finds a plan from the state that a run has come to, beginning with the rest of the former plan."""

import argparse
from pathlib import Path

from kabo.cli import rooms
from kabo.cli.solving import add_search_arguments, chosen_options, finish, has_geometry, report_cut_off
from kabo.cli.terminal import clean_standard_output, complain, interruptible

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
    try:
        with clean_standard_output(), interruptible() as stop:
            found = rooms.solve_file(
                options.problem,
                chosen_options(options),
                domain=options.domain,
                progress=options.surrounding.planning,
                cancelled=stop,
                on_found=options.surrounding.on_found(),
                on_refused=lambda body: options.surrounding.on_known(body, ""),
                start=options.after,
                former=options.plan,
            )
    except KeyboardInterrupt:
        return report_cut_off(options, "time", "interrupted by the user")
    if found.error is not None and not options.json:
        complain(str(found.error))
    return finish(found.body, found.plan, options)
