"""Lives of workers: a process that is warm, and for each life a fork of it that answers some requests in their order.

A fork has remembered nothing of any request, so it is a fresh process that need not load its libraries again; what the
warm process planned had other file names.
"""

import json
import multiprocessing
import os
import resource
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import msgspec

Files = Mapping[str, bytes]
MEMORY = 6 << 30
DATE = 1_700_000_000 * 10**9  # of every file below a root: neither name nor date nor size tell files apart
BUDGET = {"max_samples": 2000, "max_expansions": 3000}  # a changed problem may have no plan


@dataclass(frozen=True)
class Asked:
    """A request: its files, the problem's path; `rooted`: they lie below the server's root, else they are sent along."""

    files: Files
    path: str
    rooted: bool = False


class Unhurried:
    """A connection on which nobody stops a job and nobody listens."""

    def poll(self, _: float) -> bool:
        return False

    def send(self, _: object) -> None:
        pass


def answered(asked: Asked, root: Path) -> tuple[Any, ...]:
    """What a worker answers to a request: the object without times, and the plan file; or why it refuses."""
    from kabo.service.worker import Ticker, _worked, solve_work

    problem: dict[str, Any] = {"path": asked.path}
    if asked.rooted:
        _write(asked.files, root)
    else:
        problem["files"] = {name: _inline(data) for name, data in asked.files.items()}
    request = json.dumps({"id": "a", "problem": problem, "options": BUDGET}).encode()
    kind, body, plan = _worked(solve_work, request, root, Ticker(Unhurried(), 600.0))  # type: ignore[arg-type]
    if kind != "done":
        return kind, body, plan
    told = json.loads(body)
    figures = {k: v for k, v in (told["statistics"] or {}).items() if not k.endswith("_s")}
    return json.dumps({**told, "statistics": figures}, sort_keys=True), plan


def _inline(data: bytes) -> Any:
    try:
        return data.decode()
    except UnicodeDecodeError:
        return {"base64": msgspec.json.decode(msgspec.json.encode(data), type=str)}


def _write(files: Files, root: Path) -> None:
    """Makes the root hold these files and no others, all of one date."""
    for old in [each for each in root.rglob("*") if each.is_file()]:
        old.unlink()
    for name, data in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        os.utime(path, ns=(DATE, DATE))


class Nursery:
    """A warm process from which workers are forked."""

    def __init__(self, root: Path) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, child = context.Pipe()
        self._process = context.Process(target=_nurse, args=(child, root))
        self._process.start()
        child.close()

    def life(self, requests: Sequence[Asked]) -> list[tuple[Any, ...]]:
        """What one worker answers to these requests, in their order."""
        self._connection.send(requests)
        return self._connection.recv()

    def close(self) -> None:
        """Ends the process."""
        self._connection.send(None)
        self._process.join(10)


def _nurse(connection: Connection, root: Path) -> None:
    from kabo.service.worker import warm_up

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    warm_up()
    context = multiprocessing.get_context("fork")
    while (requests := connection.recv()) is not None:
        process = context.Process(target=_live, args=(connection, requests, root))
        process.start()
        process.join()
        if process.exitcode != 0:
            connection.send([("died", process.exitcode)])


def _live(connection: Connection, requests: Sequence[Asked], root: Path) -> None:
    connection.send([answered(each, root) for each in requests])
