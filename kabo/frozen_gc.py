"""Freezes existing objects while planning, so that the garbage collector skips them; and collects less often.

A planner makes many objects that live until it ends, and compiled kernels come with half a million more: a full
collection walks through all of them and frees nothing, for longer than a small problem takes. Young objects are mostly
still in use as well, and each walk through them is for little: with Python's 700 these take a tenth of planning.

Freezing sets the counts to zero by which Python tells that a full collection is due. A process that plans often would never
make one: so it is made here, before objects are frozen, as soon as memory blocks have become a quarter more.
"""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

YOUNG = 10_000  # new objects after which a collection looks for garbage among them: a few megabytes
GROWN = 1.25  # times as many blocks of memory as after the last full collection; Python's own rule, of objects


class _PlanningThreads:
    """Counts the threads that plan: the first one freezes, the last one unfreezes."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0
        self._thresholds = gc.get_threshold()  # of the caller
        self._blocks: int | None = None  # the fewest since the last full collection; None: nothing was planned yet

    def enter(self) -> bool:
        """Whether the thread was counted, and has to call `leave`."""
        with self._lock:
            if self._inside == 0:
                if gc.get_freeze_count():
                    return False
                self._collect()
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
                self._blocks = self._blocks or sys.getallocatedblocks()  # with what the first planning has loaded

    def _collect(self) -> None:
        """Makes a full collection if one is due, and collections are made at all."""
        if self._blocks is None or not gc.isenabled() or gc.get_threshold()[0] == 0:
            return
        if sys.getallocatedblocks() > GROWN * self._blocks:
            gc.collect()
            self._blocks = sys.getallocatedblocks()
        self._blocks = min(self._blocks, sys.getallocatedblocks())


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
