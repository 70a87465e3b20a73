"""Worker processes that execute jobs ahead of time, so that answers are ready when the scheduler picks the jobs.

Stage functions are pure, so a job has the same answers in any process at any time. The scheduler picks the same
jobs in the same order with any number of processes; their number only changes when an answer is ready, never what
it is. Before a job is executed here, the first jobs in the queues are sent to idle processes, if the jobs of their
stages take long enough on average. A job that gives its answers one at a time stays in the process where it began.
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
from kabo.tasks.core.run.nodes import Scheduler

# Mean seconds of a stage's jobs from which sending them is worth it; measured by benchmarks/tasks_workers.py.
MIN_SECONDS_TO_SEND = 0.01
MAX_JOBS_AHEAD = 6  # how many jobs at the front of one stage's queue may be sent ahead of time

Outcome = tuple[list[Answer], bool, float]


@dataclass(eq=False)
class _StageWorker:
    """A worker process, and the jobs that it was sent."""

    process: Any
    connection: Connection
    # Jobs without an answer, in the order in which they will be answered.
    asked: list[StageJob] = field(default_factory=list)


class StageWorkers:
    """Processes that know the stage functions of one run; they start when the first job is sent."""

    def __init__(self, run: Scheduler, size: int, *, min_seconds: float | None = None) -> None:
        self.size, self._min_seconds = size, MIN_SECONDS_TO_SEND if min_seconds is None else min_seconds
        self._leaves = [node for node in run.order if isinstance(node, Leaf)]
        self._numbers = {node: number for number, node in enumerate(self._leaves)}
        self._workers: list[_StageWorker] = []
        self._where: dict[StageJob, _StageWorker] = {}  # the process in which a job has begun
        self._names: dict[StageJob, int] = {}  # the number by which that process knows the job
        self._next = count().__next__
        self._answers: dict[StageJob, Any] = {}  # answers to jobs that were not picked yet
        self._here: set[Leaf] = set()  # stages whose scenes or answers cannot be pickled
        self._alone = bool(current_process().daemon)  # whether this is a worker itself: workers have no workers

    def run(self, node: Leaf, job: StageJob) -> Outcome:
        """The next answers of a picked job, whether they are the last, and the seconds spent on them."""
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
        self._forget(job)  # the answer could not be pickled, or the process has ended
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
        """Sends jobs to idle processes; if this process waits for `now`, it keeps the first of these jobs for itself."""
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
        """The first jobs in the queues of slow stages, the stages after `node` first."""
        turn = self._numbers[node] + 1
        leaves = [*self._leaves[turn:], *self._leaves[:turn]]
        slow = [n for n in leaves if n.heap and n not in self._here and self._is_slow(n)]
        for place in range(MAX_JOBS_AHEAD):
            for leaf in slow:
                job = leaf.peek(place)
                if job is not None:
                    yield leaf, job

    def _is_slow(self, node: Leaf) -> bool:
        figures = node.statistics
        return figures.calls > 0 and figures.seconds >= self._min_seconds * figures.calls

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
        except Exception:  # noqa: BLE001 whatever cannot be pickled runs here
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
        """Ends the worker processes.

        Unfinished jobs resume where they were interrupted when they are picked again.
        """
        for worker in self._workers:
            worker.connection.close()
            worker.process.kill()
        for worker in self._workers:
            worker.process.join()
        self._workers, self._where, self._names, self._answers = [], {}, {}, {}


def _serve(connection: Connection, others: Sequence[Connection], functions: Sequence[Callable[..., Any]]) -> None:
    """Answers jobs until the connection is closed."""
    signal(SIGINT, SIG_IGN)  # Ctrl-C is for the process that plans
    for other in others:
        other.close()
    begun: dict[int, StageJob] = {}
    with suppress(EOFError, OSError):
        while True:
            number, name, job = loads(connection.recv_bytes())  # noqa: S301 the same
            connection.send_bytes(_answer(functions[number], begun, name, job))


def _answer(function: Callable[..., Any], begun: dict[int, StageJob], name: int, fresh: StageJob) -> bytes:
    """The pickled outcome of a job, or the error that it raised; None if that cannot be pickled."""
    began = perf_counter()
    try:
        found, finished = begun.setdefault(name, fresh).run(function)
    except BaseException as error:  # noqa: BLE001 raised where the job is picked
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
