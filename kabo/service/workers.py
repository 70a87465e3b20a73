"""The pool: a bounded queue, and for every worker process one thread that watches it.

A worker takes jobs from the moment it is warm. One that dies costs its job one attempt of two; one that does not stop in
time is killed. The pool knows nothing of zenoh, and the work nothing of the pool.
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
from kabo.service.jobs import Job, JobStore, Outcome
from kabo.service.worker import STOP, give_back, worker_main

GRACE_S = 0.5  # from the request to stop until SIGKILL
ATTEMPTS = 2  # a job is tried again once, when its worker dies
STARTS = 8  # a worker that dies before it is ready costs no attempt, but not for ever
MAX_PAUSE_S = 2.0  # between two starts of a worker, when it dies or cannot be started
POLL_S = 0.02
IDLE_S = 0.5  # how often a waiting worker's life is looked after
SWEEP_S = 0.05
LARGE_BYTES = 1 << 20  # of a request, after which the server gives memory back

OnProgress = Callable[[Job, bytes], None]


class Pool:
    """Worker processes that take jobs from a queue of `bound` places."""

    def __init__(
        self, work: str, store: JobStore, *, workers: int, bound: int, root: Path | None, on_progress: OnProgress
    ) -> None:
        self._queue: queue.Queue[Job] = queue.Queue(bound)
        self._store, self._closed = store, threading.Event()
        first = threading.Event()  # it compiles what is not yet compiled; the others find it on disk
        self._attendants = [
            _Attendant(self._queue, store, work, root, on_progress, None if n == 0 else first, first)
            for n in range(workers)
        ]
        self._sweeper = threading.Thread(target=self._sweep, daemon=True)
        for thread in (*self._attendants, self._sweeper):
            thread.start()

    def warm_up(self) -> None:
        """Waits until every worker is warm.

        Raises:
            ServiceError: one of them dies each time it starts.
        """
        for attendant in self._attendants:
            attendant.tried.wait()
        if not all(attendant.started for attendant in self._attendants):
            raise ServiceError("unavailable", f"a worker process died {STARTS} times while it started")

    @property
    def size(self) -> int:
        """The number of workers."""
        return len(self._attendants)

    def processes(self) -> list[int]:
        """The ids of the worker processes that there are now."""
        return [attendant.process for attendant in self._attendants if attendant.process is not None]

    @property
    def running(self) -> int:
        """The number of workers that have a job."""
        return sum(attendant.busy for attendant in self._attendants)

    @property
    def queued(self) -> int:
        """The number of jobs that wait for a worker."""
        return sum(not job.started for job in self._store.unfinished())

    def enqueue(self, job: Job) -> str | None:
        """Puts a job into the queue, or returns the code "busy"."""
        try:
            self._queue.put_nowait(job)
        except queue.Full:
            return "busy"
        return None

    def close(self) -> None:
        """Ends all worker processes; jobs without an outcome get none from here."""
        self._closed.set()
        for attendant in self._attendants:
            attendant.end()
        for attendant in self._attendants:
            attendant.join(5)

    def _sweep(self) -> None:
        """Ends jobs in time that still wait for a worker."""
        while not self._closed.wait(SWEEP_S):
            for job in self._store.unfinished():
                if not job.started and (why := job.why_stop()) is not None:
                    self._store.finish(job, job.failure(why, "before a worker was free"))


class _Worker(NamedTuple):
    """A worker process and the server's end of its pipe."""

    process: SpawnProcess
    connection: Connection

    def discard(self) -> None:
        """Ends the process at once."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def _spawned(work: str, root: Path | None) -> _Worker:
    """A new worker process.

    Raises:
        OSError: the system has no process, memory or file to give.
    """
    context = multiprocessing.get_context("spawn")
    connection, child = context.Pipe()
    try:
        process = context.Process(target=worker_main, args=(child, work, root), daemon=True)
        process.start()
    except BaseException:
        connection.close()
        raise
    finally:
        child.close()
    return _Worker(process, connection)


class _Attendant(threading.Thread):
    """A thread that keeps one worker process alive and warm, feeds it with jobs, and watches it.

    `tried` is set once a worker was warm for the first time, or has died `STARTS` times before it was.
    """

    def __init__(
        self,
        jobs: "queue.Queue[Job]",
        store: JobStore,
        work: str,
        root: Path | None,
        progress: OnProgress,
        after: threading.Event | None,
        tried: threading.Event,
    ) -> None:
        super().__init__(daemon=True)
        self._jobs, self._store, self._progress = jobs, store, progress
        self._arguments = (work, root)
        self._after, self.tried = after, tried if after is None else threading.Event()
        self._ending = threading.Event()
        self._worker: _Worker | None = None
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
        """The id of the worker process, if there is one now."""
        return None if self._worker is None else self._worker.process.pid

    def end(self) -> None:
        """Makes the thread end soon, and its process with it."""
        self._ending.set()

    def _serve(self, job: Job) -> None:
        """Gives a job its outcome, whatever happens."""
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
        """Whether the worker waits for a job; starts one where there is none, until `given_up` or the end."""
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
    def _said_ready(worker: _Worker) -> bool:
        wait([worker.connection, worker.process.sentinel], timeout=POLL_S)
        try:
            return bool(worker.connection.poll(0)) and worker.connection.recv()[0] == "ready"
        except (EOFError, OSError):  # it died: seen at once
            return False

    def _outcome(self, job: Job) -> Outcome:
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

    def _attempt(self, job: Job) -> Outcome | None:
        """Lets the process work on the job; None if the process died."""
        assert self._worker is not None
        try:
            self._worker.connection.send((job.request, job.deadline - time.monotonic()))
            self._ready = False
            job.attempts += 1
            return self._watched(job, self._worker)
        except (EOFError, OSError):
            return None

    def _watched(self, job: Job, worker: _Worker) -> Outcome | None:
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
                if kind != "progress":
                    return _ended_as(job, kind, first, second)
                self._progress(job, first)
            elif not worker.process.is_alive():
                return None
        return job.failure("shutting_down", "try another server")


def _ended_as(job: Job, kind: str, first: bytes | str, second: bytes | str | None) -> Outcome:
    """The outcome that a worker's last message of a job means."""
    if kind == "done":
        assert isinstance(first, bytes) and not isinstance(second, str)
        return Outcome(None, first, second)
    if kind == "stopped":
        return job.failure(job.why_stop() or str(first), "stopped at a check")
    if kind == "refused":
        return job.failure(str(first), str(second))
    return job.failure("failed", str(first))
