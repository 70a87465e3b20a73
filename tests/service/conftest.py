"""Real server processes on loopback, each on a free port, ended with the test."""

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from kabo.service import Client, client_config

STUB = "tests.service.stub_work:work"
REPOSITORY = Path(__file__).parents[2]


@dataclass
class Running:
    """A server process, where it listens, and its name."""

    process: subprocess.Popen[str]
    endpoint: str
    name: str

    def client(self, **options: float) -> Client:
        """A client of this server."""
        return Client(client_config([self.endpoint]), **options)

    def workers(self) -> list[int]:
        """The process ids of its workers (spawned children of multiprocessing)."""
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                parent = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
                command = (folder / "cmdline").read_bytes()
            except (OSError, IndexError):
                continue
            if parent == self.process.pid and b"spawn_main" in command:
                found.append(int(folder.name))
        return found


def free_endpoint() -> str:
    """A loopback endpoint that nobody listens on just now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@pytest.fixture
def serve() -> Iterator[Callable[..., Running]]:
    """Starts servers: `serve(workers=2, bound=64, work=STUB, endpoint=None)`."""
    started: list[Running] = []

    def start(workers: int = 2, bound: int = 64, work: str = STUB, endpoint: str | None = None) -> Running:
        endpoint = endpoint or free_endpoint()
        script = str(Path(__file__).with_name("serving.py"))
        process = subprocess.Popen(
            [sys.executable, script, endpoint, str(workers), str(bound), work],
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        assert process.stdout is not None
        started.append(Running(process, endpoint, process.stdout.readline().strip()))
        return started[-1]

    yield start
    for running in started:
        if running.process.poll() is None:
            os.killpg(running.process.pid, signal.SIGKILL)
        running.process.wait()
        assert running.process.stdout is not None
        running.process.stdout.close()
