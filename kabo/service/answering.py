"""Answers to queries, whatever happens: after an exception in a callback a client would believe that no server exists."""

from collections.abc import Callable
from contextlib import suppress

import zenoh

from kabo.service.messages import Unreadable, error_body

JSON = "application/json"
RETRY_AFTER_S = 0.2

Handler = Callable[[zenoh.Query], None]


def answered(handler: Handler, query: zenoh.Query) -> None:
    """Runs a handler so that the query gets an answer whatever happens."""
    try:
        handler(query)
    except Unreadable as error:
        refuse(query, "bad_request", str(error))
    except Exception as error:  # noqa: BLE001 - the outer edge of a callback
        refuse(query, "failed", f"a defect of kabo: {type(error).__name__}: {error}")


def payload_of(query: zenoh.Query) -> bytes:
    """What was sent with a query."""
    return b"" if query.payload is None else query.payload.to_bytes()


def reply(query: zenoh.Query, key: str, body: bytes, attachment: bytes | None = None) -> None:
    """Answers a query with JSON; the one who asked may be gone."""
    with suppress(zenoh.ZError), query:
        query.reply(key, body, encoding=JSON, attachment=attachment)


def refuse(query: zenoh.Query, code: str, message: str, identifier: str | None = None) -> None:
    """Answers a query with an error."""
    later = RETRY_AFTER_S if code in ("busy", "shutting_down") else None
    send_error(query, error_body(code, message, identifier, later))


def send_error(query: zenoh.Query, body: bytes) -> None:
    """Answers a query with an error that is written already."""
    with suppress(zenoh.ZError), query:
        query.reply_err(body, encoding=JSON)
