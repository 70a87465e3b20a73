"""Collections of garbage while a plan is looked for: what was there before is not looked through again and again.

A planner makes many objects that live until it ends, and with compiled kernels loaded half a million others are
there already: a full collection walks through all of them to find nothing, for longer than a small problem takes.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock


class _PlanningThreads:
    """How many threads plan now: the first sets objects apart, the last takes them back."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._inside = 0

    def enter(self) -> bool:
        """Whether a visitor was counted, who has to leave."""
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
    """Sets the objects that are there apart from collections, until the last thread that asked for it has left.

    Where the caller has set objects apart himself [gc.freeze], nothing is done: taking his back would be wrong.
    """
    entered = _threads.enter()
    try:
        yield
    finally:
        if entered:
            _threads.leave()
