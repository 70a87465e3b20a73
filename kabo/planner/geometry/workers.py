"""Worker processes that ask procedures ahead of the planner: what they answer is what it would have heard itself.

A procedure is a pure function of its call, the situation, the attempt and the effort, and its samples are counted
streams; so it does not matter in which process it is asked, nor when. The planner goes its one way, in its one
order, and says early what it is going to ask; its answers, counts and identifiers are taken in that order. Hence the
same plan, byte for byte, with any number of workers: they change when an answer is there, never which.
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
from kabo.geometry_server import Answer, Situation, Statistics
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.procedure_server import ProcedureServer

POLL_S = 0.05  # how often a wait looks whether the run is to stop


@dataclass(frozen=True)
class ProcedureCall:
    """All that the answer of a procedure depends on."""

    call: GroundCall
    situation: Situation
    attempt: int = 0
    effort: int = 0

    @property
    def resumed(self) -> tuple[object, ...]:
        """What the attempts at one call share: whoever made the first ones goes on from there."""
        return self.call, self.effort, self.situation.key

    @property
    def key(self) -> tuple[object, ...]:
        """What tells questions apart."""
        return *self.resumed, self.attempt


@dataclass(eq=False)
class _ProcedureWorker:
    """One process, the question that it is at, and those that wait for it."""

    process: Any
    connection: Connection
    asked: ProcedureCall | None = None
    waiting: deque[ProcedureCall] = field(default_factory=deque)

    @property
    def load(self) -> int:
        return len(self.waiting) + (self.asked is not None)


class ProcedureWorkers:
    """Processes with a copy of the procedures each, made when first needed; a context manager that ends them.

    Args:
        procedures: what is asked; it takes answers from here where one was expected.
        size: how many processes; with less than two there are none, and nothing is ever expected.
        stop: whether the run is to end.
    """

    def __init__(self, procedures: ProcedureServer, size: int, stop: Callable[[], bool]) -> None:
        self._procedures, self._size, self._stop = procedures, size, stop
        self._workers: list[_ProcedureWorker] = []
        self._ended: list[_ProcedureWorker] = []
        self._whose: dict[tuple[object, ...], _ProcedureWorker] = {}
        self._expected: set[tuple[object, ...]] = set()
        self._found: dict[tuple[object, ...], tuple[Answer, Statistics]] = {}

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

    def expect(self, questions: Iterable[ProcedureCall]) -> None:
        """Says what will be asked soon; a single question with nothing beside it is left to who asks it."""
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

    def _known(self, question: ProcedureCall) -> bool:
        return self._procedures.knows(question.call, question.situation, question.attempt, question.effort)

    def _of(self, question: ProcedureCall) -> _ProcedureWorker:
        """Whoever was asked for an earlier attempt, else who has least to do."""
        worker = self._whose.get(question.resumed)
        if worker is None:
            worker = self._whose[question.resumed] = min(self._workers, key=lambda each: each.load)
        return worker

    def take(
        self, call: GroundCall, situation: Situation, attempt: int, effort: int
    ) -> tuple[Answer, Statistics] | None:
        """The answer to a question that was expected, with what it cost; None if nobody was asked, or it must stop."""
        key = ProcedureCall(call, situation, attempt, effort).key
        if key not in self._expected:
            return None
        while key not in self._found:
            if self._stop() or key not in self._expected:
                return None
            self._pump(POLL_S)
        self._expected.discard(key)
        return self._found.pop(key)

    def _pump(self, seconds: float) -> None:
        """Sends questions to who is idle, and takes in what has been answered, waiting so long at most."""
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
        """A process died: what it was to answer is expected no more, so that who asks it answers it."""
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
    """Answers questions until the planner is gone, or one fails: then the planner asks it itself, and says why."""
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
