"""Runs a command in a child process, shows what it does, and ends it at its limits, whatever it does.

The child ends by itself when it checks its stop flag. Code that checks no stop flag (libraries, compilers, files on a
slow disk) is killed by the parent a little later. The parent keeps the terminal, handles Ctrl-C and Ctrl-Z, and keeps a
found plan until the child has written it.
"""

import argparse
import os
import signal
import sys
from collections.abc import Callable, Mapping
from contextlib import nullcontext, suppress
from math import inf
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from time import perf_counter
from typing import Any

from kabo.budgets import default_memory, held_bytes, process_began
from kabo.children import end_with_parent, ended_by, made_in_child
from kabo.cli import exit_codes, rooms
from kabo.cli.terminal import clean_standard_output, complain, print_json, tell
from kabo.cli.waiting.display import Display, draws_rows
from kabo.cli.waiting.doing import Doing
from kabo.cli.waiting.surrounding import STAYS_QUIET_S, ChildSurrounding, apart
from kabo.compilation import usual_kernels_compiled
from kabo.errors import KaboError
from kabo.phases import heard_by

GRACE_S = 0.15  # from a limit until the child is killed
INTERRUPTED_S = 2.0  # from Ctrl-C until the child is killed
KILLED_ABOVE = 1.1  # times the memory limit
POLL_S, MEMORY_POLL_S = 0.05, 0.25  # between two looks at the clock, and at the memory
HANDLED = (signal.SIGINT, signal.SIGTSTP)  # by the parent; blocked while the child is made
COMPILING = Doing("compiling kernels", "compiling kernels, once for this installation")


def limited(options: argparse.Namespace, run: Callable[[argparse.Namespace], int]) -> int:
    """Runs a command within its limits, in a child process; returns the exit code."""
    try:
        compiling = _compiled_first(options)
    except KeyboardInterrupt:
        complain("kabo: interrupted while compiling; what is compiled is kept")
        return exit_codes.INTERRUPTED
    began, parent = process_began() + compiling, os.getpid()  # importing kabo took time as well
    options.memory = default_memory() if options.memory is None else options.memory
    here, there = Pipe()
    sys.stdout.flush()
    sys.stderr.flush()
    watch = _Watch(here, options, began)
    before = {number: signal.signal(number, act) for number, act in watch.signals().items()}
    try:
        signal.pthread_sigmask(signal.SIG_BLOCK, HANDLED)  # until parent and child have their handlers
        child = os.fork()
        if child == 0:
            here.close()
            options.surrounding = ChildSurrounding(there, began)
            _work(options, run, parent, before)
        there.close()
        return watch.exit_code(child)
    finally:
        for number, act in before.items():
            signal.signal(number, act)


def _compiled_first(options: argparse.Namespace) -> float:
    """The seconds that were spent on compiling kernels, in a process of its own, before the command's clock starts.

    A command whose `needs_kernels` says so waits for this once for each installation; after that it takes none.
    """
    needs = getattr(options, "needs_kernels", None)
    if needs is None or usual_kernels_compiled() or not needs(options):
        return 0.0
    tell("kabo: compiling kernels, which takes some minutes, once; --timeout counts from then on")
    began = perf_counter()
    display = Display(began)
    display.show(COMPILING)

    def make() -> None:
        with clean_standard_output():
            rooms.compile_usual()

    # It may die: then kernels are compiled when they are first used, and faults are told there.
    with suppress(KaboError):
        made_in_child(make, display.tick)
    display.erase()
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
        around: ChildSurrounding = options.surrounding
        with heard_by(around.phase), apart(around) if draws_rows() else nullcontext():
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
        self.display = Display(began)
        self.found: tuple[dict[str, Any], bytes] | None = None
        self.known: tuple[dict[str, Any], str] | None = None
        self._weighed = began

    def exit_code(self, child: int) -> int:
        """Waits for the child, or kills it at a limit and reports that; returns the exit code."""
        self.child = child
        if self.interrupted is not None:
            self._send(signal.SIGINT)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, HANDLED)
        try:
            why = self._watched()
        finally:
            self.display.erase()
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
            self.display.erase()
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

    def _watched(self) -> str | None:
        """None when the child has ended; otherwise the limit that it has exceeded."""
        while True:
            self.display.tick()
            try:
                if self.channel.poll(POLL_S):
                    self._take(self.channel.recv())
            except (EOFError, OSError):
                os.waitid(os.P_PID, self.child, os.WEXITED | os.WNOWAIT)
                return None
            if os.waitid(os.P_PID, self.child, os.WEXITED | os.WNOWAIT | os.WNOHANG) is not None:
                self._rest()
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

    def _rest(self) -> None:
        try:
            while self.channel.poll(0):
                self._take(self.channel.recv())
        except (EOFError, OSError):
            return

    def _take(self, message: tuple[Any, Any, Any]) -> None:
        kind, first, second = message
        if kind == "found":
            self.found = dict(first), second
        elif kind == "known":
            self.known = dict(first), second
        elif kind == "quiet":
            self.display.erase(2.0 * STAYS_QUIET_S)
            with suppress(OSError):  # it has ended meanwhile
                self.channel.send(None)
        else:
            self.display.show(first)
            if second:
                self.display.erase()
                tell(second)

    def _cut_off(self, why: str | None, status: int) -> int:
        """Reports what was cut off; a plan that was found is written all the same."""
        if why is None:
            said = f"the process that worked was ended by {ended_by(status)}, while {self.display.doing.said}"
            code, spent = exit_codes.DEFECT, None
        else:
            ended = "interrupted" if why == "interrupted" else f"{why} exhausted"
            said, spent = (
                f"cut off while {self.display.doing.said} ({ended})",
                "time" if why == "interrupted" else why,
            )
            code = exit_codes.INTERRUPTED if why == "interrupted" else exit_codes.NO_PLAN
        if self.found is not None:
            body, plan = self.found
            write: Callable[..., int] = self.options.write_found
            return write({**body, "cut_off": [f"{said}: the plan is as it was found"]}, plan, self.options)
        if (keeps := getattr(self.options, "cut_off_with_trials", None)) is not None:
            return int(keeps(self.options, why, said))
        told = getattr(self.options, "cut_off", None)
        if told is not None and spent is not None:
            answered: int | None = told(self.options, spent, said, self.known)
            if answered is not None:  # else nothing is known
                return answered
        complain(f"kabo: {said}; nothing was written")
        if getattr(self.options, "json", False):
            print_json({"code": "failed" if spent is None else "cut_off", "message": said})
        return code
