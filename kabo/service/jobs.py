"""Jobs and their outcomes: equal requests are worked on only once, however often they are sent.

An id belongs to the problem and options of its request. A client that sends a request again joins the running job,
whose deadline stays, or gets the stored outcome. Unfinished requests and stored outcomes have limits in bytes, so
that a server can run without end.
"""

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
    """The outcome of a job: a reply (`code` None) with the plan file's bytes if there is a plan, or an error."""

    code: str | None
    body: bytes
    plan: bytes | None = None

    @property
    def size(self) -> int:
        """The memory that the stored outcome takes [bytes]."""
        return BYTES_PER_JOB + len(self.body) + len(self.plan or b"")


Deliver = Callable[[Outcome], None]


@dataclass(eq=False)
class SolveJob:
    """An accepted request; `deadline` is on the monotonic clock [s], `digest` hashes problem and options."""

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
        """The outcome if this job ends with an error."""
        return Outcome(code, error_body(code, message, self.identifier))

    def why_stop(self) -> str | None:
        """The code of the error with which the job must end now; None if it may go on."""
        if self.cancelled.is_set():
            return "cancelled"
        return "deadline" if time.monotonic() > self.deadline else None


class JobStore:
    """All jobs by their ids: the unfinished ones, and the latest finished ones with their outcomes.

    The request of the job that was let in last is kept for those who follow, also when it has ended.

    Args:
        max_bytes: the memory limit of stored outcomes.
        max_request_bytes: the memory limit of all unfinished requests; if there are none, any request is accepted.
    """

    def __init__(self, max_bytes: int = 64 << 20, max_request_bytes: int = 128 << 20) -> None:
        self._lock = threading.Lock()
        self._unfinished: dict[str, SolveJob] = {}
        self._finished: OrderedDict[str, SolveJob] = OrderedDict()
        self._max_bytes, self._bytes = max_bytes, 0
        self._max_request_bytes, self._request_bytes = max_request_bytes, 0
        self.latest: tuple[SolveJob, bytes] | None = None  # the job that was let in last, and its request

    def admit(self, job: SolveJob, deliver: Deliver, enqueue: Callable[[SolveJob], str | None]) -> str | None:
        """Accepts a request: it joins an equal job, gets a stored outcome, or becomes a new job in the queue.

        Returns:
            None, or the code of the error with which it is refused (that of `enqueue`, `busy` or `id_reused`).
        """
        with self._lock:
            known = self._unfinished.get(job.identifier) or self._finished.get(job.identifier)
            if known is None:
                return self._let_in(job, deliver, enqueue)
            if known.digest != job.digest:
                return "id_reused"
            if known.outcome is None:
                known.waiting.append(deliver)
                return None
        deliver(known.outcome)
        return None

    def _let_in(self, job: SolveJob, deliver: Deliver, enqueue: Callable[[SolveJob], str | None]) -> str | None:
        size = len(job.request)
        if self._unfinished and self._request_bytes + size > self._max_request_bytes:
            return "busy"
        refused = enqueue(job)
        if refused is None:
            self._unfinished[job.identifier] = job
            self.latest = job, job.request
            self._request_bytes += size
            job.waiting.append(deliver)
        return refused

    def cancel(self, identifier: str) -> bool:
        """Makes the unfinished job with this id end soon; returns whether there is such a job."""
        with self._lock:
            job = self._unfinished.get(identifier)
        if job is not None:
            job.cancelled.set()
        return job is not None

    def unfinished(self) -> list[SolveJob]:
        """The jobs that have no outcome yet, in the order of their arrival."""
        with self._lock:
            return list(self._unfinished.values())

    def finish(self, job: SolveJob, outcome: Outcome) -> None:
        """Gives a job its outcome, once, and delivers it to everybody who waits for it."""
        with self._lock:
            if job.outcome is not None:
                return
            if self._unfinished.pop(job.identifier, None) is not None:
                self._request_bytes -= len(job.request)
            job.outcome, job.request = outcome, b""
            waiting, job.waiting = job.waiting, []
            if outcome.code not in NOT_STORED:
                self._finished[job.identifier] = job
                self._bytes += outcome.size
                self._forget()
        for deliver in waiting:
            deliver(outcome)

    def _forget(self) -> None:
        while self._bytes > self._max_bytes and len(self._finished) > 1:  # the last one stays, however large
            _, oldest = self._finished.popitem(last=False)
            assert oldest.outcome is not None
            self._bytes -= oldest.outcome.size
