"""The messages of the service as data: decoded and checked by msgspec, unknown keys refused.

`Envelope` is all that the server reads itself; problem and options stay raw bytes until a worker decodes them, so
that a large request does not hold up the others.
"""

import hashlib
import math
import re
from typing import Annotated, Any, Literal

import msgspec

from kabo.language.scene_description import LARGEST_EPSILON, SMALLEST_EPSILON
from kabo.options import Geometry, GeometryOrder, Quality, Search

PROTOCOL = 1
MAX_DEADLINE_S = 86_400.0
DEFAULT_DEADLINE_S = 300.0

Code = Literal[
    "bad_request",  # the message cannot be read; says where
    "id_reused",  # this id belongs to another request
    "busy",  # the queue is full, by number or bytes; retry_after_s says when to ask again
    "deadline",
    "cancelled",
    "failed",  # a defect of kabo
    "worker_died",  # the process that worked on it died, twice
    "shutting_down",
    "too_large",
    "forbidden",  # a path outside of what the server may read
]

_IDENTIFIER = re.compile(r"[A-Za-z0-9_.-]{1,128}")


class SolveOptions(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True, frozen=True):
    """The options of `solve`, as every door takes them; None leaves the choice to problem and scene."""

    search: Search | None = None
    seed: Annotated[int, msgspec.Meta(ge=0)] | None = None
    epsilon: Annotated[float, msgspec.Meta(ge=SMALLEST_EPSILON, le=LARGEST_EPSILON)] | None = None
    geometry: Geometry | None = None
    geometry_order: GeometryOrder = "adaptive"
    quality: Quality = "fast"
    certificate: bool = True
    max_expansions: Annotated[int, msgspec.Meta(ge=0)] | None = None
    max_samples: Annotated[int, msgspec.Meta(ge=0)] | None = None
    timeout: Annotated[float, msgspec.Meta(ge=0)] | None = None
    memory: Annotated[float, msgspec.Meta(gt=0)] | None = None  # bytes


class InlineFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A file that is not text."""

    base64: bytes  # msgspec decodes base64 itself


class ProblemFiles(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True, frozen=True):
    """A problem: all its files inline, or a path below the server's root. With `files`, `path` is one of them.

    `domain` is the path of its domain file, where formats have one that the problem does not name (PDDL, PKS).
    """

    path: str | None = None
    files: dict[str, str | InlineFile] | None = None
    domain: str | None = None


class SolveRequest(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A request to solve, whole."""

    id: str
    problem: ProblemFiles
    deadline_s: float = DEFAULT_DEADLINE_S
    options: SolveOptions = SolveOptions()


class Envelope(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The part of a request that the server itself reads; the rest is only known to be JSON."""

    id: str
    problem: msgspec.Raw
    deadline_s: float = DEFAULT_DEADLINE_S
    options: msgspec.Raw = msgspec.Raw(b"{}")

    def digest(self) -> bytes:
        """What the id belongs to: the bytes of problem and options, whatever the deadline."""
        digest = hashlib.sha256(len(memoryview(self.problem)).to_bytes(8, "big"))
        digest.update(self.problem)
        digest.update(self.options)
        return digest.digest()


class CancelRequest(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A request to stop the job with this id."""

    id: str


class Cancelled(msgspec.Struct, frozen=True):
    """The reply to `cancel`: whether the id is that of a job whose outcome was still open, which now ends."""

    known: bool


class Failure(msgspec.Struct, frozen=True):
    """An error reply."""

    code: str
    message: str
    retry_after_s: float | None = None


class Status(msgspec.Struct, frozen=True):
    """What a server says of itself."""

    server: str
    queued: int
    running: int
    workers: int
    protocol: int
    version: str
    max_request_bytes: int
    root: str | None


class Unreadable(ValueError):
    """A message that cannot be used; the text says where and why."""


def read(kind: Any, raw: bytes) -> Any:
    """A message of a kind.

    Raises:
        Unreadable: it is no JSON, misses a key, has an unknown one, or a value of the wrong type or range.
    """
    try:
        message = msgspec.json.decode(raw, type=kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise Unreadable(str(error)) from None
    identifier = getattr(message, "id", "id")
    if not _IDENTIFIER.fullmatch(identifier):
        raise Unreadable("`$.id` is 1 to 128 letters, digits, `_`, `.` or `-`")
    deadline = getattr(message, "deadline_s", 1.0)
    if not (math.isfinite(deadline) and 0 < deadline <= MAX_DEADLINE_S):
        raise Unreadable(f"`$.deadline_s` is a span of time above 0 and up to {MAX_DEADLINE_S:g} seconds")
    return message


def error_body(
    code: str, message: str, identifier: str | None = None, retry_after_s: float | None = None
) -> bytes:
    """The JSON of an error reply."""
    body: dict[str, Any] = {"code": code, "message": message, "id": identifier}
    if retry_after_s is not None:
        body["retry_after_s"] = retry_after_s
    return msgspec.json.encode(body)
