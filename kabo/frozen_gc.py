"""Freezes existing objects while planning, so that the garbage collector skips them; and collects less often.

A planner makes many objects that live until it ends, and compiled kernels come with half a million more: a full
collection walks through all of them and frees nothing, for longer than a small problem takes. Young objects are mostly
still in use as well, and each walk through them is for little: with Python's 700 these take a tenth of planning.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

YOUNG = 10_000  # new objects after which a collection looks for garbage among them: a few megabytes


class _PlanningThreads:
    """Counts the threads that plan: the first one freezes, the last one unfreezes."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0
        self._thresholds = gc.get_threshold()  # of the caller

    def enter(self) -> bool:
        """Whether the thread was counted, and has to call `leave`."""
        with self._lock:
            if self._inside == 0:
                if gc.get_freeze_count():
                    return False
                gc.freeze()
                self._thresholds = young, *older = gc.get_threshold()
                if 0 < young < YOUNG:  # 0: the caller wants no collections
                    gc.set_threshold(YOUNG, *older)
            self._inside += 1
            return True

    def leave(self) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                gc.unfreeze()
                gc.set_threshold(*self._thresholds)


_threads = _PlanningThreads()


@contextmanager
def frozen_gc() -> Iterator[None]:
    """A context that freezes the existing objects [gc.freeze] until the last thread has left such a context.

    Collections are less frequent meanwhile; the caller's thresholds are set again afterwards.
    If the caller has frozen objects already, nothing is done: unfreezing them would undo the caller's work.
    """
    entered = _threads.enter()
    try:
        yield
    finally:
        if entered:
            _threads.leave()
