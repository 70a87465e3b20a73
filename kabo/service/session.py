"""Zenoh sessions: peers with explicit endpoints, without scouting and without shared memory.

Shared memory is off even if a configuration file enables it: a receiver that gets no processor time for more than
100 ms loses messages silently, and a planner keeps all processors busy.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import zenoh

from kabo.errors import ServiceError

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
SECURE = ("tls/", "quic/")  # endpoints at which either side may refuse the other
LEASE_MS = 4000  # a frozen host is noticed after this time
MAX_MESSAGE_BYTES = 64 << 20
ENVELOPE_BYTES = 64 << 10  # what a message needs beside its payload


def server_config(
    listen: Sequence[str] = (), connect: Sequence[str] = (), file: Path | None = None
) -> zenoh.Config:
    """The configuration of a server; without endpoints it listens on `DEFAULT_ENDPOINT`."""
    if not listen and not connect and file is None:
        listen = [DEFAULT_ENDPOINT]
    return _config(listen, connect, file)


def client_config(connect: Sequence[str] = (), file: Path | None = None) -> zenoh.Config:
    """The configuration of a client; without endpoints it connects to `DEFAULT_ENDPOINT`."""
    if not connect and file is None:
        connect = [DEFAULT_ENDPOINT]
    return _config((), connect, file)


def open_session(config: zenoh.Config) -> zenoh.Session:
    """Opens a session.

    Raises:
        ServiceError: an endpoint is malformed, in use, or refused.
    """
    try:
        return zenoh.open(config)
    except zenoh.ZError as error:
        raise ServiceError("unavailable", f"no zenoh session can be opened: {error}") from None


def unanswered(config: zenoh.Config) -> str:
    """The message of a client with this configuration that finds no server.

    A server that refuses a client by TLS is as silent as none at all, so that strangers learn nothing.
    """
    endpoints = [end for end in connected_endpoints(config) if end.startswith(SECURE)]
    if not endpoints:
        return "no server answers; `kabo serve` starts one"
    return (
        f"no server answers at {', '.join(endpoints)}: none runs there, or it refuses this client; compare "
        "authority and certificates of both sides, subjectAltName, and the server's cert_common_names and rules "
        "(docs/how-to/deploy.md)"
    )


def connected_endpoints(config: zenoh.Config) -> list[str]:
    """The endpoints to which a client connects, without what they hold of certificates."""
    named = _endpoints(json.loads(config.get_json("connect/endpoints")))
    return list(dict.fromkeys(end.partition("#")[0] for end in named))


def _endpoints(value: Any) -> Iterator[str]:
    """All endpoints of a setting: a list, or a list for each mode."""
    for each in value.values() if isinstance(value, dict) else [value]:
        yield from each


def max_request_bytes(config: zenoh.Config) -> int:
    """The size of the longest request that arrives [bytes]; a longer one would be dropped without an answer."""
    return int(json.loads(config.get_json("transport/link/rx/max_message_size"))) - ENVELOPE_BYTES


def _config(listen: Sequence[str], connect: Sequence[str], file: Path | None) -> zenoh.Config:
    try:
        config: zenoh.Config = zenoh.Config() if file is None else zenoh.Config.from_file(str(file))
        settings: Mapping[str, Any] = {"transport/shared_memory/enabled": False}
        if file is None:
            settings = {
                **settings,
                "mode": "peer",
                "listen/endpoints": list(listen),
                "connect/endpoints": list(connect),
                "scouting/multicast/enabled": False,
                "scouting/gossip/enabled": False,
                "transport/link/tx/lease": LEASE_MS,
                "transport/link/rx/max_message_size": MAX_MESSAGE_BYTES,
            }
        else:
            named = {"listen/endpoints": list(listen), "connect/endpoints": list(connect)}
            settings = {**settings, **{key: value for key, value in named.items() if value}}
            if _listens_by_default(config):
                settings = {**settings, "listen/endpoints": list(listen)}
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
    except zenoh.ZError as error:
        raise ServiceError("unavailable", f"the zenoh configuration cannot be used: {_said(error)}") from None
    return config


def _listens_by_default(config: zenoh.Config) -> bool:
    """Whether a peer's file names no endpoints to listen on.

    zenoh would open a TCP port on all interfaces then, even beside a file that is about TLS alone.
    """
    default = zenoh.Config().get_json("listen/endpoints")
    is_router = json.loads(config.get_json("mode")) == "router"
    return not is_router and bool(config.get_json("listen/endpoints") == default)


def _said(error: zenoh.ZError) -> str:
    """What zenoh says of a configuration, without the places in zenoh's own source."""
    text = re.sub(r" at \S+\.rs:\d+\.?", "", str(error))
    found = re.search(r'msg: "(.*?)"', text)
    return found[1] if found else text
