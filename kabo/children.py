"""Child processes that can be killed: for code that checks no stop flag, for parallel work, and for whole commands.

A child never outlives its parent: on Linux the system kills it when the parent ends, in whatever way.
"""

import gc
import os
import signal
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from kabo.errors import KaboError

_Made = TypeVar("_Made")

POLL_S = 0.02
PR_SET_PDEATHSIG = 1  # of <sys/prctl.h>


def never() -> None:
    """Does nothing: a periodic check that never interrupts the work."""


def end_with_parent(parent: int) -> None:
    """Makes this process die with its parent, whose process id is given; has no effect on systems other than Linux."""
    import ctypes

    try:
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    except (OSError, AttributeError):
        return
    if os.getppid() != parent:  # the parent has ended before
        os._exit(1)


def made_in_child(make: Callable[[], _Made], look: Callable[[], None] = never) -> _Made:
    """The value of `make`, computed in a forked process while this process calls `look` periodically.

    If `look` raises an error, the forked process is killed. Changes that `make` makes to objects, such as caches,
    are lost. The value or error of `make` must be picklable.

    Raises:
        KaboError: the forked process died without returning a value.
    """
    ((_, made),) = made_in_children([make], 1, look)
    if isinstance(made, Exception):
        raise made
    return made


def made_in_children(
    makes: Sequence[Callable[[], _Made]], size: int, look: Callable[[], None] = never
) -> "Generator[tuple[int, _Made | Exception], None, None]":
    """The values of functions, or the errors that they raised, each with its index, in the order of completion.

    Each function runs in a forked process of its own, as in `made_in_child`; they begin in the given order. If `look`
    raises an error, or the iteration is abandoned, all processes are killed. A process that died without returning a
    value gives a KaboError.

    Args:
        makes: the functions, whose values must be picklable and no errors.
        size: how many processes run at once.
        look: called periodically.
    """
    waiting = list(enumerate(makes))[::-1]
    running: dict[object, _Child] = {}
    try:
        while waiting or running:
            while waiting and len(running) < max(1, size):
                child = _forked(*waiting.pop())
                running[child.receiving] = child
            for ready in wait([child.receiving for child in running.values()], POLL_S):
                child = running.pop(ready)
                yield child.index, child.ending()
            look()
    finally:
        for child in running.values():
            os.kill(child.process, signal.SIGKILL)
        for child in running.values():
            child.ending()


@dataclass(frozen=True)
class _Child:
    """A forked process, the index of its function, and the connection on which its value comes."""

    index: int
    process: int
    receiving: Connection

    def ending(self) -> Any:
        """The value or error of the function, once the process has ended; KaboError if it has sent neither."""
        try:
            made, error = self.receiving.recv()
        except (EOFError, OSError):
            made, error = None, None
        self.receiving.close()
        _, status = os.waitpid(self.process, 0)
        if error is None and status:
            return KaboError(f"a process of kabo ended by {ended_by(status)}, without an answer")
        return made if error is None else error


def _forked(index: int, make: Callable[[], Any]) -> _Child:
    """The process that runs a function."""
    parent = os.getpid()
    receiving, sending = Pipe(duplex=False)
    process = os.fork()
    if process == 0:
        receiving.close()
        _make(make, sending, parent)
    sending.close()
    return _Child(index, process, receiving)


def ended_by(status: int) -> str:
    """The way a process ended, in words, from its status as `waitpid` returns it."""
    if not os.WIFSIGNALED(status):
        return f"exit code {os.waitstatus_to_exitcode(status)}"
    number = os.WTERMSIG(status)
    known = {each.value: each.name for each in signal.Signals}
    hint = ", perhaps for want of memory" if number == signal.SIGKILL else ""
    return f"signal {known.get(number, number)}{hint}"


def _make(make: Callable[[], Any], channel: Connection, parent: int) -> None:
    """Runs the child; never returns."""
    code = 1
    try:
        end_with_parent(parent)
        gc.freeze()  # else a collection would write to all objects of the parent, and copy their memory
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C, and kills this process
        try:
            channel.send((make(), None))
        except Exception as error:  # noqa: BLE001 - it is raised again where the answer is wanted
            channel.send((None, error))
        code = 0
    finally:
        os._exit(code)
