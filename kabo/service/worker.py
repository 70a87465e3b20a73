"""The worker process: gets one job at a time through a pipe and answers it; zenoh is never loaded here.

The process is spawned, so it shares no state with the server. It ends by itself when the server has ended, even in the
middle of a long kernel call. It sends the messages `ready` (for the first time after warming up), `progress`, `follow`, and
for each job one of `done`, `stopped`, `refused` and `failed`.

Its answer is a function of the request's bytes: what it keeps from one job to the next is keyed by content
[kabo.content_cache], and garbage is collected and memory given back between jobs [docs/decisions/026-worker-purity.md].
"""

import gc
import importlib
import os
import signal
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path

import msgspec

from kabo.errors import missing_library
from kabo.free_memory import give_back
from kabo.frozen_gc import frozen_gc
from kabo.planner.result import Progress
from kabo.requests import solve_file
from kabo.service import inline
from kabo.service.following import Following
from kabo.service.messages import ProblemFiles, SolveRequest, Unreadable, read, said

STOP = b"stop"
TICK_S = 0.02


class Stopped(Exception):
    """The job was stopped at a check, for the reason "cancelled" or "deadline"."""


class RequestRefused(Exception):
    """The request cannot be worked on, for the reason `code`."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code


class Ticker:
    """The callbacks of a job, which send its progress and check, at most every 20 ms, whether it must stop."""

    def __init__(self, connection: Connection, remaining_s: float) -> None:
        self._connection = connection
        self.deadline = time.monotonic() + remaining_s
        self._next = 0.0
        self._next_progress = 0.0
        self.stopped: str | None = None

    def remaining(self) -> float:
        """Seconds left until the deadline."""
        return max(0.0, self.deadline - time.monotonic())

    def cancelled(self) -> bool:
        """Whether the job must stop; then `stopped` says why."""
        now = time.monotonic()
        if self.stopped is None and now >= self._next:
            self._next = now + TICK_S
            if self._connection.poll(0):
                self._connection.recv()
                self.stopped = "cancelled"
            elif now > self.deadline:
                self.stopped = "deadline"
        return self.stopped is not None

    def check(self) -> None:
        """Checks that the job may go on.

        Raises:
            Stopped: the job must stop.
        """
        if self.cancelled():
            assert self.stopped is not None
            raise Stopped(self.stopped)

    def progress(self, progress: Progress) -> None:
        """Sends the progress of the job, at most every 20 ms but for lines of their own."""
        now = time.monotonic()
        if now >= self._next_progress or progress.line:
            self._next_progress = now + TICK_S
            self._connection.send(("progress", msgspec.json.encode(asdict(progress)), None))

    def follow(self, message: bytes, plan: bytes | None) -> None:
        """Sends a message to those who follow the job."""
        self._connection.send(("follow", message, plan))


Begin = Callable[[], None]  # can be pickled
Work = Callable[[bytes, Path | None, Ticker], tuple[bytes, bytes | None]]


def solve_work(request: bytes, root: Path | None, ticker: Ticker) -> tuple[bytes, bytes | None]:
    """Works on a request to solve: the JSON of the reply, and the plan file's bytes if there is a plan.

    Raises:
        RequestRefused: the request cannot be read, or names files that it may not access.
        Stopped: the job was cancelled, or its deadline has passed.
    """
    try:
        message = read(SolveRequest, request)
        with _problem_in(message.problem, root, ticker) as (path, domain):
            following = Following(ticker.follow)

            def cancelled() -> bool:
                following.look()
                return ticker.cancelled()

            answer = solve_file(
                path,
                said(message.options),
                domain=domain,
                within=Path(),
                progress=ticker.progress,
                cancelled=cancelled,
                on_found=following.found,
                on_procedures=following.procedures,
            )
    except Unreadable as error:
        raise RequestRefused("bad_request", str(error)) from None
    if ticker.stopped is not None:
        raise Stopped(ticker.stopped)
    return msgspec.json.encode({**answer.body, "id": message.id}), answer.plan


@contextmanager
def _problem_in(problem: ProblemFiles, root: Path | None, ticker: Ticker) -> Iterator[tuple[Path, Path | None]]:
    """The files of a problem and of its domain (or None), by paths from the current folder, in which they all lie.

    Raises:
        RequestRefused: the request names files that it may not.
        Unreadable: it is not clear which file is the problem, or a file cannot be written.
        Stopped: the job was cancelled, or its deadline has passed.
    """
    with tempfile.TemporaryDirectory(prefix="kabo-", ignore_cleanup_errors=True) as own:
        try:
            if problem.files is not None:
                folder, path = Path(own), inline.unpack_problem(problem, Path(own), ticker.check)
            elif problem.path is not None and root is not None:
                folder, path = root, inline.below(root, problem.path)
            else:
                code = "bad_request" if problem.path is None else "forbidden"
                raise RequestRefused(code, "this server reads no paths: send all files in `$.problem.files`")
            domain = None if problem.domain is None else Path(inline.below(folder, problem.domain))
        except inline.Forbidden as error:
            raise RequestRefused("forbidden", str(error)) from None
        ticker.check()
        with _working_in(folder):
            yield Path(path), domain


def warm_up() -> None:
    """Loads and compiles the code that requests need, and fills caches of constant values."""
    from kabo.service.warming import plan_once  # the server imports this module, too, and plans nothing

    plan_once()


@contextmanager
def _working_in(folder: Path) -> Iterator[None]:
    """Makes `folder` the current folder, so that findings name files as the client does; no other thread plans here."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def worker_main(connection: Connection, work_name: str, root: Path | None, begin: Begin | None = None) -> None:
    """The main function of a worker: `work_name` is `module:function`, of the type `Work`.

    A function `warm_up` of that module is called first, then `begin`, each once.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's business
    threading.Thread(target=_end_with_the_server, daemon=True).start()
    module, _, function = work_name.partition(":")
    loaded = importlib.import_module(module)
    work: Work = getattr(loaded, function)
    _warmed(getattr(loaded, "warm_up", None))
    if begin is not None:
        begin()
    try:
        with frozen_gc():  # collections between jobs pass over what was there before the first
            while True:
                connection.send(("ready", None, None))
                _answer_one(connection, work, root)
                _tidy()
    except (EOFError, OSError):
        return  # the server has ended


def _warmed(warm_up: Callable[[], None] | None) -> None:
    """Calls `warm_up`, and tidies up after it."""
    try:
        if warm_up is not None:
            warm_up()
    except Exception:  # noqa: BLE001 - the outer edge of a worker; requests that meet the same will say so
        traceback.print_exc()
    _tidy()


def _answer_one(connection: Connection, work: Work, root: Path | None) -> None:
    """Waits for a job and answers it; no reference to the job remains afterwards."""
    while (job := connection.recv()) == STOP:  # a request to stop that came after the last job had ended
        pass
    request, remaining_s = job
    connection.send(_worked(work, request, root, Ticker(connection, remaining_s)))


def _tidy() -> None:
    """Collects garbage and gives memory back: each job leaves megabytes of cycles, made by parsers of meshes."""
    gc.collect()
    give_back()


def _worked(
    work: Work, request: bytes, root: Path | None, ticker: Ticker
) -> tuple[str, bytes | str, bytes | str | None]:
    try:
        return ("done", *work(request, root, ticker))
    except Stopped as stopped:
        return "stopped", str(stopped), None
    except RequestRefused as refused:
        return "refused", refused.code, str(refused)
    except (EOFError, BrokenPipeError):
        raise
    except Exception as error:  # noqa: BLE001 - the outer edge of a worker
        remedy = missing_library(error)
        if remedy is None:
            traceback.print_exc()
        return "failed", remedy or f"a defect of kabo: {type(error).__name__}: {error}", None


def _end_with_the_server() -> None:
    server = parent_process()
    if server is not None:
        wait([server.sentinel])
        os._exit(1)
