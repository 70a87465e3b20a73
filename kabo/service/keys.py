"""The key space of a server: `kabo/v1/<server>/<verb>`, one for every server, never shared.

A key shared by several servers would give each request to all of them; so a client chooses a server among the
liveliness tokens and asks it alone [docs/decisions/003-service.md].
"""

import os
import re
import secrets
import socket

ROOT = "kabo/v1"
ALIVE = f"{ROOT}/*/alive"


def new_server_name() -> str:
    """A name for this process that no other has: host, process id, four random hexadecimal digits."""
    host = re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname()) or "host"
    return f"{host}-{os.getpid()}-{secrets.token_hex(2)}"


def verb(server: str, name: str) -> str:
    """The key of a verb (or of `alive`) of a server."""
    return f"{ROOT}/{server}/{name}"


def progress(server: str, identifier: str) -> str:
    """The key on which the progress of a request is put."""
    return f"{ROOT}/{server}/progress/{identifier}"


def server_of(key: str) -> str:
    """The server that a key belongs to."""
    return key.split("/")[2]
