"""Freezes existing objects while planning, so that the garbage collector skips them.

A planner makes many objects that live until it ends, and compiled kernels come with half a million more: a full
collection walks through all of them and frees nothing, for longer than a small problem takes.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock


class _PlanningThreads:
    """Counts the threads that plan: the first one freezes, the last one unfreezes."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0

    def enter(self) -> bool:
        """Whether the thread was counted, and has to call `leave`."""
        with self._lock:
            if self._inside == 0:
                if gc.get_freeze_count():
                    return False
                gc.freeze()
            self._inside += 1
            return True

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                gc.unfreeze()


_threads = _PlanningThreads()


@contextmanager
def frozen_gc() -> Iterator[None]:
    """A context that freezes the existing objects [gc.freeze] until the last thread has left such a context.

    If the caller has frozen objects already, nothing is done: unfreezing them would undo the caller's work.
    """
    entered = _threads.enter()
    try:
        yield
    finally:
        if entered:
            _threads.leave()
