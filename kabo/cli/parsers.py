"""The parser of the whole command line, made of those of the commands; and its help, in groups."""

import argparse
import shutil
import textwrap
from collections.abc import Sequence
from types import ModuleType
from typing import NoReturn

from kabo import __version__
from kabo.cli.completion.scripts import SHELLS, script
from kabo.cli.logs import add_logging
from kabo.cli.usage import CommandParser, commands_of

GROUPS: dict[str, tuple[str, ...]] = {
    "plans": ("solve", "verify", "explain"),
    "files": ("check", "generate", "robot", "bound", "decompose"),
    "to look at": ("view", "picture"),
    "tasks and trials": ("task", "explore"),
    "execution": ("execute", "replan", "simulate", "export"),
    "service": ("serve", "request"),
}
WIDEST, INDENT, OPTION_INDENT = 100, 13, 22  # columns of the help
COMPLETION = f"print a script for {', '.join(SHELLS)}: it completes commands, options and files"
END = "`kabo COMMAND --help` says more; the documentation is in docs/index.md."


class _TopParser(CommandParser):
    """The parser of `kabo`, whose help shows the commands in groups."""

    commands: Sequence[ModuleType] = ()

    def format_help(self) -> str:
        """The help of `kabo`."""
        width = min(WIDEST, shutil.get_terminal_size((80, 24)).columns)
        lines = ["usage: kabo COMMAND …", "", *textwrap.wrap(self.description or "", width), ""]
        helps = {command.NAME: command.HELP for command in self.commands}
        named = {name for names in GROUPS.values() for name in names}
        for title, names in {**GROUPS, "more": tuple(name for name in helps if name not in named)}.items():
            rows = [row for name in names if name in helps for row in _rows(name, helps[name], width)]
            lines += [f"{title}:", *rows, ""] if rows else []
        lines.append("options:")
        for action in self._actions:
            if action.option_strings:
                words = ", ".join(action.option_strings) + (f" {action.metavar}" if action.metavar else "")
                lines += _rows(words, action.help or "", width, OPTION_INDENT)
        return "\n".join([*lines, "", END, ""])


def _rows(name: str, text: str, width: int, indent: int = INDENT) -> list[str]:
    rows = textwrap.wrap(text, max(20, width - indent))
    first = f"  {name}"
    if len(first) >= indent:
        return [first, *(" " * indent + row for row in rows)]
    return [first.ljust(indent) + rows[0], *(" " * indent + row for row in rows[1:])]


class _Completion(argparse.Action):
    """`--completion`: prints a script and ends, as `--version` does."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option: str | None = None,
    ) -> NoReturn:
        print(script(parser, str(values)), end="")
        parser.exit()


def command_line(commands: Sequence[ModuleType]) -> CommandParser:
    """The parser of the command line; the attribute `run` of its result is the function that runs the command."""
    top = _TopParser(
        prog="kabo",
        description="Combined task and motion planning on the knowledge level, with bounded geometric predicates.",
    )
    top.add_argument(
        "--version", action="version", version=f"kabo {__version__}", help="print the version of kabo"
    )
    top.add_argument("--completion", action=_Completion, choices=SHELLS, metavar="SHELL", help=COMPLETION)
    add_logging(top, top=True)
    top.commands = commands
    _add_commands(top, commands)
    return top


def _add_commands(top: argparse.ArgumentParser, commands: Sequence[ModuleType]) -> None:
    names = top.add_subparsers(metavar="COMMAND", required=True, parser_class=CommandParser)
    for command in commands:
        own = names.add_parser(command.NAME, help=command.HELP, description=command.HELP)
        command.add_arguments(own)
        for last in commands_of(own).values() or [own]:
            add_logging(last)
        own.set_defaults(run=command.run)
