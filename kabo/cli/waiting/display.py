"""Shows on standard error what a command does: one row that is drawn anew on a terminal, lines every ten seconds else."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread
from time import perf_counter

from kabo.cli.terminal import is_quiet
from kabo.cli.waiting.doing import RESTING, Doing
from kabo.cli.waiting.lines import Estimate, Style, barred, piped

FIRST_S, DRAWN_EVERY_S = 1.0, 0.1  # on a terminal: quick commands show nothing
LINE_EVERY_S = 10.0  # elsewhere
ERASED = "\r\x1b[K"
WORKING = Doing("working", "loading")


class Display:
    """Shows what is done; `tick` is to be called often, and draws when it is time to.

    Args:
        began: when the command began, on the clock of `perf_counter` [s].
    """

    def __init__(self, began: float) -> None:
        self.began, self.doing = began, WORKING
        self.row = draws_rows()  # else lines
        self._estimate = Estimate()
        self._next = began + (FIRST_S if self.row else LINE_EVERY_S)
        self._drawn, self._turn, self._silent = False, 0, is_quiet()

    def show(self, doing: Doing) -> None:
        """Notes what is done now."""
        self.doing = doing
        if doing == RESTING:
            self.erase()
        self._estimate.left(doing, perf_counter())

    def tick(self) -> None:
        """Draws, if it is time to."""
        now = perf_counter()
        if now < self._next or self._silent or self.doing == RESTING:
            return
        left = self._estimate.left(self.doing, now)
        if self.row:
            self._next, self._turn = now + DRAWN_EVERY_S, self._turn + 1
            share = self.doing.share(self.began, now)
            self._write(ERASED + barred(self.doing, share, now - self.began, left, _style(), self._turn))
            self._drawn = True
        else:
            self._next += LINE_EVERY_S * (1 + (now - self._next) // LINE_EVERY_S)
            self._write(piped(self.doing, now - self.began, left) + "\n")

    def erase(self, quiet_s: float = 0.0) -> None:
        """Takes the row away, and draws it no more for so many seconds, unless something is shown."""
        if self._drawn:
            self._write(ERASED)
            self._drawn = False
        if self.row:
            self._next = max(self._next, perf_counter() + quiet_s)

    def _write(self, text: str) -> None:
        """Writes at once and as a whole, so that what the child writes stands before or after it."""
        try:
            sys.stderr.flush()
            os.write(sys.stderr.fileno(), text.encode(sys.stderr.encoding or "ascii", "replace"))
        except (OSError, ValueError):  # nobody reads it
            self._silent = True


def draws_rows() -> bool:
    """Whether standard error is a terminal that can draw a row anew."""
    try:
        return sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"
    except ValueError:  # it is closed
        return False


def _style() -> Style:
    columns = 80
    with suppress(OSError, ValueError):
        columns = os.get_terminal_size(sys.stderr.fileno()).columns or columns
    wide = "utf" in (sys.stderr.encoding or "").lower()
    return Style(not os.environ.get("NO_COLOR"), wide, columns)


@contextmanager
def ticking(doing: Doing) -> Iterator[None]:
    """A context that shows one step of a command that runs in this process, from a thread of its own."""
    display, ended = Display(perf_counter()), Event()
    display.show(doing)

    def run() -> None:
        while not ended.wait(DRAWN_EVERY_S):
            display.tick()

    thread = Thread(target=run, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        display.erase()
