"""The messages of the service as data: msgspec decodes and checks them, and refuses unknown keys.

The server itself decodes only the `Envelope`. Problem and options stay raw bytes until a worker decodes them, so
that a large request does not delay other requests.
"""

import hashlib
import math
import re
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Optional, cast, get_args, get_type_hints

import msgspec

from kabo.options import OPTIONS, Option, SolveOptions

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


def _field(option: Option, said: Any) -> tuple[str, Any, Any]:
    """The name, type and default of an option in a message; `said` is its type in `SolveOptions`."""
    limits = {"ge": option.at_least, "gt": option.above, "le": option.at_most}
    given: Any = {key: value for key, value in limits.items() if value is not None}
    kind = said if option.choices or option.kind is bool else Annotated[option.kind, msgspec.Meta(**given)]
    if NoneType in get_args(said):
        return option.name, Optional[kind], None  # noqa: UP007, UP045  the type is made here, not written
    return option.name, kind, option.default


if TYPE_CHECKING:  # its fields are known at run time only; `said` gives them the types of `SolveOptions`
    OptionsMessage = msgspec.Struct
else:
    _SAID = get_type_hints(SolveOptions)
    OptionsMessage = msgspec.defstruct(
        "SolveOptions",
        [_field(option, _SAID[name]) for name, option in OPTIONS.items()],
        forbid_unknown_fields=True,
        omit_defaults=True,
        frozen=True,
    )


def said(message: OptionsMessage) -> SolveOptions:
    """The options in a message as a dictionary, by their names."""
    return cast("SolveOptions", msgspec.structs.asdict(message))


class InlineFile(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A file in a message that is not text, encoded as base64."""

    base64: bytes  # msgspec decodes base64 itself


class ProblemFiles(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True, frozen=True):
    """The problem of a request: its files inline, or a path below the server's root; `path` can name one of them.

    `domain` is the path of the domain file in formats whose problems do not name it (PDDL, PKS).
    """

    path: str | None = None
    files: dict[str, str | InlineFile] | None = None
    domain: str | None = None


class SolveRequest(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A whole request to solve a problem."""

    id: str
    problem: ProblemFiles
    deadline_s: float = DEFAULT_DEADLINE_S
    options: OptionsMessage = OptionsMessage()


class Envelope(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """The part of a request that the server reads; problem and options are only checked to be JSON."""

    id: str
    problem: msgspec.Raw
    deadline_s: float = DEFAULT_DEADLINE_S
    options: msgspec.Raw = msgspec.Raw(b"{}")

    def digest(self) -> bytes:
        """A hash of the problem and options to which the request's id is bound; the deadline is not included."""
        digest = hashlib.sha256(len(memoryview(self.problem)).to_bytes(8, "big"))
        digest.update(self.problem)
        digest.update(self.options)
        return digest.digest()


class CancelRequest(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A request to stop the job with this id."""

    id: str


class Cancelled(msgspec.Struct, frozen=True):
    """The reply to `cancel`: tells whether the id belongs to an unfinished job, which then ends soon."""

    known: bool


class LatestRequest(msgspec.Struct, frozen=True):
    """The reply to `request`: the request that was let in last, as it was sent, for those who follow; or none."""

    id: str | None = None
    request: msgspec.Raw = msgspec.Raw(b"null")


class ErrorReply(msgspec.Struct, frozen=True):
    """An error reply."""

    code: str
    message: str
    retry_after_s: float | None = None


class Status(msgspec.Struct, frozen=True):
    """The status of a server."""

    server: str
    queued: int
    running: int
    workers: int
    protocol: int
    version: str
    max_request_bytes: int
    root: str | None


class Unreadable(ValueError):
    """The error for a message that cannot be decoded; its text says where and why."""


def read(kind: Any, raw: bytes) -> Any:
    """Decodes a message of the type `kind` from JSON.

    Raises:
        Unreadable: the message is not JSON, lacks a key, has an unknown key, or has a value of the wrong type or
            range.
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
