"""Terminal input and output of all commands: messages, Ctrl-C, standard output with the answer only.

Standard output carries the answer only (the plan's tree, or one JSON object); all else goes to standard error, through
the logger `kabo.cli`, so that `-q` silences it and `--log` keeps it.
"""

import json
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

ANSWER = 35  # the level of answers on standard error: -q shows them, and errors
logging.addLevelName(ANSWER, "ANSWER")
_LOG = logging.getLogger("kabo.cli")


def tell(text: str) -> None:
    """Prints a message on standard error; `-q` silences it."""
    _LOG.info("%s", text)


def warn(text: str) -> None:
    """Prints a warning on standard error; `-q` silences it."""
    _LOG.warning("%s", text)


def answer(text: str) -> None:
    """Prints what was asked for on standard error, such as the reason why there is no plan; `-q` does not silence it."""
    _LOG.log(ANSWER, "%s", text)


def complain(text: str) -> None:
    """Prints an error on standard error."""
    _LOG.error("%s", text)


def print_json(body: Mapping[str, Any]) -> None:
    """Prints the answer of a command as one JSON object, as `--json` requests it."""
    print(json.dumps(body, sort_keys=True, ensure_ascii=False, allow_nan=False))


class TerminalHandler(logging.Handler):
    """Prints records on standard error: kabo's own messages as they are, those of libraries after their logger."""

    def emit(self, record: logging.LogRecord) -> None:
        """Prints one record; nobody may be there to read it."""
        said = record.getMessage()
        try:
            print(said if record.name == _LOG.name else f"{record.name}: {said}", file=sys.stderr, flush=True)
        except BrokenPipeError:
            _discard(sys.stderr)
        except (OSError, ValueError, AttributeError):  # a full disk, or a closed file
            return


HANDLER = TerminalHandler(logging.INFO)
_LOG.addHandler(HANDLER)
_LOG.setLevel(logging.INFO)


def is_quiet() -> bool:
    """Whether messages are silenced."""
    return HANDLER.level > logging.WARNING


def open_missing_streams() -> None:
    """Gives a process that was started without standard output or error ones that lead nowhere.

    Otherwise the next file that is opened would take their place, and be written to.
    """
    for number, name in ((0, "stdin"), (1, "stdout"), (2, "stderr")):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDONLY if number == 0 else os.O_WRONLY)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "r" if number == 0 else "w", closefd=False))


def _discard(stream: Any) -> None:
    """Lets all further output of a stream, whose reader has gone, lead nowhere."""
    try:
        number = stream.fileno()
    except (OSError, ValueError, AttributeError):
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, number)
    os.close(nowhere)


def discard_output() -> None:
    """Lets standard output, whose reader has gone, lead nowhere."""
    _discard(sys.stdout)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """A context with a function that returns whether Ctrl-C was pressed; a second Ctrl-C aborts the command."""
    pressed: list[int] = []

    def note(number: int, frame: object) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)
        tell("kabo: ending with what there is so far; press Ctrl-C again to abort")

    try:
        before = signal.signal(signal.SIGINT, note)
    except ValueError:  # not the main thread
        yield lambda: False
        return
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def clean_standard_output() -> Iterator[None]:
    """A context in which everything that C and C++ libraries write to standard output goes to standard error."""
    try:
        out = sys.stdout.fileno()
    except (OSError, ValueError):  # a test captures standard output without a descriptor
        yield
        return
    sys.stdout.flush()
    kept = os.dup(out)
    os.dup2(2, out)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, out)
        os.close(kept)
