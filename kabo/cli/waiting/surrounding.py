"""What a running command tells the process around it: what it does, what it has found, how long it may still take."""

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import Lock
from time import perf_counter
from typing import TYPE_CHECKING, Any, TextIO

from kabo.cli.terminal import tell
from kabo.cli.waiting.doing import RESTING, Doing, of_phase, of_preparing, of_progress
from kabo.phases import WORKING, Phase

if TYPE_CHECKING:  # only some commands load them
    from multiprocessing.connection import Connection

    from kabo.cli import rooms

REPORT_S, REPORT_SHARE = 1.0, 0.02  # kept of a limit for saying what was found out: at most, and as a share of it
SENT_EVERY_S = 0.05  # of the same step
QUIET_S = 1.0  # at most, until the row on the terminal is taken away
STAYS_QUIET_S = 0.5  # after which the row must be asked away again; the parent waits twice as long

OnFound = Callable[[Mapping[str, Any], bytes], None]


class Surrounding:
    """The surroundings of a command in this process: lines that stay are told, all else is not shown."""

    _planned: Doing | None = None  # what the planner said last

    def __init__(self) -> None:
        self.began = perf_counter()

    def left(self, timeout: float | None) -> float | None:
        """The seconds of `timeout` that are left for working, at least a millisecond; None if `timeout` is None.

        Some are kept for the report: a command that is killed cannot say what it found out.
        """
        if timeout is None:
            return None
        return max(1e-3, timeout - min(REPORT_S, REPORT_SHARE * timeout) - (perf_counter() - self.began))

    def say(self, doing: Doing, line: str = "") -> None:
        """Says what is done now, and a line that stays, if it is not empty."""
        if line:
            tell(line)

    def rest(self) -> None:
        """Says that nothing is done now, as by a server that waits: then nothing is shown."""
        self.say(RESTING)

    def phase(self, phase: Phase) -> None:
        """Says what a phase of the work does; after the last one, what the planner said before."""
        self.say(self._planned if phase == WORKING and self._planned is not None else of_phase(phase))

    def planning(self, progress: "rooms.Progress") -> None:
        """Says what the planner does."""
        self._planned = of_progress(progress)
        self.say(self._planned, progress.line)

    def preparing(self, state: "rooms.Preparing") -> None:
        """Says how far a preparation of geometry is."""
        self.say(of_preparing(state), state.line)

    def on_found(self) -> OnFound | None:
        """A callback that receives the answer and the plan file once a plan is found; None if not needed."""
        return None

    def on_known(self, body: Mapping[str, Any], text: str) -> None:
        """Keeps an answer as far as it is known, as an object and as text, for when the command is cut off."""


class ChildSurrounding(Surrounding):
    """The surroundings of a command in a child process: the parent shows what is done, and holds a found plan.

    What is said is sent at most every 50 ms, unless another step begins or a line is to stay. The parent names the step
    if it has to end the command.
    """

    def __init__(self, channel: "Connection", began: float) -> None:
        self.began, self._channel = began, channel
        self._lock = Lock()  # a signal handler or another thread may come between
        self._step, self._next, self._quiet_until = "", 0.0, 0.0

    def say(self, doing: Doing, line: str = "") -> None:
        """Sends what is done now to the parent."""
        now = perf_counter()
        if doing.step == self._step and not line and now < self._next:
            return
        self._step, self._next, self._quiet_until = doing.step, now + SENT_EVERY_S, 0.0
        self._send("doing", doing, line)  # as one message: a cut shows all of it or nothing

    def on_found(self) -> OnFound | None:
        """A callback that sends the answer and the plan to the parent."""
        return lambda body, plan: self._send("found", body, plan)

    def on_known(self, body: Mapping[str, Any], text: str) -> None:
        """Sends an answer as far as it is known to the parent."""
        self._send("known", body, text)

    def _send(self, *message: Any) -> None:
        with self._lock:
            self._channel.send(message)

    def quieten(self) -> None:
        """Waits until the parent has taken its row off the terminal, which it then draws no more for a while."""
        if perf_counter() < self._quiet_until or not self._lock.acquire(blocking=False):
            return  # it is away; or this is a signal within another message, and the two would become one
        try:
            self._channel.send(("quiet", None, None))
            if self._channel.poll(QUIET_S):
                self._channel.recv()
            self._quiet_until = perf_counter() + STAYS_QUIET_S
        except (EOFError, OSError):
            return
        finally:
            self._lock.release()


class _Apart:
    """A stream whose text never stands in the row that the parent draws."""

    def __init__(self, stream: TextIO, quieten: Callable[[], None]) -> None:
        self._stream, self._quieten = stream, quieten

    def write(self, text: str) -> int:
        """Writes text after the row was taken away."""
        if text:
            self._quieten()
        return self._stream.write(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def apart(surrounding: ChildSurrounding) -> Iterator[None]:
    """A context in which what is written to the terminal never stands in the row that the parent draws."""
    before = sys.stdout, sys.stderr
    sys.stdout = _Apart(sys.stdout, surrounding.quieten)
    sys.stderr = _Apart(sys.stderr, surrounding.quieten)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before
