"""The entry of `kabo`: chooses the command, and is the outer edge where every error becomes an exit code."""

import argparse
import json
import os
import sys
import traceback
from collections.abc import Sequence
from types import ModuleType
from typing import NoReturn

from kabo import __version__
from kabo.cli import bound, check, decompose, exit_codes, explain, generate, request, serve, solve, task, verify
from kabo.cli.limits import limited
from kabo.cli.solving import require_writable
from kabo.errors import CutOff, InputError, KaboError, ServiceError, missing_library

COMMANDS: tuple[ModuleType, ...] = (
    solve,
    verify,
    explain,
    check,
    generate,
    task,
    bound,
    decompose,
    serve,
    request,
)
WRITTEN = ("output", "html", "picture")  # options that name a file to write: better found out before the work
REPORT = "please report it with this text and the files: it is a defect of kabo, not of your input"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code.

    Args:
        arguments: None: those of the process, as a program; a command with limits then runs in a child process, where
            it can be ended. Else it runs in this one, and ends where it looks at its limits.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        options = _parsed(given)
    except _Wrong as wrong:
        wrong.parser.print_usage(sys.stderr)
        print(f"{wrong.parser.prog}: error: {wrong}", file=sys.stderr)
        if _asks_for_json(given):
            print(json.dumps({"code": "bad_request", "message": str(wrong)}))
        raise SystemExit(exit_codes.BAD_INPUT) from None
    if arguments is None and hasattr(options, "door") and hasattr(os, "fork"):
        return limited(options, _in_this_process)
    return _in_this_process(options)


def _parsed(given: Sequence[str]) -> argparse.Namespace:
    top = parser()
    if any("\0" in word for word in given):  # no shell gives one, but a program may: no path can have it
        top.error("an argument holds a null character")
    return top.parse_args(given)


def _in_this_process(options: argparse.Namespace) -> int:
    """Runs a command; errors are told on standard error, in one place."""
    try:
        for name in WRITTEN:
            if (path := getattr(options, name, None)) is not None:
                require_writable(path)
        return int(options.run(options))
    except KeyboardInterrupt:
        print("kabo: interrupted; nothing was written", file=sys.stderr)
        return exit_codes.INTERRUPTED
    except BrokenPipeError:  # the reader of our output has gone, as in `kabo solve … | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return exit_codes.DONE
    except Exception as error:  # noqa: BLE001 - the outer edge
        return _told(error, as_json=getattr(options, "json", False))


class _Wrong(Exception):  # noqa: N818
    """Options that cannot be understood; the parser that says so shows its usage."""

    def __init__(self, parser: argparse.ArgumentParser, message: str) -> None:
        self.parser = parser
        super().__init__(message)


class _Parser(argparse.ArgumentParser):
    """A parser that leaves it to `main` to tell what is wrong, which knows about `--json`."""

    def error(self, message: str) -> NoReturn:
        """Raises _Wrong."""
        raise _Wrong(self, message)


def _asks_for_json(given: Sequence[str]) -> bool:
    before = given[: given.index("--")] if "--" in given else given
    return any(len(word) > len("--") and "--json".startswith(word) for word in before)


def parser() -> argparse.ArgumentParser:
    """The command line as argparse sees it; `run` of the parsed options is the command."""
    top = _Parser(
        prog="kabo",
        description="Combined task and motion planning on the knowledge level, with bounded geometric predicates.",
    )
    top.add_argument("--version", action="version", version=f"kabo {__version__}")
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        own = commands.add_parser(command.NAME, help=command.HELP, description=command.HELP)
        command.add_arguments(own)
        own.set_defaults(run=command.run)
    return top


def _told(error: Exception, *, as_json: bool) -> int:
    """Says what went wrong to people and (with --json) as one object `{code, message}`; returns the exit code."""
    if isinstance(error, InputError):
        code, message, exit_code = "bad_request", str(error), exit_codes.BAD_INPUT
    elif isinstance(error, ServiceError):
        code, message, exit_code = error.code, str(error), exit_codes.BY_CODE.get(error.code, exit_codes.SERVICE)
    elif isinstance(error, OSError) and error.filename is not None:
        code, message, exit_code = "bad_request", f"{error.filename}: {error.strerror}", exit_codes.BAD_INPUT
    elif (remedy := missing_library(error)) is not None:
        code, message, exit_code = "failed", remedy, exit_codes.DEFECT
    elif isinstance(error, CutOff):
        code, message, exit_code = "cut_off", str(error), exit_codes.NO_PLAN
    elif isinstance(error, KaboError):
        code, message, exit_code = "failed", str(error), exit_codes.DEFECT
    else:
        code, message, exit_code = "failed", f"{type(error).__name__}: {error}", exit_codes.DEFECT
        print("".join(traceback.format_exception(error)), file=sys.stderr, end="")
        print(f"kabo: a defect of kabo {__version__}; {REPORT}", file=sys.stderr)
    print(message if isinstance(error, InputError) else f"kabo: {message}", file=sys.stderr)
    if as_json:
        print(json.dumps({"code": code, "message": message}))
    return exit_code
