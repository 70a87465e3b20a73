"""Phases of long work: what a run does now, and how much of it is done, for whoever waits. Never part of a result.

Work names its phases where it does them, and need not know who hears of them: the command line, or nobody.

    with phase("checking motions", len(nodes), "motions") as step:
        for node in nodes:
            ...
            step()

Each phase that has ended is logged with its seconds. Whoever waits hears of a step at most every tenth of a second.
"""

import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from time import perf_counter

EVERY_S = 0.1  # between two steps that are heard


@dataclass(frozen=True)
class Phase:
    """The state of a phase: what is done, how many of a total (None: unknown), and what is counted, as `motions`."""

    doing: str
    done: int = 0
    total: int | None = None
    unit: str = ""


Listener = Callable[[Phase], None]
Step = Callable[[], None]
_LISTENER: ContextVar[tuple[int, Listener] | None] = ContextVar("kabo_listener", default=None)
_AROUND: ContextVar[Step | None] = ContextVar("kabo_phase", default=None)  # says the phase around this one again
WORKING = Phase("working")


@contextmanager
def heard_by(listener: Listener) -> Iterator[None]:
    """A context whose phases, in this process and thread, are told to a function."""
    token = _LISTENER.set((os.getpid(), listener))
    try:
        yield
    finally:
        _LISTENER.reset(token)


@contextmanager
def phase(
    doing: str, total: int | None = None, unit: str = "", *, log: logging.Logger | None = None
) -> Iterator[Step]:
    """A context for a phase of work, with a function to be called after each of its steps.

    Args:
        doing: what is done, in two or three words, such as `checking motions`.
        total: how many steps there are; None if that is unknown.
        unit: what the steps are, in the plural.
        log: the logger that is told the seconds; None: that of kabo.
    """
    listener = _listener()
    if listener is None:
        with timed(doing, log):
            yield _nothing
        return
    steps, around = _Steps(listener, doing, total, unit), _AROUND.get()
    steps.tell()
    token = _AROUND.set(steps.tell)
    try:
        with timed(doing, log):
            yield steps
    finally:
        _AROUND.reset(token)
        listener(WORKING) if around is None else around()


@contextmanager
def timed(doing: str, log: logging.Logger | None = None) -> Iterator[None]:
    """A context whose seconds are logged, and nothing else: for phases of which somebody is told in another way."""
    began = perf_counter()
    try:
        yield
    finally:
        seconds = perf_counter() - began
        fields = {"phase": doing, "seconds": round(seconds, 6)}
        (log or _LOG).info("%s: %.3f s", doing, seconds, extra={"fields": fields})


def _listener() -> Listener | None:
    """Who hears of phases; nobody in forked processes, which share the connection of the one that forked them."""
    found = _LISTENER.get()
    return None if found is None or found[0] != os.getpid() else found[1]


def _nothing() -> None:
    """A step that nobody hears of."""


class _Steps:
    """Counts steps, and tells of them from time to time."""

    def __init__(self, listener: Listener, doing: str, total: int | None, unit: str) -> None:
        self._listener, self._doing, self._total, self._unit = listener, doing, total, unit
        self._done, self._next = 0, perf_counter() + EVERY_S

    def __call__(self) -> None:
        self._done += 1
        now = perf_counter()
        if now >= self._next:
            self._next = now + EVERY_S
            self.tell()

    def tell(self) -> None:
        """Tells how many steps are done."""
        self._listener(Phase(self._doing, self._done, self._total, self._unit))


_LOG = logging.getLogger("kabo")
