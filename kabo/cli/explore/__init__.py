"""`kabo explore`: learns parameters by trying them, and gives those that have a wanted outcome [T ch. 4]."""

import argparse

from kabo.cli.explore import ask, infer, run_trials, show, tell

NAME = "explore"
HELP = "learn parameters by trying them, and ask for those that have a wanted outcome"
COMMANDS = (run_trials, ask, tell, infer, show)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the subcommands of `kabo explore` to the parser."""
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        own = commands.add_parser(command.NAME, help=command.HELP, description=command.HELP)
        command.add_arguments(own)
        own.set_defaults(run_explore=command.run)


def run(options: argparse.Namespace) -> int:
    """Runs the chosen subcommand and returns its exit code."""
    return int(options.run_explore(options))
