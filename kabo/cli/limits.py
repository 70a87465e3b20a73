"""The limits of a command, in time and memory, and the process that enforces them whatever the command does.

When kabo runs as a program, a command with limits runs in a child process, which ends by itself when it checks its
stop flag. Code that checks no stop flag (libraries, compilers, files on a slow disk) is killed by the parent a
little later. The parent keeps the terminal, handles Ctrl-C and Ctrl-Z, and keeps a found plan until the child has
written it.
"""

import argparse
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from math import inf, isfinite
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from time import perf_counter
from typing import Any

from kabo.budgets import default_memory, held_bytes, process_began
from kabo.children import end_with_parent, ended_by, made_in_child
from kabo.cli import exit_codes, rooms
from kabo.cli.terminal import clean_standard_output, described, print_json, shown_text, tell
from kabo.compilation import usual_kernels_compiled
from kabo.errors import KaboError

GRACE_S = 0.15  # from a limit until the child is killed
REPORT_S, REPORT_SHARE = 1.0, 0.02  # kept of a limit for saying what was found out: at most, and as a share of it
INTERRUPTED_S = 2.0  # from Ctrl-C until the child is killed
KILLED_ABOVE = 1.1  # times the memory limit
POLL_S, MEMORY_POLL_S = 0.05, 0.25  # between two looks at the clock, and at the memory
UNITS = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40}
NO_LIMIT = ("none", "0")
HANDLED = (signal.SIGINT, signal.SIGTSTP)  # by the parent; blocked while the child is made

OnFound = Callable[[Mapping[str, Any], bytes], None]


def add_limits(parser: argparse.ArgumentParser, default: str = "none") -> None:
    """Adds `--timeout` and `--memory`, the same for every command; `default` describes the timeout if none is given."""
    parser.add_argument(
        "--timeout",
        type=seconds,
        metavar="S",
        help=f"seconds after which the command ends, whatever it does; none: without limit (default: {default})",
    )
    parser.add_argument(
        "--memory",
        type=memory,
        metavar="SIZE",
        help="memory that the command may hold, as 500M or 4G; none: without limit (default: half of what there is)",
    )
    parser.set_defaults(surrounding=Surrounding())


def seconds(text: str) -> float:
    """Converts text to a number of seconds; `none` and 0 become infinity, and negative numbers are rejected."""
    value = inf if text in NO_LIMIT else _number(text)
    if value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0, or none")
    return value


def memory(text: str) -> float:
    """Converts text to a number of bytes; it may end with K, M, G or T; `none` and 0 become infinity."""
    if text in NO_LIMIT:
        return inf
    found = re.fullmatch(r"([\d.]+)\s*([kmgt]?)i?b?", text.strip(), re.IGNORECASE)
    value = None if found is None else _number(found[1])
    if found is None or value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size: write 500M, 4G or none")
    return value * UNITS[found[2].lower()]


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None


class Surrounding:
    """The environment of a running command: remaining time, progress display, callback for a found plan."""

    def __init__(self) -> None:
        self.began = perf_counter()

    def left(self, timeout: float | None) -> float | None:
        """The seconds of `timeout` that are left for working, at least a millisecond; None if `timeout` is None.

        Some are kept for the report: a command that is killed cannot say what it found out.
        """
        if timeout is None:
            return None
        return max(1e-3, timeout - min(REPORT_S, REPORT_SHARE * timeout) - (perf_counter() - self.began))

    @contextmanager
    def reporting(self) -> "Iterator[Callable[[rooms.Progress], None]]":
        """A context with a function that shows progress: on a terminal all of it, else only what has a line of its own."""
        with shown_text() as show:

            def report(progress: "rooms.Progress") -> None:
                if show is not None:
                    show(described(progress))
                if progress.line:
                    tell(progress.line)

            yield report

    def preparing(self, state: "rooms.Preparing") -> None:
        """Shows the progress of a preparation, whose lines stay."""
        if state.line:
            tell(state.line)

    @contextmanager
    def showing(self, doing: str) -> "Iterator[Callable[[str], None] | None]":
        """As `reporting`, for progress that is text already; `doing` says what is cut off if it is."""
        with shown_text() as show:
            yield show

    def on_found(self) -> OnFound | None:
        """A callback that receives the answer and the plan file once a plan is found; None if not needed."""
        return None

    def on_known(self, body: Mapping[str, Any], text: str) -> None:
        """Keeps an answer as far as it is known, as an object and as text, for when the command is cut off."""


class _ChildSurrounding(Surrounding):
    """The surroundings of a command in a child process: the parent shows progress and holds a found plan."""

    def __init__(self, channel: Connection, began: float) -> None:
        self.began, self._channel = began, channel

    @contextmanager
    def reporting(self) -> "Iterator[Callable[[rooms.Progress], None]]":
        def report(progress: "rooms.Progress") -> None:
            self._send(progress.doing, described(progress), progress.line)

        yield report

    def preparing(self, state: "rooms.Preparing") -> None:
        self._send(str(state), str(state), state.line)

    def _send(self, doing: str, text: str, line: str) -> None:
        self._channel.send(("doing", doing, text, line))  # as one message: a cut shows all of it or nothing

    @contextmanager
    def showing(self, doing: str) -> "Iterator[Callable[[str], None] | None]":
        yield lambda text: self._send(doing, text, "")

    def on_found(self) -> OnFound | None:
        return lambda body, plan: self._channel.send(("found", body, plan, ""))

    def on_known(self, body: Mapping[str, Any], text: str) -> None:
        self._channel.send(("known", body, text, ""))


def limited(options: argparse.Namespace, run: Callable[[argparse.Namespace], int]) -> int:
    """Runs a command within its limits, in a child process; returns the exit code."""
    try:
        compiling = _compiled_first(options)
    except KeyboardInterrupt:
        tell("kabo: interrupted while compiling; what is compiled is kept")
        return exit_codes.INTERRUPTED
    began, parent = process_began() + compiling, os.getpid()  # importing kabo took time as well
    options.memory = default_memory() if options.memory is None else options.memory
    here, there = Pipe(duplex=False)
    sys.stdout.flush()
    sys.stderr.flush()
    watch = _Watch(here, options, began)
    before = {number: signal.signal(number, act) for number, act in watch.signals().items()}
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, HANDLED)  # until parent and child have their handlers
        child = os.fork()
        if child == 0:
            here.close()
            options.surrounding = _ChildSurrounding(there, began)
            _work(options, run, parent, before)
        there.close()
        return watch.exit_code(child)
    finally:
        for number, act in before.items():
            signal.signal(number, act)


def _compiled_first(options: argparse.Namespace) -> float:
    """The seconds that were spent on compiling kernels, in a process of its own, before the command's clock starts.

    A command whose `needs_kernels` says so waits for this once for each version and machine; after that it takes none.
    """
    needs = getattr(options, "needs_kernels", None)
    if needs is None or usual_kernels_compiled() or not needs(options):
        return 0.0
    tell("kabo: compiling kernels, which takes a minute or two, once; --timeout counts from then on")
    began = perf_counter()

    def make() -> None:
        with clean_standard_output():
            rooms.compile_usual()

    with suppress(
        KaboError
    ):  # it died: then kernels are compiled when they are first used, and faults are told there
        made_in_child(make)
    return perf_counter() - began


def _work(
    options: argparse.Namespace,
    run: Callable[[argparse.Namespace], int],
    parent: int,
    handlers: Mapping[signal.Signals, Any],
) -> None:
    """Runs the child, with the signal handlers that the parent had before; never returns."""
    code = exit_codes.DEFECT
    try:
        for number, act in handlers.items():
            signal.signal(number, act)
        os.setpgid(0, 0)  # the parent handles Ctrl-C
        signal.signal(signal.SIGTTOU, signal.SIG_IGN)
        end_with_parent(parent)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HANDLED)
        code = run(options)
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:
        code = exit_codes.DONE
    finally:
        os._exit(code)


class _Watch:
    """The parent's watch over the child: what it does, the plan that it has found, and when to kill it."""

    def __init__(self, channel: Connection, options: argparse.Namespace, began: float) -> None:
        self.child, self.channel, self.options = 0, channel, options
        self.deadline = began + (inf if options.timeout is None else options.timeout)
        self.interrupted: float | None = None  # when Ctrl-C was pressed
        self.doing = "working"
        self.found: tuple[dict[str, Any], bytes] | None = None
        self.known: tuple[dict[str, Any], str] | None = None
        self._weighed = began

    def exit_code(self, child: int) -> int:
        """Waits for the child, or kills it at a limit and reports that; returns the exit code."""
        self.child = child
        if self.interrupted is not None:
            self._send(signal.SIGINT)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HANDLED)
        with shown_text() as show:
            why = self._watched(show)
        if why is not None:
            self._kill()
        _, status = os.waitpid(self.child, 0)
        if why is None and not os.WIFSIGNALED(status):
            return os.waitstatus_to_exitcode(status)
        return self._cut_off(why, status)

    def signals(self) -> dict[signal.Signals, Callable[[int, Any], None]]:
        """The handlers of signals, before there is a child and while it runs."""

        def interrupt(_: int, __: Any) -> None:
            self.interrupted = self.interrupted or perf_counter()
            self._send(signal.SIGINT)

        def pause(_: int, __: Any) -> None:
            self._send(signal.SIGSTOP)
            os.kill(os.getpid(), signal.SIGSTOP)
            self._send(signal.SIGCONT)

        return {signal.SIGINT: interrupt, signal.SIGTSTP: pause}

    def _send(self, number: signal.Signals) -> None:
        if self.child:
            with suppress(ProcessLookupError):
                os.kill(self.child, number)

    def _kill(self) -> None:
        for end in (os.killpg, os.kill):  # the child may not have a group of its own yet
            with suppress(ProcessLookupError, PermissionError):
                end(self.child, signal.SIGKILL)

    def _watched(self, show: Callable[[str], None] | None) -> str | None:
        """None when the child has ended; otherwise the limit that it has exceeded."""
        while True:
            try:
                if self.channel.poll(POLL_S):
                    self._take(self.channel.recv(), show)
            except (EOFError, OSError):
                os.waitid(os.P_PID, self.child, os.WEXITED | os.WNOWAIT)
                return None
            if os.waitid(os.P_PID, self.child, os.WEXITED | os.WNOWAIT | os.WNOHANG) is not None:
                self._rest(show)
                return None
            now = perf_counter()
            if now > self.deadline + GRACE_S:
                return "time"
            if self.interrupted is not None and now > self.interrupted + INTERRUPTED_S:
                return "interrupted"
            if now > self._weighed + MEMORY_POLL_S:
                self._weighed = now
                if held_bytes(self.child, KILLED_ABOVE * self.options.memory) > KILLED_ABOVE * self.options.memory:
                    return "memory"

    def _rest(self, show: Callable[[str], None] | None) -> None:
        try:
            while self.channel.poll(0):
                self._take(self.channel.recv(), show)
        except (EOFError, OSError):
            return

    def _take(self, message: tuple[Any, ...], show: Callable[[str], None] | None) -> None:
        kind, first, second, line = message
        if kind == "found":
            self.found = dict(first), second
            return
        if kind == "known":
            self.known = dict(first), second
            return
        self.doing = first
        if show is not None:
            show(second)
        if line:
            tell(line)

    def _cut_off(self, why: str | None, status: int) -> int:
        """Reports what was cut off; a plan that was found is written all the same."""
        if why is None:
            said = f"the process that worked was ended by {ended_by(status)}, while {self.doing}"
            code, spent = exit_codes.DEFECT, None
        else:
            ended = "interrupted" if why == "interrupted" else f"{why} exhausted"
            said, spent = f"cut off while {self.doing} ({ended})", "time" if why == "interrupted" else why
            code = exit_codes.INTERRUPTED if why == "interrupted" else exit_codes.NO_PLAN
        if self.found is not None:
            body, plan = self.found
            write: Callable[..., int] = self.options.write_found
            return write({**body, "cut_off": [f"{said}: the plan is as it was found"]}, plan, self.options)
        if (keeps := getattr(self.options, "cut_off_with_trials", None)) is not None:
            return int(keeps(self.options, why, said))
        told = getattr(self.options, "cut_off", None)
        if told is not None and spent is not None:
            return int(told(self.options, spent, said, self.known))
        tell(f"kabo: {said}; nothing was written")
        if getattr(self.options, "json", False):
            print_json({"code": "failed" if spent is None else "cut_off", "message": said})
        return code
