"""`kabo explore show`: prints a summary of the trials of each case, or writes an HTML page with maps."""

import argparse

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import output_file
from kabo.cli.explore.arguments import add_model
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json, tell

NAME = "show"
HELP = "show the trials of each case: counts, ranges of outcomes, and maps of validity and outcomes"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explore show` to the parser."""
    add_model(parser)
    parser.add_argument("--html", type=output_file, metavar="OUT", help="write a self-contained HTML page")
    add_limits(parser)
    parser.add_argument("--json", action="store_true", help="print it as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Writes the page or prints a summary of each case, with --json both, and returns the exit code."""
    exploration = rooms.load_exploration(options.model)
    if options.html is not None:
        rooms.write_atomically(options.html, rooms.exploration_page(exploration, options.model).encode())
    if options.json:
        print_json(rooms.show_answer(exploration, options.model))
    elif options.html is None:
        print(rooms.describe_exploration(exploration, rooms.summaries_of(exploration)))
    else:
        tell(f"{options.html}: {rooms.counted(len(exploration.trials), 'trial')}")
    return exit_codes.DONE
