"""`-v`, `-q` and `--log`: what is told on standard error, and what is kept in a file.

The rooms of kabo log to `kabo.<room>` of Python's `logging`, and add no handlers; a program that uses kabo as a library
decides itself what comes of it. Here the command line decides.
"""

import argparse
import json
import logging
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime, timezone
from pathlib import Path

from kabo import __version__
from kabo.cli.argument_types import output_file
from kabo.cli.terminal import ANSWER, HANDLER, warn
from kabo.errors import Diagnostic, InputError

ROOMS, OWN = "kabo", "kabo.cli"
FIRST_BYTES = 64  # of a file, by which a log is known


def add_logging(parser: argparse.ArgumentParser, *, top: bool = False) -> None:
    """Adds `-v`, `-q` and `--log`, which may stand before the name of a command (`top`) and after it."""
    group = parser.add_argument_group("messages")
    absent = None if top else argparse.SUPPRESS
    group.add_argument(
        "-v",
        "--verbose",
        action="count",
        default=absent,
        help="tell the phases with their seconds; twice (-vv): files read, refusals, cache hits, too",
    )
    group.add_argument(
        "-q",
        "--quiet",
        action="store_true",
        default=False if top else argparse.SUPPRESS,
        help="tell nothing but the answer and errors",
    )
    group.add_argument(
        "--log",
        type=output_file,
        default=absent,
        metavar="FILE",
        help="append all messages to a file, a line of JSON each",
    )


@contextmanager
def logging_as(options: argparse.Namespace) -> Iterator[None]:
    """A context in which messages are told and kept as the options say.

    Raises:
        InputError: the log cannot be written.
    """
    _require_apart(options)
    rooms, own = logging.getLogger(ROOMS), logging.getLogger(OWN)
    before = rooms.level, own.level, HANDLER.level
    added: list[logging.Handler] = []
    if getattr(options, "log", None) is not None:
        added.append(_FileHandler(options.log))
        rooms.setLevel(logging.DEBUG)
        own.setLevel(logging.DEBUG)
    verbose = getattr(options, "verbose", None) or 0
    if verbose:
        added.append(_Details(logging.INFO if verbose == 1 else logging.DEBUG))
        rooms.setLevel(logging.DEBUG if verbose > 1 or len(added) > 1 else logging.INFO)
    if getattr(options, "quiet", False):
        HANDLER.setLevel(ANSWER)
    for handler in added:
        rooms.addHandler(handler)
    try:
        own.debug("kabo %s", __version__, extra={"fields": {"version": __version__, "arguments": sys.argv[1:]}})
        yield
    finally:
        for handler in added:
            rooms.removeHandler(handler)
            handler.close()
        rooms.setLevel(before[0])
        own.setLevel(before[1])
        HANDLER.setLevel(before[2])


def log_into(path: Path) -> None:
    """Keeps what this process logs in a file, until it ends; another process does, too, and has found it usable."""
    with suppress(InputError):  # it can no longer be written, which is no reason not to work
        logging.getLogger(ROOMS).addHandler(_FileHandler(path))
        logging.getLogger(ROOMS).setLevel(logging.DEBUG)


class _Details(logging.Handler):
    """Tells what the rooms log; what the command line itself tells, another handler prints."""

    def emit(self, record: logging.LogRecord) -> None:
        """Tells one record."""
        if record.name != OWN:
            HANDLER.emit(record)


class _FileHandler(logging.Handler):
    """Appends each record as a whole line at once: processes can share the file, and none is ever written by half."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o666)
            self._is_file = stat.S_ISREG(os.fstat(self._file).st_mode)
            foreign = self._is_file and not _is_log(os.pread(self._file, FIRST_BYTES, 0))
        except OSError as error:
            raise _unusable(path, f"the log cannot be written: {error.strerror}") from None
        if foreign:
            raise _unusable(path, "there is such a file already, and it is no log of kabo")

    def emit(self, record: logging.LogRecord) -> None:
        """Writes one record; after the first that cannot be written, whole, no more."""
        if self._file < 0:
            return
        line = json.dumps(logged(record), ensure_ascii=False, default=str).encode("utf-8", "replace") + b"\n"
        begin = os.lseek(self._file, 0, os.SEEK_END) if self._is_file else None
        try:
            written, why = os.write(self._file, line), "no space left"
        except OSError as error:
            written, why = 0, error.strerror or str(error)
        if written == len(line):
            return
        if written and begin is not None:
            os.ftruncate(self._file, begin)  # a disk that is full takes half a line
        self.close()
        if begin == 0:
            raise _unusable(self._path, f"the log cannot be written: {why}")
        warn(f"kabo: {self._path}: the log ends here: {why}")

    def close(self) -> None:
        """Closes the file."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
        super().close()


def _require_apart(options: argparse.Namespace) -> None:
    """Raises InputError if the log is a file that the command writes or reads, too."""
    log = getattr(options, "log", None)
    if log is None:
        return
    for name, value in vars(options).items():
        if name != "log" and isinstance(value, Path) and value.resolve() == log.resolve():
            raise _unusable(log, "the log cannot be a file that the command itself reads or writes")


def _unusable(path: Path, message: str) -> InputError:
    return InputError([Diagnostic(str(path), 1, 1, message, "name another file to write")])


def _is_log(begin: bytes) -> bool:
    """Whether a file that begins like this is empty or a log: nothing else is appended to."""
    return not begin or begin.startswith(b'{"time": "')


def logged(record: logging.LogRecord) -> dict[str, object]:
    """A record as it stands in a log: time (UTC), level, logger, message, and its fields, if it has any."""
    time = datetime.fromtimestamp(record.created, timezone.utc).isoformat(timespec="milliseconds")
    return {
        "time": time.replace("+00:00", "Z"),
        "level": record.levelname.lower(),
        "logger": record.name,
        "message": record.getMessage(),
        "fields": getattr(record, "fields", {}),
    }
