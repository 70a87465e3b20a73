"""The keys of a server: `kabo/v1/<server>/<verb>`, never shared by two servers.

A key shared by several servers would give each request to all of them. So a client chooses a server by its liveliness
token and asks that one alone [docs/decisions/003-service.md].
"""

import os
import re
import secrets
import socket

ROOT = "kabo/v1"
ALIVE = f"{ROOT}/*/alive"


def new_server_name() -> str:
    """A unique name for this process: host, process id, four random hexadecimal digits."""
    host = re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname()) or "host"
    return f"{host}-{os.getpid()}-{secrets.token_hex(2)}"


def verb(server: str, name: str) -> str:
    """The key of a verb (or of `alive`) of a server."""
    return f"{ROOT}/{server}/{name}"


def progress(server: str, identifier: str) -> str:
    """The key under which the progress of a request is published."""
    return f"{ROOT}/{server}/progress/{identifier}"


def server_of(key: str) -> str:
    """The server that a key belongs to."""
    return key.split("/")[2]
