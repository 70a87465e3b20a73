"""The pool: a bounded queue, and for every worker process one thread that watches it.

A worker that dies costs its job one attempt of two; one that does not stop in time is killed. The pool knows
nothing of zenoh, and the work nothing of the pool.
"""

import multiprocessing
import queue
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import wait
from pathlib import Path

from kabo.service.jobs import Job, JobStore, Outcome
from kabo.service.worker import STOP, worker_main

GRACE_S = 0.5  # from the request to stop until SIGKILL
ATTEMPTS = 2  # a job is tried again once, when its worker dies
STARTS = 8  # a worker that dies before it is ready costs no attempt, but not for ever
POLL_S = 0.02
SWEEP_S = 0.05

OnProgress = Callable[[Job, bytes], None]


class Pool:
    """Worker processes that take jobs from a queue of `bound` places."""

    def __init__(
        self, work: str, store: JobStore, *, workers: int, bound: int, root: Path | None, on_progress: OnProgress
    ) -> None:
        self._queue: queue.Queue[Job | None] = queue.Queue(bound)
        self._store, self._closed = store, threading.Event()
        self._attendants = [_Attendant(self._queue, store, work, root, on_progress) for _ in range(workers)]
        self._sweeper = threading.Thread(target=self._sweep, daemon=True)
        for thread in (*self._attendants, self._sweeper):
            thread.start()

    @property
    def size(self) -> int:
        """The number of workers."""
        return len(self._attendants)

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


class _Attendant(threading.Thread):
    """One worker process and the thread that feeds and watches it."""

    def __init__(
        self, jobs: "queue.Queue[Job | None]", store: JobStore, work: str, root: Path | None, progress: OnProgress
    ) -> None:
        super().__init__(daemon=True)
        self._jobs, self._store, self._progress = jobs, store, progress
        self._arguments = (work, root)
        self._ended = False
        self.busy = False

    def run(self) -> None:
        """Takes jobs until the pool closes."""
        self._spawn()
        while not self._ended:
            try:
                job = self._jobs.get(timeout=0.5)
            except queue.Empty:
                continue
            if job is None or job.outcome is not None:  # cancelled or overdue while it waited
                continue
            self.busy = job.started = True
            outcome = self._outcome(job)
            self.busy = False  # before the reply: who has it and asks for the status is not told of this job
            self._store.finish(job, outcome)
        self._kill()

    def end(self) -> None:
        """Makes the thread end soon, and its process with it."""
        self._ended = True

    def _spawn(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, child = context.Pipe()
        self._process = context.Process(target=worker_main, args=(child, *self._arguments), daemon=True)
        self._process.start()
        child.close()

    def _kill(self) -> None:
        self._process.kill()
        self._process.join()
        self._connection.close()

    def _outcome(self, job: Job) -> Outcome:
        for _ in range(STARTS):
            if job.attempts == ATTEMPTS or self._ended:
                break
            outcome = self._attempt(job)
            if outcome is None or not self._process.is_alive():
                self._kill()
                self._spawn()
            if outcome is not None:
                return outcome
        if self._ended:
            return job.failure("shutting_down", "try another server")
        return job.failure("worker_died", "the worker process died twice")

    def _attempt(self, job: Job) -> Outcome | None:
        """Lets the process work on the job; None if the process died."""
        try:
            return self._watched(job)
        except (EOFError, OSError):
            return None

    def _watched(self, job: Job) -> Outcome | None:
        sent, stop_asked = False, None
        while not self._ended:
            why = job.why_stop()
            if why is not None and not sent:
                return job.failure(why, "before it started")
            if why is not None and stop_asked is None:
                stop_asked = time.monotonic()
                self._connection.send(STOP)
            if why is not None and stop_asked is not None and time.monotonic() > stop_asked + GRACE_S:
                self._process.kill()
                self._process.join()
                return job.failure(why, "stopped by force")
            wait([self._connection, self._process.sentinel], timeout=POLL_S)
            if self._connection.poll(0):
                kind, first, second = self._connection.recv()
                if kind == "ready" and not sent:
                    sent, job.attempts = True, job.attempts + 1
                    self._connection.send((job.request, job.deadline - time.monotonic()))
                elif kind == "progress":
                    self._progress(job, first)
                else:
                    return _ended_as(job, kind, first, second)
            elif not self._process.is_alive():
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
