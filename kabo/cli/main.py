"""The entry of `kabo`: chooses the command, and turns every error into an exit code."""

import argparse
import json
import os
import sys
import traceback
from collections.abc import Sequence
from types import ModuleType
from typing import NoReturn

from kabo import __version__
from kabo.cli import (
    bound,
    check,
    decompose,
    exit_codes,
    explain,
    explore,
    generate,
    request,
    robot,
    serve,
    solve,
    task,
    verify,
    view,
)
from kabo.cli.argument_types import require_writable
from kabo.cli.limits import limited
from kabo.errors import CutOff, InputError, KaboError, ServiceError, missing_library

COMMANDS: tuple[ModuleType, ...] = (
    solve,
    verify,
    explain,
    check,
    view,
    generate,
    task,
    explore,
    bound,
    decompose,
    robot,
    serve,
    request,
)
OUTPUT_OPTIONS = (
    "output",
    "html",
    "picture",
)  # name files to write; whether that works is tried before the command runs
REPORT = "please report it with this text and the files: it is a defect of kabo, not of your input"


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code.

    Args:
        arguments: the arguments of the command. If None, they are those of this process, and a command with limits
            runs in a child process, which can be killed at its limits. If given, the command runs in this process
            and stops only when it checks its limits itself.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        options = _parsed(given)
    except _UsageError as error:
        error.parser.print_usage(sys.stderr)
        print(f"{error.parser.prog}: error: {error}", file=sys.stderr)
        if _asks_for_json(given):
            print(json.dumps({"code": "bad_request", "message": str(error)}))
        raise SystemExit(exit_codes.BAD_INPUT) from None
    if arguments is None and hasattr(options, "surrounding") and hasattr(os, "fork"):
        return limited(options, _in_this_process)
    return _in_this_process(options)


def _parsed(given: Sequence[str]) -> argparse.Namespace:
    top = parser()
    if any("\0" in word for word in given):  # no shell gives one, but a program may: no path can have it
        top.error("an argument holds a null character")
    return top.parse_args(given)


def _in_this_process(options: argparse.Namespace) -> int:
    """Runs a command and reports its errors on standard error."""
    try:
        for name in OUTPUT_OPTIONS:
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
        return _report(error, as_json=getattr(options, "json", False))


class _UsageError(Exception):
    """Arguments that cannot be read; `parser` is the one whose usage is shown."""

    def __init__(self, parser: argparse.ArgumentParser, message: str) -> None:
        self.parser = parser
        super().__init__(message)


class _CommandParser(argparse.ArgumentParser):
    """A parser that raises its errors, so that `main` reports them, as JSON where that is asked for."""

    def error(self, message: str) -> NoReturn:
        """Raises _UsageError."""
        raise _UsageError(self, message)


def _asks_for_json(given: Sequence[str]) -> bool:
    before = given[: given.index("--")] if "--" in given else given
    return any(len(word) > len("--") and "--json".startswith(word) for word in before)


def parser() -> argparse.ArgumentParser:
    """The parser of the command line; the attribute `run` of its result is the function that runs the command."""
    top = _CommandParser(
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


def _report(error: Exception, *, as_json: bool) -> int:
    """Reports an error on standard error and, with --json, as one object `{code, message}`; returns the exit code."""
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
