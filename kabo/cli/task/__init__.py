"""`kabo task`: plans a task file, shows tasks and what planning found, exports solutions, compares runs."""

import argparse

from kabo.cli.task import compare, export, plan, show, stages

NAME = "task"
HELP = "plan a task file, show its stages and what they found, export solutions, compare runs"
COMMANDS = (plan, show, export, compare, stages)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the subcommands of `kabo task` to the parser."""
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        own = commands.add_parser(command.NAME, help=command.HELP, description=command.HELP)
        command.add_arguments(own)
        own.set_defaults(run_task=command.run)


def run(options: argparse.Namespace) -> int:
    """Runs the chosen subcommand and returns its exit code."""
    return int(options.run_task(options))
