"""`kabo solve`: from a problem file to a branched plan with a motion for every action."""

import argparse

from kabo.cli.solving import add_search_arguments, chosen_options, finish, natural, told_cut_off
from kabo.cli.terminal import clean_standard_output, interruptible, tell

NAME = "solve"
HELP = "find a plan for a problem file, print it as a tree and write it as JSON"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `kabo solve`."""
    add_search_arguments(parser, NAME)
    parser.add_argument("--workers", type=natural, default=1, metavar="N", help="processes to use (default: 1)")


def run(options: argparse.Namespace) -> int:
    """Solves, shows the plan or why there is none, and writes the plan file only if there is one."""
    from kabo.requests import solve_file

    try:
        with clean_standard_output(), options.door.reporting() as report, interruptible() as stop:
            answer = solve_file(
                options.problem,
                chosen_options(options),
                domain=options.domain,
                workers=max(1, options.workers),
                progress=report,
                cancelled=stop,
                keep=options.door.keep(),
            )
    except KeyboardInterrupt:
        return _interrupted(options)
    if answer.error is not None and not options.json:
        tell(str(answer.error))
    return finish(answer.body, answer.plan, options)


def _interrupted(options: argparse.Namespace) -> int:
    """Ctrl-C for the second time ends a search at once: without a plan, and without a file."""
    return told_cut_off(options, "time", "interrupted by the user")
