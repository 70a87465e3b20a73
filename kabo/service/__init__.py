"""The same requests as on the command line, over zenoh: a queue, worker processes, one reply for every request.

`Server` and `Client` load zenoh when they are first used. What a request means, free of any transport, is in
`solve_file`; the command line calls it too, so that every door answers with the same object.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kabo.service.answers import Answer, check_files, missing_library, solve_file, verify_file
    from kabo.service.client import Client
    from kabo.service.inline import pack_problem, problem_for
    from kabo.service.messages import SolveOptions
    from kabo.service.server import Server, Settings
    from kabo.service.session import DEFAULT_ENDPOINT, client_config, server_config

_HOMES = {
    "Answer": "kabo.service.answers",
    "Client": "kabo.service.client",
    "DEFAULT_ENDPOINT": "kabo.service.session",
    "Server": "kabo.service.server",
    "Settings": "kabo.service.server",
    "SolveOptions": "kabo.service.messages",
    "check_files": "kabo.service.answers",
    "client_config": "kabo.service.session",
    "missing_library": "kabo.service.answers",
    "pack_problem": "kabo.service.inline",
    "problem_for": "kabo.service.inline",
    "server_config": "kabo.service.session",
    "solve_file": "kabo.service.answers",
    "verify_file": "kabo.service.answers",
}

__all__ = [
    "DEFAULT_ENDPOINT",
    "Answer",
    "Client",
    "Server",
    "Settings",
    "SolveOptions",
    "check_files",
    "client_config",
    "missing_library",
    "pack_problem",
    "problem_for",
    "server_config",
    "solve_file",
    "verify_file",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'kabo.service' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
