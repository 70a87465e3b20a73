"""Runs cases of formats, each in a process of its own, so that a crash in a C++ library is a find and no end."""

import multiprocessing
import os
import tempfile
from collections.abc import Iterable
from functools import partial
from pathlib import Path

from tests.fuzz.formats import FORMATS, Workspace
from tests.fuzz.judging import Find, judged


def counts(total: int, names: Iterable[str] = tuple(FORMATS)) -> dict[str, int]:
    """How many files of each format make up a total."""
    shares = {name: FORMATS[name].share for name in names}
    whole = sum(shares.values())
    return {name: max(1, round(total * share / whole)) for name, share in shares.items()}


def run(name: str, numbers: range, folder: Path, *, kept: Path | None = None) -> list[Find]:
    """The finds among some cases of a format, in this process; files that led to them are written to `kept`."""
    workspace, format = Workspace(folder), FORMATS[name]
    finds: list[Find] = []
    at = folder / "at"
    for number in numbers:
        seed, content = workspace.case(format, number)
        at.write_text(str(number))
        what = judged(partial(workspace.read, format, seed, content, number))
        if what is None:
            continue
        finds.append(Find(name, number, what))
        if kept is not None:
            kept.mkdir(parents=True, exist_ok=True)
            (kept / f"{name}-{number}-{seed.target.name}").write_bytes(content)
    return finds


def run_apart(name: str, numbers: range, *, kept: Path | None = None) -> list[Find]:
    """As `run`, in a fork; if it dies, the case that killed it is a find, and the rest goes on behind it."""
    finds: list[Find] = []
    while len(numbers):
        with tempfile.TemporaryDirectory() as folder:
            context = multiprocessing.get_context("fork")
            ours, theirs = context.Pipe(duplex=False)
            child = context.Process(target=_child, args=(name, numbers, Path(folder) / "work", kept, theirs))
            child.start()
            theirs.close()
            try:
                finds += ours.recv()
                numbers = numbers[len(numbers) :]
            except EOFError:
                number = int((Path(folder) / "work" / "at").read_text())
                child.join()
                finds.append(Find(name, number, f"the process ended with {child.exitcode}"))
                numbers = range(number + 1, numbers.stop)
            child.join()
    return finds


def _child(name: str, numbers: range, folder: Path, kept: Path | None, answer) -> None:  # type: ignore[no-untyped-def]
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # what C++ libraries say on their own
    answer.send(run(name, numbers, folder, kept=kept))
