"""What a worker tells those who follow a request: which calls are refused, by pair, and the best plan so far.

Both are told while the request is worked on, and are never part of its answer. They have a key of their own, so that
clients which only want the progress are not troubled.
"""

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import msgspec

if TYPE_CHECKING:  # callers are given this class; loading it takes a second, which only a scene is worth
    from kabo.tasks.procedures import GeometricProcedures

FORMAT = "kabo-follow/1"
TOLD_EVERY_S = 0.5
MAX_CALLS, MAX_PAIRS = 12, 6  # refused calls that are told, and pairs of each

Send = Callable[[bytes, bytes | None], None]


class RefusedCall(msgspec.Struct, frozen=True):
    """A call that has not succeeded so far: why, in how many attempts, and which pairs came too close how often."""

    call: str
    reason: str
    attempts: int
    message: str
    pairs: list[tuple[str, str, int]]


class Followed(msgspec.Struct, frozen=True):
    """One message to those who follow; with `found`, the body of an answer, comes the plan file of the best plan so far."""

    format: str = FORMAT
    answered: int = 0  # calls that succeeded
    refused: list[RefusedCall] = []
    found: dict[str, Any] | None = None


class Following:
    """The callbacks of a job by which it is followed."""

    def __init__(self, send: Send) -> None:
        self._send = send
        self._asked: GeometricProcedures | None = None
        self._next, self._last = 0.0, b""

    def procedures(self, asked: "GeometricProcedures") -> None:
        """Notes the procedures of the run, of which can be told from now on."""
        self._asked = asked

    def look(self) -> None:
        """Tells which calls are refused, if that has changed, at most every half a second; called often."""
        now = time.monotonic()
        if self._asked is None or now < self._next:
            return
        self._next = now + TOLD_EVERY_S
        told = msgspec.json.encode(_followed(self._asked))
        if told != self._last:
            self._last = told
            self._send(told, None)

    def found(self, body: Mapping[str, Any], plan: bytes) -> None:
        """Tells of a plan that is still to be refined or certified."""
        self._send(msgspec.json.encode(Followed(found=dict(body))), plan)


def _followed(asked: "GeometricProcedures") -> Followed:
    from kabo.planner.telling import refused_so_far  # loads kernels, which a problem with a scene has loaded

    refused = [
        RefusedCall(str(call), refusal.reason, refusal.attempts, refusal.comment, _pairs(refusal.pairs))
        for call, refusal in refused_so_far(asked)[-MAX_CALLS:]
    ]
    return Followed(answered=sum(record.successes > 0 for record in asked.records.of.values()), refused=refused)


def _pairs(pairs: Any) -> list[tuple[str, str, int]]:
    return [(first, second, count) for (first, second), count in pairs[:MAX_PAIRS]]
