"""The entry of `kabo`: chooses the command, and turns every error into an exit code."""

import argparse
import json
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType

from kabo import __version__
from kabo.cli import (
    check,
    execute,
    exit_codes,
    explain,
    explore,
    export,
    generate,
    motion,
    picture,
    replan,
    robot,
    simulate,
    solve,
    task,
    verify,
    view,
)
from kabo.cli.argument_types import require_apart, require_writable
from kabo.cli.logs import logging_as
from kabo.cli.mesh import bound, decompose
from kabo.cli.parsers import command_line
from kabo.cli.service import request, serve
from kabo.cli.terminal import complain, discard_output, open_missing_streams
from kabo.cli.usage import CommandParser, UsageError, parsed
from kabo.errors import CutOff, InputError, KaboError, ServiceError, missing_library
from kabo.given import missing_file

COMMANDS: tuple[ModuleType, ...] = (
    solve,
    verify,
    explain,
    check,
    view,
    picture,
    generate,
    motion,
    task,
    explore,
    execute,
    replan,
    simulate,
    export,
    bound,
    decompose,
    robot,
    serve,
    request,
)
OUTPUT_OPTIONS = (
    "output",
    "html",
    "page",
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
    open_missing_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        options = parsed(parser(), given)
    except UsageError as error:
        complain(str(error))
        if _asks_for_json(given):
            print(json.dumps({"code": "bad_request", "message": str(error)}))
        raise SystemExit(exit_codes.BAD_INPUT) from None
    # There is no end that could be waited for, or told of:
    serves = bool(getattr(options, "follow", None) or getattr(options, "serve", False))
    apart = arguments is None and hasattr(options, "surrounding") and hasattr(os, "fork") and not serves

    def run(options: argparse.Namespace) -> int:
        with logging_as(options):
            if not apart:
                return _work(options)
            from kabo.cli.waiting.watch import limited  # a quarter of the time that --help takes

            return limited(options, lambda each: _ended(each, _work))

    return _ended(options, run)


def _work(options: argparse.Namespace) -> int:
    require_apart(options, OUTPUT_OPTIONS)
    for name in OUTPUT_OPTIONS:
        if (path := getattr(options, name, None)) is not None:
            require_writable(path)
    return int(options.run(options))


def _ended(options: argparse.Namespace, run: Callable[[argparse.Namespace], int]) -> int:
    """Calls a function that runs a command, turns its errors into messages, and returns the exit code."""
    try:
        return run(options)
    except KeyboardInterrupt:
        complain("kabo: interrupted; nothing was written")
        return exit_codes.INTERRUPTED
    except BrokenPipeError:  # the reader of our output has gone, as in `kabo solve … | head`
        discard_output()
        return exit_codes.DONE
    except Exception as error:  # noqa: BLE001 - the outer edge
        return _report(error, as_json=getattr(options, "json", False))


def _asks_for_json(given: Sequence[str]) -> bool:
    before = given[: given.index("--")] if "--" in given else given
    return any(len(word) > len("--") and "--json".startswith(word) for word in before)


def parser() -> CommandParser:
    """The parser of the command line; the attribute `run` of its result is the function that runs the command."""
    return command_line(COMMANDS)


def _report(error: Exception, *, as_json: bool) -> int:
    """Reports an error on standard error and, with --json, as one object `{code, message}`; returns the exit code."""
    if isinstance(error, InputError):
        code, message, exit_code = "bad_request", str(error), exit_codes.BAD_INPUT
    elif isinstance(error, ServiceError):
        code, message, exit_code = error.code, str(error), exit_codes.BY_CODE.get(error.code, exit_codes.SERVICE)
    elif isinstance(error, FileNotFoundError) and error.filename is not None:
        code, message, exit_code = "bad_request", str(missing_file(Path(error.filename))), exit_codes.BAD_INPUT
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
        complain("".join(traceback.format_exception(error)).rstrip("\n"))
        complain(f"kabo: a defect of kabo {__version__}; {REPORT}")
    complain(message if isinstance(error, InputError | FileNotFoundError) else f"kabo: {message}")
    if as_json:
        print(json.dumps({"code": code, "message": message}))
    return exit_code
