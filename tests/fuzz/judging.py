"""What a reader may do with a file: take it, or refuse it with findings that have a place; soon, in little memory."""

import io
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass

from kabo.errors import InputError, KaboError

SECONDS = 10.0  # of processor time, for one file
MEGABYTES = 400  # that the process may grow by, for one file


@dataclass(frozen=True)
class Find:
    """A file that was not read as files should be: its format, its number there, and what happened."""

    format: str
    number: int
    what: str

    def __str__(self) -> str:
        return f"{self.format} {self.number}: {self.what}"


class TooLong(BaseException):
    """The file takes longer than files may."""


@contextmanager
def limited(seconds: float = SECONDS) -> Iterator[None]:
    """Ends what runs longer than so many seconds of processor time."""

    def ring(*_: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def judged(read: Callable[[], object], *, seconds: float = SECONDS) -> str | None:
    """What is wrong with how a file is read; None if it is read or refused as files should be."""
    said = io.StringIO()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wrong = None
    try:
        with limited(seconds), warnings.catch_warnings(), redirect_stdout(said), redirect_stderr(said):
            warnings.simplefilter("error", RuntimeWarning)
            read()
    except InputError as error:
        wrong = _of_findings(error)
    except KaboError as error:
        wrong = f"a defect, says {type(error).__name__}: {error}"
    except TooLong:
        wrong = f"took more than {seconds:g} s of processor time"
    except Exception as error:  # noqa: BLE001  that is what is looked for
        wrong = _last_lines(error)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    if wrong is None and grown > MEGABYTES:
        wrong = f"took {grown:.0f} MB"
    return wrong


def _of_findings(error: InputError) -> str | None:
    if not error.diagnostics:
        return "refused without a finding"
    for finding in error.diagnostics:
        if not finding.file or finding.line < 1 or finding.column < 1 or finding.length < 1:
            return f"a finding without a place: {finding!r}"
        if finding.file in {"mesh", "scene"}:
            return f"a finding without a file: {finding!r}"
        if not finding.message.strip() or "Traceback" in finding.message or len(finding.message) > 1500:
            return f"a finding that says nothing, or too much: {finding.message[:300]!r}"
    return None


def _last_lines(error: Exception) -> str:
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "/kabo/" in frame.filename]
    place = own[-1] if own else frames[-1]
    where = f"{place.filename.rsplit('/kabo/', 1)[-1]}:{place.lineno}"
    return f"{type(error).__name__} in {where}: {' '.join(str(error).split())[:200]}"


def seconds_used() -> float:
    """Processor time of this process."""
    return time.process_time()


def tell(text: str) -> None:
    """A line for who runs this by hand."""
    print(text, file=sys.stderr, flush=True)
