"""Worker processes: they execute jobs ahead of time, whose answers are there when the scheduler comes to them.

Stage functions are pure, so wherever a job runs, and whenever, its answers are the same. The scheduler picks the same
jobs in the same order with any number of processes; these change when an answer is there, never which. Before a job is
executed here, the jobs that are first in the queues are sent to processes that are free, if their stages' jobs take long
enough on average that sending them pays. A job that gives its answers piece by piece stays in the process where it began.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from multiprocessing import current_process, get_context
from multiprocessing.connection import Connection
from pickle import dumps, loads
from signal import SIG_IGN, SIGINT, signal
from time import perf_counter
from typing import Any

from kabo.tasks.core.model.results import Answer
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.jobs import StageJob
from kabo.tasks.core.run.nodes import PlanningRun

PAYS = 0.01  # seconds of a stage's mean job from which sending pays; measured by benchmarks/tasks_workers.py
AHEAD = 6  # jobs of one stage that are asked ahead of time

Outcome = tuple[list[Answer], bool, float]


@dataclass(eq=False)
class _StageWorker:
    """A process, and what it was asked."""

    process: Any
    connection: Connection
    asked: list[StageJob] = field(default_factory=list)  # in the order in which it answers


class StageWorkers:
    """Processes that know the stage functions of one run; begun when the first job is sent."""

    def __init__(self, run: PlanningRun, size: int, *, pays: float | None = None) -> None:
        self.size, self._pays = size, PAYS if pays is None else pays
        self._leaves = [node for node in run.order if isinstance(node, Leaf)]
        self._numbers = {node: number for number, node in enumerate(self._leaves)}
        self._workers: list[_StageWorker] = []
        self._where: dict[StageJob, _StageWorker] = {}  # the jobs that have begun elsewhere
        self._names: dict[StageJob, int] = {}  # under which they did
        self._next = count().__next__
        self._answers: dict[StageJob, Any] = {}  # what has come, and was not asked for yet
        self._here: set[Leaf] = set()  # stages whose scenes or answers cannot travel
        self._alone = bool(current_process().daemon)  # a worker has no workers

    def run(self, node: Leaf, job: StageJob) -> Outcome:
        """The next answers of a job that was picked, whether there are no more, and the seconds that they took."""
        worker = self._where.get(job)
        if worker is not None and job not in self._answers and job not in worker.asked:
            while worker.asked:
                self._receive(worker)
            self._send(worker, node, job)
            worker = self._where.get(job)
        self._ask_ahead(node, job, worker is not None)
        if worker is None:
            began = perf_counter()
            found, finished = job.run(node.function())
            return found, finished, perf_counter() - began
        while job not in self._answers and worker in self._workers:
            self._receive(worker)
        answer = self._answers.pop(job, None)
        if isinstance(answer, tuple):
            found, finished, seconds = answer
            job.taken += len(found)
            if finished:
                self._forget(job)
            return found, finished, seconds
        self._forget(job)  # it could not travel, or the process has ended
        if isinstance(answer, BaseException):
            raise answer
        self._here.add(node)
        began = perf_counter()
        found, finished = job.run(node.function())
        return found, finished, perf_counter() - began

    def _forget(self, job: StageJob) -> None:
        self._where.pop(job, None)
        self._names.pop(job, None)

    # ------------------------------------------------------------------------------------------ ahead of time
    def _ask_ahead(self, node: Leaf, now: StageJob, waits: bool) -> None:
        """Sends jobs to the processes that are free; but the next one is this process's own if it `waits` for `now`."""
        for worker in self._workers:
            while worker.asked and worker.connection.poll():
                self._receive(worker)
        free = self.size - 1 - sum(bool(worker.asked) for worker in self._workers)
        if self._alone or free <= 0:
            return
        for leaf, job in self._coming(node):
            if job is now or job.source is not None or job in self._answers:
                continue
            if waits and job not in self._where:
                waits = False
                continue
            free_one = self._where.get(job) or self._idle()
            if free_one is not None and not free_one.asked:
                self._send(free_one, leaf, job)
                free -= 1
                if not free:
                    return

    def _coming(self, node: Leaf) -> Iterator[tuple[Leaf, StageJob]]:
        """The jobs that are first in the queues of stages whose jobs take long, those after `node` first."""
        turn = self._numbers[node] + 1
        leaves = [*self._leaves[turn:], *self._leaves[:turn]]
        slow = [n for n in leaves if n.heap and n not in self._here and self._is_slow(n)]
        for place in range(AHEAD):
            for leaf in slow:
                job = leaf.peek(place)
                if job is not None:
                    yield leaf, job

    def _is_slow(self, node: Leaf) -> bool:
        figures = node.statistics
        return figures.calls > 0 and figures.seconds >= self._pays * figures.calls

    def _idle(self) -> _StageWorker | None:
        free = next((worker for worker in self._workers if not worker.asked), None)
        if free is None and len(self._workers) < self.size - 1:
            free = self._begun()
        return free

    def _begun(self) -> _StageWorker:
        # Forked, so that stages need not be sent: their functions may be closures.
        context = get_context("fork")
        ours, theirs = context.Pipe()
        functions = [node.function() for node in self._leaves]
        others = [worker.connection for worker in self._workers]
        process = context.Process(target=_serve, args=(theirs, [ours, *others], functions), daemon=True)
        process.start()
        theirs.close()
        self._workers.append(_StageWorker(process, ours))
        return self._workers[-1]

    def _send(self, worker: _StageWorker, node: Leaf, job: StageJob) -> None:
        name = self._names.setdefault(job, self._next())
        try:
            worker.connection.send_bytes(
                dumps((self._numbers[node], name, StageJob(None, job.arguments, taken=job.taken)))
            )
        except Exception:  # noqa: BLE001 whatever cannot travel is done here
            self._here.add(node)
            self._forget(job)
            return
        self._where[job] = worker
        worker.asked.append(job)

    def _receive(self, worker: _StageWorker) -> None:
        try:
            said = worker.connection.recv_bytes()
        except (EOFError, OSError):
            self._workers.remove(worker)
            worker.asked.clear()
            return
        self._answers[worker.asked.pop(0)] = loads(said)  # noqa: S301 from a fork of this process

    def close(self) -> None:
        """Ends the processes; jobs that they have begun are taken up where they were left when they are asked again."""
        for worker in self._workers:
            worker.connection.close()
            worker.process.kill()
        for worker in self._workers:
            worker.process.join()
        self._workers, self._where, self._names, self._answers = [], {}, {}, {}


def _serve(connection: Connection, others: Sequence[Connection], functions: Sequence[Callable[..., Any]]) -> None:
    """Answers jobs until nobody is there any more."""
    signal(SIGINT, SIG_IGN)  # a person stops the process that plans
    for other in others:
        other.close()
    begun: dict[int, StageJob] = {}
    with suppress(EOFError, OSError):
        while True:
            number, name, job = loads(connection.recv_bytes())  # noqa: S301 the same
            connection.send_bytes(_answer(functions[number], begun, name, job))


def _answer(function: Callable[..., Any], begun: dict[int, StageJob], name: int, fresh: StageJob) -> bytes:
    """The outcome of a job, or the error that it raised; None if it cannot travel."""
    began = perf_counter()
    try:
        found, finished = begun.setdefault(name, fresh).run(function)
    except BaseException as error:  # noqa: BLE001 told where the job is asked for
        del begun[name]
        answer: Any = error
    else:
        if finished:
            del begun[name]
        answer = found, finished, perf_counter() - began
    try:
        sent = dumps(answer)
        if isinstance(answer, BaseException):
            loads(sent)  # noqa: S301 some errors can be written, but not be read
    except Exception:  # noqa: BLE001 the same
        return dumps(None)
    return sent
