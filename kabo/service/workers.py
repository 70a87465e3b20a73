"""The pool of worker processes: a bounded queue, and for every process a thread that supervises it.

A worker takes jobs as soon as it has warmed up. If it dies, its job is tried a second time; if it does not stop in
time, it is killed. The pool does not depend on zenoh, and the workers do not depend on the pool.
"""

import multiprocessing
import queue
import threading
import time
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import NamedTuple

from kabo.errors import ServiceError
from kabo.free_memory import give_back
from kabo.service.jobs import JobStore, Outcome, SolveJob
from kabo.service.worker import STOP, Begin, worker_main

GRACE_S = 0.5  # from asking a worker to stop until SIGKILL
ATTEMPTS = 2  # at a job whose worker dies
STARTS = 8  # in a row of a worker that dies before it is ready; then its job fails
MAX_PAUSE_S = 2.0  # between two starts of a worker, when it dies or cannot be started
POLL_S = 0.02
IDLE_S = 0.5  # between two looks whether a waiting worker is alive
SWEEP_S = 0.05  # between two looks at the deadlines of waiting jobs
LARGE_BYTES = 1 << 20  # of a request, after which the server gives memory back

# A job, "progress" or "follow", a message, and the plan file of the best plan so far.
OnProgress = Callable[[SolveJob, str, bytes, bytes | None], None]


class Pool:
    """Worker processes that take jobs from a queue with room for `bound` waiting jobs."""

    def __init__(
        self,
        work: str,
        store: JobStore,
        *,
        workers: int,
        bound: int,
        root: Path | None,
        on_progress: OnProgress,
        begin: Begin | None = None,
    ) -> None:
        self._queue: queue.Queue[SolveJob] = queue.Queue(bound)
        self._store, self._closed = store, threading.Event()
        first = threading.Event()  # it compiles what is not yet compiled; the others find it on disk
        self._supervisors = [
            _Supervisor(self._queue, store, (work, root, begin), on_progress, None if n == 0 else first, first)
            for n in range(workers)
        ]
        self._sweeper = threading.Thread(target=self._sweep, daemon=True)
        for thread in (*self._supervisors, self._sweeper):
            thread.start()

    def warm_up(self) -> None:
        """Waits until every worker has warmed up.

        Raises:
            ServiceError: a worker died at every attempt to start it.
        """
        for supervisor in self._supervisors:
            supervisor.tried.wait()
        if not all(supervisor.started for supervisor in self._supervisors):
            raise ServiceError("unavailable", f"a worker process died {STARTS} times while it started")

    @property
    def size(self) -> int:
        """The number of workers."""
        return len(self._supervisors)

    def processes(self) -> list[int]:
        """The process ids of the workers."""
        return [supervisor.process for supervisor in self._supervisors if supervisor.process is not None]

    @property
    def running(self) -> int:
        """The number of workers that are working on a job."""
        return sum(supervisor.busy for supervisor in self._supervisors)

    @property
    def queued(self) -> int:
        """The number of jobs that wait for a worker."""
        return sum(not job.started for job in self._store.unfinished())

    def enqueue(self, job: SolveJob) -> str | None:
        """Puts a job into the queue; returns the error code "busy" if the queue is full, else None."""
        try:
            self._queue.put_nowait(job)
        except queue.Full:
            return "busy"
        return None

    def close(self) -> None:
        """Ends all worker processes; unfinished jobs get no outcome."""
        self._closed.set()
        for supervisor in self._supervisors:
            supervisor.end()
        for supervisor in self._supervisors:
            supervisor.join(5)

    def _sweep(self) -> None:
        """Ends jobs at their deadline, or when they are cancelled, that still wait for a worker."""
        while not self._closed.wait(SWEEP_S):
            for job in self._store.unfinished():
                if not job.started and (why := job.why_stop()) is not None:
                    self._store.finish(job, job.failure(why, "before a worker was free"))


class _WorkerProcess(NamedTuple):
    """A worker process and the server's end of its pipe."""

    process: SpawnProcess
    connection: Connection

    def discard(self) -> None:
        """Ends the process at once."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def _spawned(work: str, root: Path | None, begin: Begin | None) -> _WorkerProcess:
    """Starts a worker process.

    Raises:
        OSError: the system is out of processes, memory or file descriptors.
    """
    context = multiprocessing.get_context("spawn")
    connection, child = context.Pipe()
    try:
        process = context.Process(target=worker_main, args=(child, work, root, begin), daemon=True)
        process.start()
    except BaseException:
        connection.close()
        raise
    finally:
        child.close()
    return _WorkerProcess(process, connection)


class _Supervisor(threading.Thread):
    """A thread that keeps one worker process alive and warm, gives it jobs, and kills it where needed.

    `tried` is set when its worker is warm for the first time, or has died `STARTS` times before.
    """

    def __init__(
        self,
        jobs: "queue.Queue[SolveJob]",
        store: JobStore,
        arguments: tuple[str, Path | None, Begin | None],
        progress: OnProgress,
        after: threading.Event | None,
        tried: threading.Event,
    ) -> None:
        super().__init__(daemon=True)
        self._jobs, self._store, self._progress = jobs, store, progress
        self._arguments = arguments
        self._after, self.tried = after, tried if after is None else threading.Event()
        self._ending = threading.Event()
        self._worker: _WorkerProcess | None = None
        self._ready = False  # the worker waits for a job
        self._false_starts = 0  # in a row
        self.started = self.busy = False

    def run(self) -> None:
        """Takes jobs until the pool closes."""
        while self._after is not None and not self._after.wait(IDLE_S) and not self._ending.is_set():
            pass
        while not self._ending.is_set():
            if not self._await_ready(lambda: False):
                continue
            try:
                job = self._jobs.get(timeout=IDLE_S)
            except queue.Empty:
                continue
            if job.outcome is None:  # else cancelled or overdue while it waited
                self._serve(job)
        self._discard()

    @property
    def process(self) -> int | None:
        """The id of the worker process; None if there is none now."""
        return None if self._worker is None else self._worker.process.pid

    def end(self) -> None:
        """Makes the thread and its process end soon."""
        self._ending.set()

    def _serve(self, job: SolveJob) -> None:
        """Works on a job and gives it its outcome, whatever happens."""
        self.busy = job.started = True
        large = len(job.request) > LARGE_BYTES
        try:
            outcome = self._outcome(job)
        except Exception as error:  # noqa: BLE001 - the outer edge of a thread: without it, nobody would answer
            traceback.print_exc()
            self._discard()
            outcome = job.failure("failed", f"a defect of kabo: {type(error).__name__}: {error}")
        self.busy = False  # before the reply: who has it and asks for the status is not told of this job
        self._store.finish(job, outcome)
        if large:
            give_back()

    def _await_ready(self, given_up: Callable[[], bool]) -> bool:
        """Starts a worker if there is none and waits until it is ready; False at the end, or if `given_up`."""
        while not self._ending.is_set() and not given_up():
            if self._worker is None:
                self._start()
            elif not self._worker.process.is_alive():
                self._discard()
                if not self._ready:
                    self._note_false_start()
            elif self._ready:
                return True
            else:
                self._ready = self._said_ready(self._worker)
                if self._ready:
                    self.started, self._false_starts = True, 0
                    self.tried.set()
        return False

    def _start(self) -> None:
        self._ready = False
        try:
            self._worker = _spawned(*self._arguments)
        except OSError:
            self._note_false_start()

    def _note_false_start(self) -> None:
        self._false_starts += 1
        if self._false_starts >= STARTS:
            self.tried.set()
        self._ending.wait(min(MAX_PAUSE_S, POLL_S * 2**self._false_starts))

    def _discard(self) -> None:
        if self._worker is not None:
            self._worker.discard()
        self._worker = None

    @staticmethod
    def _said_ready(worker: _WorkerProcess) -> bool:
        wait([worker.connection, worker.process.sentinel], timeout=POLL_S)
        try:
            return bool(worker.connection.poll(0)) and worker.connection.recv()[0] == "ready"
        except (EOFError, OSError):  # it died: seen at once
            return False

    def _outcome(self, job: SolveJob) -> Outcome:
        while job.attempts < ATTEMPTS:
            if not self._await_ready(lambda: job.why_stop() is not None or self._false_starts >= STARTS):
                break
            outcome = self._attempt(job)
            if outcome is not None:
                return outcome
            self._discard()
        why = job.why_stop()
        if self._ending.is_set():
            return job.failure("shutting_down", "try another server")
        if why is not None:
            return job.failure(why, "before it started")
        return job.failure("worker_died", "the worker process died twice")

    def _attempt(self, job: SolveJob) -> Outcome | None:
        """Lets the process work on a job; None if the process has died."""
        assert self._worker is not None
        try:
            self._worker.connection.send((job.request, job.deadline - time.monotonic()))
            self._ready = False
            job.attempts += 1
            return self._watched(job, self._worker)
        except (EOFError, OSError):
            return None

    def _watched(self, job: SolveJob, worker: _WorkerProcess) -> Outcome | None:
        stop_asked = None
        while not self._ending.is_set():
            why = job.why_stop()
            if why is not None and stop_asked is None:
                stop_asked = time.monotonic()
                worker.connection.send(STOP)
            if why is not None and stop_asked is not None and time.monotonic() > stop_asked + GRACE_S:
                self._discard()
                return job.failure(why, "stopped by force")
            wait([worker.connection, worker.process.sentinel], timeout=POLL_S)
            if worker.connection.poll(0):
                kind, first, second = worker.connection.recv()
                if kind not in ("progress", "follow"):
                    return _ended_as(job, kind, first, second)
                self._progress(job, kind, first, second)
            elif not worker.process.is_alive():
                return None
        return job.failure("shutting_down", "try another server")


def _ended_as(job: SolveJob, kind: str, first: bytes | str, second: bytes | str | None) -> Outcome:
    """The outcome of a job, from the last message that its worker sent."""
    if kind == "done":
        assert isinstance(first, bytes) and not isinstance(second, str)
        return Outcome(None, first, second)
    if kind == "stopped":
        return job.failure(job.why_stop() or str(first), "stopped at a check")
    if kind == "refused":
        return job.failure(str(first), str(second))
    return job.failure("failed", str(first))
