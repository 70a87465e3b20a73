"""Commands of kabo, run in forks of one process that has loaded kabo and solved a problem before.

Each is as if its process had been started anew, with its own folder, variables, output and exit code, but does not load
Python, libraries and kernels again, which takes ten times as long as many commands do. Tests of starting start processes.
"""

import os
import sys
import tempfile
from collections.abc import Mapping, Sequence
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

_CONTEXT = get_context("forkserver")
_CONTEXT.set_forkserver_preload(["tests.support.loaded_kabo"])


class Done(NamedTuple):
    """What a command did."""

    returncode: int
    stdout: str
    stderr: str


def run_kabo(arguments: Sequence[str], folder: Path, environment: Mapping[str, str], timeout: float) -> Done:
    """Runs a command of kabo in a folder; one that has not ended after `timeout` seconds is an AssertionError."""
    with tempfile.TemporaryDirectory() as kept:
        files = [Path(kept) / name for name in ("stdout", "stderr")]
        process = _CONTEXT.Process(target=_run, args=([*arguments], folder, dict(environment), files))
        process.start()
        process.join(timeout)
        ended = not process.is_alive()
        process.kill()
        process.join()
        code = process.exitcode
        process.close()
        printed = [file.read_text() if file.exists() else "" for file in files]
    assert ended and code is not None, (
        f"kabo {' '.join(arguments)} takes more than {timeout} s\n{''.join(printed)}"
    )
    return Done(code, *printed)


def _run(arguments: list[str], folder: Path, environment: dict[str, str], files: Sequence[Path]) -> None:
    """Runs the command in this process, which is its own."""
    from kabo.cli.main import main

    for number, file in enumerate(files, 1):
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT)
        os.dup2(descriptor, number)
        os.close(descriptor)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["kabo", *arguments]
    sys.exit(main())
