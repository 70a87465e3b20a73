"""The client: sends a request to a live server and, if the server is lost, to another one with the same id.

Zenoh returns no reply at all if a server is dead, absent or not accessible. Then the client chooses another one of
the servers whose liveliness tokens it sees.
"""

import json
import random
import threading
import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from typing import Any

import msgspec
import zenoh

from kabo.errors import ServiceError
from kabo.service import keys
from kabo.service.messages import Cancelled, Envelope, ErrorReply, LatestRequest, Status
from kabo.service.session import open_session, unanswered

ELSEWHERE = frozenset({"busy", "shutting_down", "worker_died"})  # another server, or the same one later, may do it
MAX_WORKER_DEATHS = 4  # each stands for two: a poisonous request must not go round for ever
ANSWER_MARGIN_S = 2.0  # the server answers at the deadline; this is for the way back
STATUS_TIMEOUT_S = 5.0

ProblemFor = Callable[[Status], Mapping[str, Any]]
OnProgress = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class Reply:
    """A server's answer: the object that `solve --json` prints, with the id, and the plan file's bytes or None."""

    body: dict[str, Any]
    plan: bytes | None
    server: str


@dataclass(frozen=True)
class Watched:
    """A message about a server's work on a request: `progress`, or `follow`, which may bring the best plan so far."""

    kind: str
    server: str
    identifier: str
    body: dict[str, Any]
    plan: bytes | None


OnWatched = Callable[[Watched], None]


@dataclass(frozen=True)
class _Lost:
    """This server has not answered the request, for the reason `code`; another attempt may succeed."""

    code: str
    message: str
    retry_after_s: float = 0.02


def _foreign(server: str) -> _Lost:
    return _Lost("unavailable", f"{server} answers in words that are not of this protocol")


def _decoded(answer: "zenoh.Sample | zenoh.ReplyError", kind: Any) -> Any:
    """An answer as a message of `kind`; None if it is none: the server is not a server of kabo."""
    try:
        return msgspec.json.decode(answer.payload.to_bytes(), type=kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return None


def _watched(kind: str, told: "OnWatched", sample: zenoh.Sample) -> None:
    """Hands on a message about the work of a server, if it is one."""
    body = _decoded(sample, dict[str, Any])
    if body is not None:
        key = str(sample.key_expr)
        plan = None if sample.attachment is None else sample.attachment.to_bytes()
        told(Watched(kind, keys.server_of(key), keys.id_of(key), body, plan))


class Client:
    """A zenoh session that watches which servers are alive, and sends requests to them.

    Args:
        config: the configuration of the zenoh session.
        patience_s: the time to wait for a server that is not busy [s].
    """

    def __init__(self, config: zenoh.Config, patience_s: float = 5.0) -> None:
        self._patience_s, self._unanswered = patience_s, unanswered(config)
        self._lock = threading.Condition()
        self._load: dict[str, int] = {}  # live server -> our requests there
        self._open: dict[str, set[zenoh.CancellationToken]] = {}
        self._watching: list[Any] = []
        self._session = open_session(config)
        watch = self._session.liveliness().declare_subscriber
        self._watch = watch(keys.ALIVE, self._seen, history=True)

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the session; pending requests end without an answer."""
        for subscriber in (self._watch, *self._watching):
            subscriber.undeclare()
        self._session.close()

    def servers(self) -> list[str]:
        """The names of the live servers."""
        with self._lock:
            return sorted(self._load)

    def status(self, server: str) -> Status | None:
        """The status of a server; None if it gives no answer, or an answer that is not a status."""
        answer = self._ask(server, "status", b"", STATUS_TIMEOUT_S)
        return _decoded(answer, Status) if isinstance(answer, zenoh.Sample) else None

    def cancel(self, identifier: str) -> bool:
        """Cancels the request with this id on all servers; returns whether one of them was still working on it."""
        payload = msgspec.json.encode({"id": identifier})
        answers = [self._ask(server, "cancel", payload, STATUS_TIMEOUT_S) for server in self.servers()]
        told = (_decoded(answer, Cancelled) for answer in answers if isinstance(answer, zenoh.Sample))
        return any(each is not None and each.known for each in told)

    def latest_request(self, server: str) -> bytes | None:
        """The request that a server has let in last, as it was sent, running or ended; None if there is none."""
        answer = self._ask(server, "request", b"", STATUS_TIMEOUT_S)
        told = _decoded(answer, LatestRequest) if isinstance(answer, zenoh.Sample) else None
        return None if told is None or told.id is None else bytes(told.request)

    def join(self, server: str, request: bytes) -> Reply | ErrorReply | None:
        """The answer of a server to a request that it knows, stored or awaited; None if the server was lost.

        Args:
            server: the server's name.
            request: what `latest_request` returned: to the byte, because its id belongs to these bytes.
        """
        timeout = msgspec.json.decode(request, type=Envelope).deadline_s + ANSWER_MARGIN_S
        answer = self._ask(server, "solve", request, timeout)
        if isinstance(answer, zenoh.Sample):
            return self._reply(answer, server)
        found: ErrorReply | None = None if answer is None else _decoded(answer, ErrorReply)
        return found

    def watch(self, told: OnWatched) -> None:
        """Calls `told`, from other threads, with every message about the work of any server, until this client closes."""
        for kind, key in (("progress", keys.ALL_PROGRESS), ("follow", keys.ALL_FOLLOW)):
            self._watching.append(self._session.declare_subscriber(key, partial(_watched, kind, told)))

    def solve(
        self,
        problem_for: ProblemFor,
        options: Mapping[str, Any],
        *,
        deadline_s: float,
        identifier: str | None = None,
        on_progress: OnProgress | None = None,
    ) -> Reply:
        """Asks a server to solve a problem, and another one if the first is lost or busy.

        Args:
            problem_for: the `problem` of the request for a server with this status (its files, or a path).
            options: the options of `solve`.
            deadline_s: after this time the server answers with the error `deadline`.
            identifier: the request's id; a new one if None. The same id and request is worked on only once.
            on_progress: called with every progress message, from another thread.

        Raises:
            ServiceError: no server was found in time, all are busy, the request was cancelled or refused, or its deadline
            has passed.
        """
        identifier = identifier or uuid.uuid4().hex
        until = time.monotonic() + deadline_s
        patient_until = time.monotonic() + self._patience_s
        avoid: set[str] = set()
        lost, deaths = _Lost("unavailable", self._unanswered), 0
        while time.monotonic() < until:
            server = self._pick(avoid, min(patient_until, until))
            if server is None:
                break
            left = until - time.monotonic()
            answer = self._attempt(
                server, problem_for, {"id": identifier, "deadline_s": left, "options": options}, on_progress
            )
            if isinstance(answer, Reply):
                return answer
            lost, deaths = answer, deaths + (answer.code == "worker_died")
            if deaths == MAX_WORKER_DEATHS or (lost.code == "busy" and time.monotonic() > patient_until):
                break
            if lost.code != "busy":
                patient_until = time.monotonic() + self._patience_s
            avoid = {server}
            time.sleep(lost.retry_after_s * random.uniform(0.5, 1.5))  # noqa: S311 - spreads clients
        raise ServiceError(lost.code, lost.message, request=identifier, retry_after_s=lost.retry_after_s)

    def _attempt(
        self, server: str, problem_for: ProblemFor, message: dict[str, Any], on_progress: OnProgress | None
    ) -> Reply | _Lost:
        status = self.status(server)
        if status is None:
            return _Lost("unavailable", f"the server {server} does not answer")
        payload = msgspec.json.encode({**message, "problem": problem_for(status)})
        identifier = message["id"]
        if len(payload) > status.max_request_bytes:
            limit = f"{len(payload)} bytes, but {server} takes {status.max_request_bytes}"
            raise ServiceError("too_large", f"the request has {limit}", request=identifier)
        with self._progress(server, identifier, on_progress):
            answer = self._ask(server, "solve", payload, message["deadline_s"] + ANSWER_MARGIN_S)
        if answer is None or str(answer.encoding) != "application/json":  # zenoh's own: the time is up
            return _Lost("unavailable", f"the server {server} was lost")
        if isinstance(answer, zenoh.Sample):
            return self._reply(answer, server) or _foreign(server)
        error = _decoded(answer, ErrorReply)
        if error is None:
            return _foreign(server)
        if error.code in ELSEWHERE:
            return _Lost(error.code, error.message, 0.02 if error.retry_after_s is None else error.retry_after_s)
        raise ServiceError(error.code, error.message, request=identifier)

    @staticmethod
    def _reply(answer: zenoh.Sample, server: str) -> Reply | None:
        """An answer that is no error; None if it is not of this protocol."""
        plan = None if answer.attachment is None else answer.attachment.to_bytes()
        body = _decoded(answer, dict[str, Any])
        return None if body is None else Reply(body, plan, server)

    def _progress(self, server: str, identifier: str, on_progress: OnProgress | None) -> Any:
        """A subscription to the progress of a request, as a context manager; an empty one if nobody listens."""
        if on_progress is None:
            return nullcontext()
        seen = on_progress
        key = keys.progress(server, identifier)
        return self._session.declare_subscriber(key, lambda sample: seen(json.loads(sample.payload.to_bytes())))

    def _ask(
        self, server: str, verb: str, payload: bytes, timeout_s: float
    ) -> "zenoh.Sample | zenoh.ReplyError | None":
        """The reply of a server; None if there is none, for whatever reason."""
        token = zenoh.CancellationToken()
        with self._lock:
            if server not in self._load:
                return None
            self._load[server] += 1
            self._open.setdefault(server, set()).add(token)
        try:
            replies = self._session.get(
                keys.verb(server, verb),
                payload=payload,
                timeout=timeout_s,
                cancellation_token=token,
                congestion_control=zenoh.CongestionControl.BLOCK,
            )
            answer = None
            for reply in replies:
                answer = reply.ok if reply.ok is not None else reply.err
            return answer
        except zenoh.ZError:
            return None
        finally:
            with self._lock:
                self._open.get(server, set()).discard(token)
                if server in self._load:
                    self._load[server] -= 1

    def _pick(self, avoid: set[str], until: float) -> str | None:
        """The live server with the fewest requests of this client, outside of `avoid` if possible; waits for one."""
        with self._lock:
            while not self._load:
                if not self._lock.wait(min(0.1, max(0.0, until - time.monotonic()))) and time.monotonic() >= until:
                    return None
            names = [name for name in self._load if name not in avoid] or list(self._load)
            least = min(self._load[name] for name in names)
            return random.choice([name for name in names if self._load[name] == least])  # noqa: S311

    def _seen(self, sample: zenoh.Sample) -> None:
        server = keys.server_of(str(sample.key_expr))
        with self._lock:
            if sample.kind == zenoh.SampleKind.PUT:
                self._load.setdefault(server, 0)
                self._lock.notify_all()
                return
            self._load.pop(server, None)
            tokens = self._open.pop(server, set())
        for token in tokens:  # what was asked of a dead server ends now, not at its timeout
            token.cancel()
