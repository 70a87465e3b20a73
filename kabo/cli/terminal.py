"""Terminal input and output of all commands: messages, progress, Ctrl-C, standard output with the answer only.

Standard output carries the answer only (the plan's tree, or one JSON object); all else goes to standard error.
"""

import json
import os
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from kabo.cli import rooms


def tell(text: str) -> None:
    """Prints a message on standard error."""
    print(text, file=sys.stderr)


def print_json(answer: Mapping[str, Any]) -> None:
    """Prints the answer of a command as one JSON object, as `--json` requests it."""
    print(json.dumps(answer, sort_keys=True, ensure_ascii=False, allow_nan=False))


@contextmanager
def shown_text() -> Iterator["Callable[[str], None] | None"]:
    """A context with a function that shows text in one line of the terminal; None if there is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    bar: list[
        Any
    ] = []  # made with the first text: most commands have none to show, and rich takes a while to load

    def show(text: str) -> None:
        if not bar:
            bar.extend(_started_bar())
        bar[0].update(bar[1], description=text)

    try:
        yield show
    finally:
        if bar:
            bar[0].stop()


def _started_bar() -> tuple[Any, Any]:
    from rich import console, progress  # most commands show no bar, and rich takes a while to load

    columns = (progress.SpinnerColumn(), progress.TextColumn("{task.description}"), progress.TimeElapsedColumn())
    made = progress.Progress(*columns, console=console.Console(stderr=True), transient=True)
    made.start()
    return made, made.add_task("loading")


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """A context with a function that returns whether Ctrl-C was pressed; a second Ctrl-C aborts the command."""
    pressed: list[int] = []

    def note(number: int, frame: object) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)
        tell("kabo: ending with what there is so far; press Ctrl-C again to abort")

    try:
        before = signal.signal(signal.SIGINT, note)
    except ValueError:  # not the main thread
        yield lambda: False
        return
    try:
        yield lambda: bool(pressed)
    finally:
        signal.signal(signal.SIGINT, before)


def described(progress: "rooms.Progress") -> str:
    """Progress as a line of text: `searching: 120 nodes expanded, 340 generated, 12 procedure calls`."""
    if progress.fraction is not None:
        return progress.doing
    done = f"{progress.doing}: {progress.expanded} nodes expanded, {progress.generated} generated"
    return f"{done}, {progress.procedure_calls} procedure calls" if progress.procedure_calls else done


@contextmanager
def clean_standard_output() -> Iterator[None]:
    """A context in which everything that C and C++ libraries write to standard output goes to standard error."""
    try:
        out = sys.stdout.fileno()
    except (OSError, ValueError):  # a test captures standard output without a descriptor
        yield
        return
    sys.stdout.flush()
    kept = os.dup(out)
    os.dup2(2, out)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, out)
        os.close(kept)
