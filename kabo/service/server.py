"""The server: declares its zenoh keys, accepts or refuses requests, and answers every request.

A zenoh callback only reads the envelope and returns, and replies in any case (answering.py). To add a verb, add its
message to messages.py, and its handler to `verbs` in this file.
"""

import time
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
import zenoh

from kabo import __version__
from kabo.service import keys
from kabo.service.answering import JSON, answered, payload_of, refuse, reply, send_error
from kabo.service.jobs import JobStore, Outcome, SolveJob
from kabo.service.messages import (
    PROTOCOL,
    Cancelled,
    CancelRequest,
    Envelope,
    LatestRequest,
    Status,
    read,
)
from kabo.service.session import max_request_bytes, open_session
from kabo.service.worker import Begin
from kabo.service.workers import Pool

MAX_REQUEST_BYTES = 32 << 20
QUEUE_BYTES = 128 << 20
REFUSALS = {
    "busy": "the queue is full",
    "id_reused": "this id belongs to another request",
}


@dataclass(frozen=True)
class ServerSettings:
    """The settings of a server.

    Args:
        workers: the number of worker processes.
        bound: the number of requests that may wait.
        queue_bytes: the size limit of all unfinished requests together; if there are none, any request is
            accepted.
        store_bytes: the size limit of the outcomes that are stored for clients that send a request again.
        root: the folder below which requests may name paths; None: requests may not name paths.
        work: `module:function`; a function `warm_up` of that module is called in each worker before its first job.
        begin: called in each worker after that, such as to keep a log; it can be pickled.
    """

    workers: int = 2
    bound: int = 64
    queue_bytes: int = QUEUE_BYTES
    store_bytes: int = 64 << 20
    root: Path | None = None
    work: str = "kabo.service.worker:solve_work"
    begin: Begin | None = None


class Server:
    """A planning service on one zenoh session; answers from the moment it is made until `close`.

    The constructor returns when all workers are warm; only then do clients see the server.

    Raises:
        ServiceError: an endpoint cannot be used, or the workers die while they start.
    """

    def __init__(
        self, config: zenoh.Config, settings: ServerSettings = ServerSettings(), name: str | None = None
    ) -> None:
        self.name = name or keys.new_server_name()
        self._settings, self._stopping = settings, False
        self._limit = min(MAX_REQUEST_BYTES, max_request_bytes(config))
        self._session = open_session(config)
        self._store = JobStore(settings.store_bytes, settings.queue_bytes)
        self._pool = Pool(
            settings.work,
            self._store,
            workers=settings.workers,
            bound=settings.bound,
            root=None if settings.root is None else settings.root.resolve(),
            on_progress=self._put_progress,
            begin=settings.begin,
        )
        try:
            self._pool.warm_up()
        except BaseException:  # a worker's fault, or Ctrl-C
            self._pool.close()
            self._session.close()
            raise
        verbs = {"solve": self._solve, "cancel": self._cancel, "status": self._status, "request": self._request}
        self._queryables = [
            self._session.declare_queryable(keys.verb(self.name, verb), partial(answered, handler))
            for verb, handler in verbs.items()
        ]
        # Last, because from now on clients come.
        self._token = self._session.liveliness().declare_token(keys.verb(self.name, "alive"))

    def worker_processes(self) -> list[int]:
        """The process ids of the workers."""
        return self._pool.processes()

    def close(self, patience_s: float = 10.0) -> None:
        """Refuses new requests, waits up to `patience_s` for running requests, refuses all others, and closes."""
        self._stopping = True  # the token stays: clients give up what they asked of a server without one
        until = time.monotonic() + patience_s
        while self._store.unfinished() and time.monotonic() < until:
            time.sleep(0.02)
        for job in self._store.unfinished():
            self._store.finish(job, job.failure("shutting_down", "try another server"))
        self._token.undeclare()
        self._pool.close()
        for queryable in self._queryables:
            queryable.undeclare()
        self._session.close()

    def _solve(self, query: zenoh.Query) -> None:
        raw = payload_of(query)
        if len(raw) > self._limit:
            return refuse(query, "too_large", f"a request has up to {self._limit} bytes; this one has {len(raw)}")
        envelope = read(Envelope, raw)
        if self._stopping:
            return refuse(query, "shutting_down", "try another server", envelope.id)
        job = SolveJob(envelope.id, raw, time.monotonic() + envelope.deadline_s, envelope.digest())
        refused = self._store.admit(job, partial(self._deliver, query), self._pool.enqueue)
        if refused is not None:
            refuse(query, refused, REFUSALS[refused], envelope.id)
        return None

    def _cancel(self, query: zenoh.Query) -> None:
        known = self._store.cancel(read(CancelRequest, payload_of(query)).id)
        self._reply(query, "cancel", msgspec.json.encode(Cancelled(known)))

    def _request(self, query: zenoh.Query) -> None:
        found = self._store.latest
        told = LatestRequest() if found is None else LatestRequest(found[0].identifier, msgspec.Raw(found[1]))
        self._reply(query, "request", msgspec.json.encode(told))

    def _status(self, query: zenoh.Query) -> None:
        root = self._settings.root
        status = Status(
            server=self.name,
            queued=self._pool.queued,
            running=self._pool.running,
            workers=self._pool.size,
            protocol=PROTOCOL,
            version=__version__,
            max_request_bytes=self._limit,
            root=None if root is None else str(root.resolve()),
        )
        self._reply(query, "status", msgspec.json.encode(status))

    def _deliver(self, query: zenoh.Query, outcome: Outcome) -> None:
        if outcome.code is None:
            self._reply(query, "solve", outcome.body, outcome.plan)
        else:
            send_error(query, outcome.body)

    def _reply(self, query: zenoh.Query, verb: str, body: bytes, plan: bytes | None = None) -> None:
        reply(query, keys.verb(self.name, verb), body, plan)

    def _put_progress(self, job: SolveJob, kind: str, body: bytes, plan: bytes | None) -> None:
        with suppress(zenoh.ZError):
            self._session.put(
                (keys.progress if kind == "progress" else keys.follow)(self.name, job.identifier),
                body,
                encoding=JSON,
                attachment=plan,
                congestion_control=zenoh.CongestionControl.DROP,
                priority=zenoh.Priority.DATA_LOW,
            )
