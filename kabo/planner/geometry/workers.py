"""Worker processes that make calls in advance; their answers equal those that the planner would compute itself.

A procedure is a pure function of its call, the situation, the attempt and the effort, and its random numbers come
from counter-based streams, so that neither the process nor the time of its evaluation changes the answer. The
planner announces the calls that it will make, and uses answers, counts and identifiers in its own order. The plan
is therefore the same, byte for byte, with any number of workers.
"""

import os
import signal
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from typing import Any

from kabo.children import end_with_parent
from kabo.geometry_server import Answer, GeometryStatistics, Situation
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.procedure_server import ProcedureServer

POLL_S = 0.05  # seconds between two looks at whether the run is to stop


@dataclass(frozen=True)
class SituatedCall:
    """A call together with everything that its answer depends on: situation, attempt and effort."""

    call: GroundCall
    situation: Situation
    attempt: int = 0
    effort: int = 0

    @property
    def resumed(self) -> tuple[object, ...]:
        """The key shared by all attempts at a call: one worker computes them, each continuing the last."""
        return self.call, self.effort, self.situation.key

    @property
    def key(self) -> tuple[object, ...]:
        """The key of a situated call: equal keys have equal answers."""
        return *self.resumed, self.attempt


@dataclass(eq=False)
class _ProcedureWorker:
    """One process, the call that it is computing, and those that wait for it."""

    process: Any
    connection: Connection
    asked: SituatedCall | None = None
    waiting: deque[SituatedCall] = field(default_factory=deque)

    @property
    def load(self) -> int:
        return len(self.waiting) + (self.asked is not None)


class ProcedureWorkers:
    """Processes that compute announced calls in advance; a context manager that ends them on exit.

    The processes are started at the first announcement (see `expect`), each with a copy of the procedures.

    Args:
        procedures: the procedures to be copied; inside the context, they take the answers of announced calls from
            the processes instead of computing them.
        size: the number of processes; if it is below two, none is started, and announcements are ignored.
        stop: returns True when the run is to end, after which no answer is waited for.
    """

    def __init__(self, procedures: ProcedureServer, size: int, stop: Callable[[], bool]) -> None:
        self._procedures, self._size, self._stop = procedures, size, stop
        self._workers: list[_ProcedureWorker] = []
        self._ended: list[_ProcedureWorker] = []
        self._whose: dict[tuple[object, ...], _ProcedureWorker] = {}
        self._expected: set[tuple[object, ...]] = set()
        self._found: dict[tuple[object, ...], tuple[Answer, GeometryStatistics]] = {}

    def __enter__(self) -> "ProcedureWorkers":
        self._procedures.elsewhere = self.take
        return self

    def __exit__(self, *_: object) -> None:
        self._procedures.elsewhere = None
        workers = [*self._workers, *self._ended]
        for worker in workers:
            worker.process.kill()
        for worker in workers:
            worker.process.join()
            worker.connection.close()

    def expect(self, questions: Iterable[SituatedCall]) -> None:
        """Announces calls that will be made soon; a single call is left to the planner's own process."""
        if self._size < 2:
            return
        new = {question.key: question for question in questions}
        new = {key: q for key, q in new.items() if key not in self._expected and not self._known(q)}
        if len(new) + len(self._expected) < 2:
            return
        if not self._workers and not self._ended:
            self._workers = [self._started() for _ in range(self._size)]
        if not self._workers:
            return
        for key, question in new.items():
            self._expected.add(key)
            self._of(question).waiting.append(question)
        self._pump(0.0)

    def _known(self, question: SituatedCall) -> bool:
        return self._procedures.knows(question.call, question.situation, question.attempt, question.effort)

    def _of(self, question: SituatedCall) -> _ProcedureWorker:
        """The worker that made an earlier attempt at the call, else the one with the fewest calls."""
        worker = self._whose.get(question.resumed)
        if worker is None:
            worker = self._whose[question.resumed] = min(self._workers, key=lambda each: each.load)
        return worker

    def take(
        self, call: GroundCall, situation: Situation, attempt: int, effort: int
    ) -> tuple[Answer, GeometryStatistics] | None:
        """The answer to an announced call with its statistics; None if it was not announced or the run stops."""
        key = SituatedCall(call, situation, attempt, effort).key
        if key not in self._expected:
            return None
        while key not in self._found:
            if self._stop() or key not in self._expected:
                return None
            self._pump(POLL_S)
        self._expected.discard(key)
        return self._found.pop(key)

    def _pump(self, seconds: float) -> None:
        """Sends calls to idle workers and collects answers, waiting at most so many seconds."""
        self._send()
        busy = {worker.connection: worker for worker in self._workers if worker.asked is not None}
        for ready in connection.wait(list(busy), timeout=seconds):
            worker = busy[ready]  # type: ignore[index]
            try:
                answered = worker.connection.recv()
            except (EOFError, OSError):
                self._lose(worker)
                continue
            assert worker.asked is not None
            self._found[worker.asked.key] = answered
            worker.asked = None
        self._send()

    def _send(self) -> None:
        for worker in tuple(self._workers):
            if worker.asked is None and worker.waiting:
                worker.asked = worker.waiting.popleft()
                try:
                    worker.connection.send((worker.asked, self._procedures.statistics.samples))
                except OSError:
                    self._lose(worker)

    def _lose(self, worker: _ProcedureWorker) -> None:
        """A process died: its calls are no longer announced, so that the planner makes them itself."""
        lost = [worker.asked, *worker.waiting]
        self._expected -= {question.key for question in lost if question is not None}
        self._whose = {resumed: whose for resumed, whose in self._whose.items() if whose is not worker}
        self._workers.remove(worker)
        self._ended.append(worker)

    def _started(self) -> _ProcedureWorker:
        # Forked: scenes, decompositions and compiled kernels are there at once, and nothing has to be sent.
        context = get_context("fork")
        here, there = context.Pipe()
        process = context.Process(target=_work, args=(there, self._procedures, os.getpid()), daemon=True)
        process.start()
        there.close()
        return _ProcedureWorker(process, here)


def _work(channel: Connection, procedures: ProcedureServer, parent: int) -> None:
    """Answers calls until the planner is gone, or one raises: then the planner makes it itself, and reports the error."""
    procedures.elsewhere = None
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the planner is asked to stop, and ends this process
    with suppress(Exception):
        while True:
            question, samples = channel.recv()
            procedures.statistics.samples = samples  # the budget is that of the planner
            before = procedures.statistics.copy()
            answer = procedures.call(question.call, question.situation, question.attempt, question.effort)
            channel.send((answer, procedures.statistics.since(before)))
