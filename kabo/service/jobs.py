"""Jobs and their outcomes: one run for equal requests, however often and by whomever they are sent.

An id belongs to the bytes of its request. Who asks again joins the running job or gets the stored outcome; the
store is bounded by bytes, so that a server may run for ever.
"""

import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

from kabo.service.messages import error_body

NOT_STORED = frozenset({"worker_died", "shutting_down"})  # may be asked for again
BYTES_PER_JOB = 1024  # what a stored outcome costs beside its bytes


@dataclass(frozen=True)
class Outcome:
    """How a job ended: `code` None is a reply with the plan file's bytes, if there is a plan; else an error."""

    code: str | None
    body: bytes
    plan: bytes | None = None

    @property
    def size(self) -> int:
        """The bytes that keeping it takes."""
        return BYTES_PER_JOB + len(self.body) + len(self.plan or b"")


Deliver = Callable[[Outcome], None]


@dataclass(eq=False)
class Job:
    """A request on its way: `deadline` in seconds of this process' monotonic clock."""

    identifier: str
    request: bytes
    deadline: float
    digest: bytes = b""
    attempts: int = 0
    started: bool = False
    cancelled: threading.Event = field(default_factory=threading.Event)
    outcome: Outcome | None = None
    waiting: list[Deliver] = field(default_factory=list)

    def failure(self, code: str, message: str) -> Outcome:
        """The outcome of an error of this job."""
        return Outcome(code, error_body(code, message, self.identifier))

    def why_stop(self) -> str | None:
        """The code with which the job must end now, or None."""
        if self.cancelled.is_set():
            return "cancelled"
        return "deadline" if time.monotonic() > self.deadline else None


class JobStore:
    """All jobs by their ids: those on their way, and the outcomes of the last ones, oldest forgotten first."""

    def __init__(self, max_bytes: int = 64 << 20) -> None:
        self._lock = threading.Lock()
        self._jobs: OrderedDict[str, Job] = OrderedDict()
        self._max_bytes, self._bytes = max_bytes, 0

    def admit(self, job: Job, deliver: Deliver, enqueue: Callable[[Job], str | None]) -> str | None:
        """Lets a request in: joins an equal one, delivers a stored outcome, or enqueues a new job.

        Returns:
            None, or the code of the error with which it was turned away (of `enqueue`, or `id_reused`).
        """
        job.digest = hashlib.sha256(job.request).digest()
        with self._lock:
            known = self._jobs.get(job.identifier)
            if known is None:
                refused = enqueue(job)
                if refused is None:
                    self._jobs[job.identifier] = job
                    job.waiting.append(deliver)
                return refused
            if known.digest != job.digest:
                return "id_reused"
            if known.outcome is None:
                known.waiting.append(deliver)
                return None
        deliver(known.outcome)
        return None

    def find(self, identifier: str) -> Job | None:
        """The job with this id, if it is still known."""
        with self._lock:
            return self._jobs.get(identifier)

    def unfinished(self) -> list[Job]:
        """The jobs that have no outcome yet, in the order of their arrival."""
        with self._lock:
            return [job for job in self._jobs.values() if job.outcome is None]

    def finish(self, job: Job, outcome: Outcome) -> None:
        """Gives a job its outcome, once; whoever waits for it gets it now."""
        with self._lock:
            if job.outcome is not None:
                return
            job.outcome, job.request = outcome, b""
            waiting, job.waiting = job.waiting, []
            if outcome.code in NOT_STORED:
                self._jobs.pop(job.identifier, None)
            else:
                self._bytes += outcome.size
                self._forget()
        for deliver in waiting:
            deliver(outcome)

    def _forget(self) -> None:
        finished = (
            [job for job in self._jobs.values() if job.outcome is not None]
            if self._bytes > self._max_bytes
            else []
        )
        for job in finished[:-1]:  # the last one stays, however large
            if self._bytes <= self._max_bytes:
                return
            assert job.outcome is not None
            self._bytes -= job.outcome.size
            del self._jobs[job.identifier]
