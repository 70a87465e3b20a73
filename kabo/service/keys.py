"""The keys of a server: `kabo/v1/<server>/<verb>`, never shared by two servers.

If several servers shared a key, each request would reach all of them. So a client chooses one server by its
liveliness token and sends the request to this server only [docs/decisions/003-service.md].
"""

import os
import re
import secrets
import socket

ROOT = "kabo/v1"
ALIVE = f"{ROOT}/*/alive"
ALL_ROBOTS = f"{ROOT}/*/robot/alive"
ALL_PROGRESS, ALL_FOLLOW = f"{ROOT}/*/progress/*", f"{ROOT}/*/follow/*"


def new_server_name() -> str:
    """A unique name for this process: host, process id, four random hexadecimal digits."""
    host = re.sub(r"[^A-Za-z0-9_-]", "-", socket.gethostname()) or "host"
    return f"{host}-{os.getpid()}-{secrets.token_hex(2)}"


def verb(server: str, name: str) -> str:
    """The key of a server for a verb such as `solve`, or for the liveliness token `alive`."""
    return f"{ROOT}/{server}/{name}"


def progress(server: str, identifier: str) -> str:
    """The key under which the progress of a request is published."""
    return f"{ROOT}/{server}/progress/{identifier}"


def follow(server: str, identifier: str) -> str:
    """The key under which is published what those who follow a request are told: refusals, and the best plan so far."""
    return f"{ROOT}/{server}/follow/{identifier}"


def robot(server: str, name: str) -> str:
    """The key of a robot server for a verb such as `follow`, its `state`, or its liveliness token `alive`."""
    return f"{ROOT}/{server}/robot/{name}"


def driver(server: str, client: str) -> str:
    """The key of a client that drives a robot server: its liveliness token, and its heartbeats."""
    return f"{ROOT}/{server}/robot/driver/{client}"


def server_of(key: str) -> str:
    """The name of the server to which a key belongs."""
    return key.split("/")[2]


def id_of(key: str) -> str:
    """The id of the request to which a key of progress belongs."""
    return key.split("/")[4]


def driver_of(key: str) -> str:
    """The client to which a key of a driver belongs."""
    return key.split("/")[5]
