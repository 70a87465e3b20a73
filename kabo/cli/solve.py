"""`kabo solve`: finds a branched plan for a problem file, with a motion for every action."""

import argparse

from kabo.cli import rooms
from kabo.cli.argument_types import natural
from kabo.cli.solving import add_search_arguments, chosen_options, finish, has_geometry, report_cut_off
from kabo.cli.terminal import clean_standard_output, complain, interruptible

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
    try:
        with clean_standard_output(), interruptible() as stop:
            found = rooms.solve_file(
                options.problem,
                chosen_options(options),
                domain=options.domain,
                workers=max(1, options.workers),
                progress=options.surrounding.planning,
                cancelled=stop,
                on_found=options.surrounding.on_found(),
                on_refused=lambda body: options.surrounding.on_known(body, ""),
            )
    except KeyboardInterrupt:
        return _interrupted(options)
    if found.error is not None and not options.json:
        complain(str(found.error))
    return finish(found.body, found.plan, options)


def _interrupted(options: argparse.Namespace) -> int:
    """Reports that a second Ctrl-C ended the search at once: without a plan, and without a file."""
    return report_cut_off(options, "time", "interrupted by the user")
