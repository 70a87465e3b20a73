"""Child processes that can be killed: for code that checks no stop flag, as in libraries, and for whole commands.

A child never outlives its parent: on Linux the system kills it when the parent ends, in whatever way.
"""

import os
import signal
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection
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
    parent = os.getpid()
    receiving, sending = Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        receiving.close()
        _make(make, sending, parent)
    sending.close()
    try:
        while not receiving.poll(POLL_S):
            look()
        made, error = receiving.recv()
    except EOFError:
        made, error = None, None
    except BaseException:
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        receiving.close()
        _, status = os.waitpid(child, 0)
    if error is not None:
        raise error
    if status:
        raise KaboError(f"a process of kabo ended by {ended_by(status)}, without an answer")
    return made  # type: ignore[no-any-return]


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
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C, and kills this process
        try:
            channel.send((make(), None))
        except Exception as error:  # noqa: BLE001 - it is raised again where the answer is wanted
            channel.send((None, error))
        code = 0
    finally:
        os._exit(code)
