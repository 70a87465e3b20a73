"""Robot servers and clients in processes of their own, and an observer that hears what servers publish.

Limits of silence are generous, since machines are busy; only what must not be noticed by silence has a low one.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import msgspec
import pytest

from kabo.plan import Plan, write_plan
from kabo.remote import StateMessage
from kabo.service import client_config, keys, open_session
from tests.execution.conftest import stacked_plan, stacked_scene
from tests.service.conftest import free_endpoint

__all__ = ["stacked_plan", "stacked_scene"]
REPOSITORY = Path(__file__).parents[2]
PROBLEM = REPOSITORY / "domains" / "stacked" / "n2.yaml"
PATIENCE_S = 120.0  # of a busy machine


@dataclass
class Started:
    """A process of `kabo`, what it has said on standard error, and where it listens if it is a robot server."""

    process: "subprocess.Popen[str]"
    endpoint: str = ""
    said: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        self.said.extend(self.process.stderr)

    def wait_for(self, text: str) -> None:
        until(lambda: any(text in line for line in self.said) or self.process.poll() is not None)
        assert any(text in line for line in self.said), self.said

    def send(self, number: signal.Signals) -> None:
        """Sends a signal to the process and to its children: a command with limits works in one."""
        for pid in (self.process.pid, *children_of(self.process.pid)):
            os.kill(pid, number)

    def end(self) -> tuple[int, str]:
        code = self.process.wait(PATIENCE_S)
        self._reading.join(PATIENCE_S)
        return code, "".join(self.said)


def children_of(pid: int) -> list[int]:
    """The processes below a process."""
    folder = Path(f"/proc/{pid}/task/{pid}/children")
    own = [int(each) for each in folder.read_text().split()]
    return [*own, *(each for child in own for each in children_of(child))]


def until(happened: Callable[[], bool]) -> None:
    """Waits until something has happened."""
    end = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < end, "it does not happen"
        time.sleep(0.01)


@pytest.fixture
def kabo_process(program: Callable[..., Started]) -> Callable[..., Started]:
    """Starts `kabo` with arguments."""
    return partial(program, "-m", "kabo.cli")


@pytest.fixture
def program() -> Iterator[Callable[..., Started]]:
    """Starts Python with arguments; what still runs in the end is killed, stopped or not."""
    started: list[Started] = []

    def start(*arguments: object) -> Started:
        process = subprocess.Popen(
            [sys.executable, *map(str, arguments)],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            cwd=REPOSITORY,
            start_new_session=True,
        )
        started.append(Started(process))
        return started[-1]

    yield start
    for each in started:
        if each.process.poll() is None:
            each.send(signal.SIGKILL)
            each.process.wait()


@pytest.fixture
def serve(kabo_process: Callable[..., Started]) -> Callable[..., Started]:
    """Starts robot servers of two blocks without forces: `serve(speed=20, silence=20)`."""

    def start(speed: float = 20.0, silence: float = 20.0) -> Started:
        endpoint = free_endpoint()
        given = ("--kinematic", "--speed", speed, "--silence", silence, "--endpoint", endpoint)
        made = kabo_process("simulate", PROBLEM, "--serve", *given)
        made.wait_for("serves mobile")
        made.endpoint = endpoint
        return made

    return start


@pytest.fixture(scope="session")
def plan_file(stacked_plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("remote") / "plan.json"
    write_plan(stacked_plan, path)
    return path


class Observer:
    """Hears the states that a server publishes."""

    def __init__(self, endpoint: str) -> None:
        self.states: list[StateMessage] = []
        self.session = open_session(client_config([endpoint]))
        self._heard = self.session.declare_subscriber(keys.robot("*", "state"), self._hear)

    def _hear(self, sample: object) -> None:
        self.states.append(msgspec.json.decode(sample.payload.to_bytes(), type=StateMessage))  # type: ignore[attr-defined]

    @property
    def now(self) -> StateMessage:
        return self.states[-1]


@pytest.fixture
def observe() -> Iterator[Callable[[str], Observer]]:
    made: list[Observer] = []

    def start(endpoint: str) -> Observer:
        made.append(Observer(endpoint))
        until(lambda: bool(made[-1].states))
        return made[-1]

    yield start
    for each in made:
        each.session.close()
