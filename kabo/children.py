"""Child processes that can be killed: for code that checks no stop flag, for parallel work, and for whole commands.

A child never outlives its parent: on Linux the system kills it when the parent ends, in whatever way.
"""

import gc
import os
import signal
from collections.abc import Callable, Generator, Sequence
from contextlib import suppress
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

    The functions run in forked processes, as in `made_in_child`, and begin in the given order; a process takes the next
    one when it is done. If `look` raises an error, or the iteration is abandoned, all processes are killed. A process
    that died without returning a value gives a KaboError, and is replaced.

    Args:
        makes: the functions, whose values must be picklable and no errors.
        size: how many processes run at once.
        look: called periodically.
    """
    waiting = list(range(len(makes)))[::-1]
    workers: dict[object, _Worker] = {}
    try:
        while waiting or workers:
            while waiting and len(workers) < max(1, size):
                worker = _forked(makes, waiting.pop())
                workers[worker.channel] = worker
            for ready in wait([worker.channel for worker in workers.values()], POLL_S):
                worker = workers.pop(ready)
                index, made, alive = worker.answer()
                if alive and waiting:
                    worker.ask(waiting.pop())
                    workers[worker.channel] = worker
                elif alive:
                    worker.end()
                yield index, made
            look()
    finally:
        for worker in workers.values():
            os.kill(worker.process, signal.SIGKILL)
        for worker in workers.values():
            worker.end()


@dataclass
class _Worker:
    """A forked process, the index of the function that it runs, and the connection to it."""

    process: int
    channel: Connection
    index: int

    def ask(self, index: int) -> None:
        self.index = index
        with suppress(OSError):  # it has died: its answer says so
            self.channel.send(index)

    def answer(self) -> tuple[int, Any, bool]:
        """The index, the value or error, and whether the process lives on."""
        try:
            made, error = self.channel.recv()
        except (EOFError, OSError):
            said = f"a process of kabo ended by {ended_by(self.end())}, without an answer"
            return self.index, KaboError(said), False
        return self.index, made if error is None else error, True

    def end(self) -> int:
        """Waits until the process has ended, which it is asked to do; returns its status."""
        with suppress(OSError):
            self.channel.send(None)
        self.channel.close()
        return os.waitpid(self.process, 0)[1]


def _forked(makes: Sequence[Callable[[], Any]], index: int) -> _Worker:
    """A process that runs the function with this index, and then those for which it is asked."""
    parent = os.getpid()
    here, there = Pipe()
    process = os.fork()
    if process == 0:
        here.close()
        _work(makes, index, there, parent)
    there.close()
    return _Worker(process, here, index)


def ended_by(status: int) -> str:
    """The way a process ended, in words, from its status as `waitpid` returns it."""
    if not os.WIFSIGNALED(status):
        return f"exit code {os.waitstatus_to_exitcode(status)}"
    number = os.WTERMSIG(status)
    known = {each.value: each.name for each in signal.Signals}
    hint = ", perhaps for want of memory" if number == signal.SIGKILL else ""
    return f"signal {known.get(number, number)}{hint}"


def _work(makes: Sequence[Callable[[], Any]], index: int | None, channel: Connection, parent: int) -> None:
    """Runs a worker until it is told to end; never returns."""
    code = 1
    try:
        end_with_parent(parent)
        gc.freeze()  # else a collection would write to all objects of the parent, and copy their memory
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C, and kills this process
        while index is not None:
            try:
                made, error = makes[index](), None
            except Exception as raised:  # noqa: BLE001 - it is raised again where the answer is wanted
                made, error = None, raised
            channel.send((made, error))
            index = channel.recv()
        code = 0
    finally:
        os._exit(code)
